"""The cells of an experiment: one solver, one question, one repeat each."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from dubins_study.experiments.definition.experiment import Experiment, ExperimentError
from dubins_study.experiments.plan.block_plan import BlockPlan, block_plans
from dubins_study.experiments.plan.scenario_columns import scenario_id, scenarios
from dubins_study.solvers.protocol import Method
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Key
from dubins_study.study.scenario import Scenario


class Cell(NamedTuple):
    """One question to one solver; all fields up to the code digest form the key of its row."""

    scenario_id: str
    solver: str
    profile: str
    branch: str
    initial_guess: str
    repeat: int
    code_digest: str
    scenario: Scenario
    method: Method

    @property
    def key(self) -> Key:
        """The values of the row's key columns."""
        return self[:7]


# Cells that must be solved in this order: all cells of a warm sweep, or a single cell.
Chain = tuple[Cell, ...]


def chains(experiment: Experiment) -> list[Chain]:
    """All cells of an experiment in the order of its file, grouped into chains.

    A cell that several blocks ask for is listed once.

    Raises:
        ExperimentError: if a block holds a scenario that is not valid, if two sweeps give one warm
            cell different predecessors, or if there are more than `block_plan.MOST_CELLS` cells.
        SolverError: if a solver's spec is not valid.
    """
    unique: dict[tuple[Key, ...], Chain] = {}
    sweeps: dict[Key, str] = {}  # warm cell -> the block whose sweep it is in
    for plan in block_plans(experiment):
        for chain in _block_chains(plan, experiment.profile):
            keys = tuple(cell.key for cell in chain)
            if keys in unique:
                continue
            if chain[0].initial_guess == "warm":
                _add_sweep(sweeps, keys, plan.key)
            unique[keys] = chain
    return list(unique.values())


def _block_chains(plan: BlockPlan, profile: str) -> Iterator[Chain]:
    """The chains of one block."""
    solvers = [solver for solver in plan.solvers if plan.guess_count(solver)]
    if not solvers:
        return
    block_scenarios = list(scenarios(plan.block, plan.key))
    ids = [scenario_id(scenario) for scenario in block_scenarios]
    for solver in solvers:
        guesses = list(plan.guesses(solver))
        for branch, repeat, guess in itertools.product(plan.branches, range(plan.repeats), guesses):
            digest, method = solver.code_digest, solver.method
            cells = (
                Cell(id_, solver.spec, profile, branch, guess, repeat, digest, scenario, method)
                for id_, scenario in zip(ids, block_scenarios, strict=True)
            )
            if guess == "warm":
                yield tuple(cells)
            else:
                yield from ((cell,) for cell in cells)


def _add_sweep(sweeps: dict[Key, str], keys: tuple[Key, ...], block_key: str) -> None:
    """Note the cells of a warm sweep. A cell has one predecessor, so it may be in one sweep only.

    Raises:
        ExperimentError: if a cell is in a sweep already.
    """
    for place, key in enumerate(keys):
        if key in sweeps or key in keys[:place]:
            other = "itself" if key in keys[:place] else sweeps[key]
            raise ExperimentError(
                f"{block_key}, scenario {place}: already swept by {other}; expected every "
                "warm start in one sweep only: give one of the blocks a label of its own"
            )
    sweeps.update(dict.fromkeys(keys, block_key))


def given_guess(cell: Cell) -> Path | None:
    """The path whose lengths the cell's `initial_guess` holds; None for `cold` and `warm`."""
    if cell.initial_guess in ("cold", "warm"):
        return None
    R = cell.scenario.radius
    lengths = [R * float(length) for length in cell.initial_guess.split()]
    return Path(cell.scenario.start, [1 / R, -1 / R, 0.0], lengths)


def shuffled(chain_list: list[Chain], seed: int) -> list[Chain]:
    """The chains in an order drawn from the seed.

    If the machine is slower for a while, this affects cells of all solvers instead of only one.
    """
    order = np.random.default_rng(seed).permutation(len(chain_list))
    return [chain_list[i] for i in order]
