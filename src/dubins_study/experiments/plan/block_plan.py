"""The questions that an experiment asks about each block of scenarios, and their number."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

from dubins_study.experiments.definition.experiment import (
    Experiment,
    ExperimentError,
    ExperimentFile,
)
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.scenario_columns import axis_size, axis_values, block_size
from dubins_study.experiments.plan.solver_description import SolverDescription, describe_solver
from dubins_study.experiments.plan.solver_specs import expand_solvers
from dubins_study.solvers.registry import SolverError

# A cell takes about 700 bytes of memory until its row is written.
MOST_CELLS = 2_000_000


class BlockPlan(NamedTuple):
    """What an experiment asks about the scenarios of one block.

    Args:
        number: the number of the block in the experiment, from 0.
        block: the scenarios.
        branches: the branches that are asked for.
        initial_guesses: `cold`, `warm`, or both; not used where the block has `guess_lengths`.
        repeats: how many times every question is asked.
        solvers: the solvers that are asked.
    """

    number: int
    block: Block
    branches: tuple[str, ...]
    initial_guesses: tuple[str, ...]
    repeats: int
    solvers: tuple[SolverDescription, ...]

    @property
    def key(self) -> str:
        """The key of the block in the experiment's file, for messages."""
        return f"scenarios.{self.number}"

    def guess_count(self, solver: SolverDescription) -> int:
        """Number of initial guesses from which a solver is asked each question."""
        lengths = self.block.guess_lengths
        if lengths is None:
            return sum(solver.warm or guess == "cold" for guess in self.initial_guesses)
        return solver.warm * math.prod(map(axis_size, lengths.axes))

    def guesses(self, solver: SolverDescription) -> Iterator[str]:
        """The initial guesses as the column `initial_guess` holds them.

        Each is `cold`, `warm`, or the lengths z1, z2 and z3 in radii, exact to the last bit.
        """
        lengths = self.block.guess_lengths
        if lengths is None:
            yield from (g for g in self.initial_guesses if g == "cold" or solver.warm)
            return
        if not solver.warm:
            return
        values = (axis_values(axis).tolist() for axis in lengths.axes)
        for point in itertools.product(*values):
            yield " ".join(repr(length) for length in point)


def block_plans(experiment: Experiment) -> list[BlockPlan]:
    """The plans of all blocks of an experiment.

    Raises:
        ExperimentError: if there are more than `MOST_CELLS` cells.
        SolverError: if a solver's spec is not valid.
    """
    plans = [
        _block_plan(number, block, experiment) for number, block in enumerate(experiment.blocks)
    ]
    _check_size(plans)
    return plans


def _block_plan(number: int, block: Block, experiment: Experiment) -> BlockPlan:
    return BlockPlan(
        number,
        block,
        tuple(block.branches or experiment.branches),
        tuple(experiment.initial_guesses),
        experiment.repeats,
        tuple(_solvers(number, block, experiment)),
    )


def _solvers(number: int, block: Block, experiment: Experiment) -> list[SolverDescription]:
    """The solvers of a block.

    Raises:
        SolverError: naming the key, if a spec is not valid, or if the block has `guess_lengths`
            and names a solver that takes no initial guess.
    """
    key, specs = "solvers", experiment.solvers
    if block.solvers is not None:
        key, specs = f"scenarios.{number}.solvers", block.solvers
    try:
        expanded = expand_solvers(specs, experiment.profile)
    except SolverError as error:
        raise SolverError(f"{key}: {error}") from None
    solvers = [describe_solver(spec, experiment.profile) for spec in expanded]
    # `*` selects the solvers that take an initial guess; any other solver named here is a mistake.
    if block.guess_lengths is not None and "*" not in specs:
        for solver in solvers:
            if not solver.warm:
                raise SolverError(
                    f"{key}: {solver.spec} takes no initial guess; expected only solvers that do, "
                    "or *"
                )
    return solvers


def _check_size(plans: list[BlockPlan]) -> None:
    """Refuse an experiment that is too large for the memory, before it is expanded."""
    total = 0
    for plan in plans:
        scenarios = block_size(plan.block)
        guesses = sum(map(plan.guess_count, plan.solvers))
        cells = scenarios * len(plan.branches) * plan.repeats * guesses
        total += cells
        if total > MOST_CELLS:
            raise ExperimentError(
                f"{plan.key}: {scenarios} scenarios and {cells} cells (a cell for every solver, "
                f"branch, initial guess and repeat), {total} cells up to here; expected at most "
                f"{MOST_CELLS} in all"
            )


class Overview(NamedTuple):
    """An experiment in numbers.

    Args:
        name, title, question: as its file has them.
        scenarios: how many there are, counted once for every block that asks about them.
        cells: questions times solvers and repeats; each becomes a row.
        solvers: the canonical specs, each once.
        branches: the branches that are asked for.
        repeats: how often each question is asked.
        time_limit_s: seconds that one solve may take.
        memory_limit_gib: GiB that one solve may hold.
        profile: name of the settings and tolerances.
    """

    name: str
    title: str
    question: str
    scenarios: int
    cells: int
    solvers: tuple[str, ...]
    branches: tuple[str, ...]
    repeats: int
    time_limit_s: float
    memory_limit_gib: float
    profile: str


def overview(file: ExperimentFile) -> Overview:
    """An experiment in numbers.

    Raises:
        ExperimentError, SolverError: if it is too large, or names a solver that does not exist.
    """
    experiment, plans = file.experiment, block_plans(file.experiment)
    cells = 0
    for plan in plans:
        solver_guesses = sum(map(plan.guess_count, plan.solvers))
        cells += block_size(plan.block) * len(plan.branches) * plan.repeats * solver_guesses
    specs = (solver.spec for p in plans for solver in p.solvers)
    return Overview(
        name=file.name,
        title=experiment.title,
        question=experiment.question,
        scenarios=sum(block_size(block) for block in experiment.scenarios),
        cells=cells,
        solvers=tuple(dict.fromkeys(specs)),
        branches=tuple(dict.fromkeys(branch for p in plans for branch in p.branches)),
        repeats=experiment.repeats,
        time_limit_s=experiment.time_limit_s,
        memory_limit_gib=experiment.memory_limit_gib,
        profile=experiment.profile,
    )
