"""The cells of an experiment.

A cell is one solver, one question and one repeat.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from dubins_study.experiments.definition.experiment import (
    Experiment,
    ExperimentError,
    ExperimentFile,
)
from dubins_study.experiments.definition.messages import KeyPath, Problem, refusal
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.questions import asked_scenarios
from dubins_study.experiments.plan.scenarios import block_size, scenario_id
from dubins_study.experiments.plan.solver_description import (
    SolverDescription,
    describe_solver,
    expand_solvers,
)
from dubins_study.solvers.protocol import Method, Question
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Key
from dubins_study.study.scenario import Scenario

# A cell takes about 700 bytes of memory until its row is written.
MOST_CELLS = 2_000_000


class BlockPlan(NamedTuple):
    """The questions about the scenarios of one block."""

    path: KeyPath  # of the block's key in the experiment's file
    block: Block
    branches: tuple[str, ...]
    initial_guesses: tuple[str, ...]  # not used where the block has `guess_lengths`
    repeats: int
    time_limit_s: float
    solvers: tuple[SolverDescription, ...]

    @property
    def key(self) -> str:
        """The block's key in messages: `scenarios.0`, or `first`."""
        return ".".join(map(str, self.path))

    @property
    def cells(self) -> int:
        """Number of cells of the block.

        Cells that another block also asks for are included.
        """
        guesses = sum(map(self.guess_count, self.solvers))
        return block_size(self.block) * len(self.branches) * self.repeats * guesses

    def guess_axes(self, solver: SolverDescription) -> Sequence[Sequence[Any]]:
        """Lists whose combinations are a solver's guesses.

        With `guess_lengths` these are three lists: values of z1, of z2 and of z3. Otherwise there
        is one list, of `cold` and `warm`. A solver that takes no guess is asked `cold` only; with
        `guess_lengths` it gets an empty list, and is not asked.
        """
        lengths = self.block.guess_lengths
        if lengths is None:
            return [[guess for guess in self.initial_guesses if solver.warm or guess == "cold"]]
        if not solver.warm:
            return [[]]
        return lengths.axes

    def guess_count(self, solver: SolverDescription) -> int:
        """Number of initial guesses of a solver.

        Each repeat of a question is asked once from each guess.
        """
        return math.prod(map(len, self.guess_axes(solver)))


def block_plans(
    experiment: Experiment, file: str = "the experiment", text: str = ""
) -> list[BlockPlan]:
    """The plans of all blocks.

    The blocks of the file come first, then those that its table `first` adds. These have no number
    in the file, so messages about them name `first`.

    Refused are too many cells, and solvers without a guess in a block with `guess_lengths`. `file`
    and `text` are the experiment's path and TOML text, for messages.
    """
    plans: list[BlockPlan] = []
    problems: list[Problem] = []
    for number, block in enumerate(experiment.blocks):
        path: KeyPath = ("scenarios", number)
        if number >= len(experiment.scenarios):
            path = ("first",)
        profile = experiment.profile
        patterns = block.solvers or experiment.solvers
        specs = expand_solvers(patterns, profile)
        plan = BlockPlan(
            path,
            block,
            branches=tuple(block.branches or experiment.branches),
            initial_guesses=tuple(experiment.initial_guesses),
            repeats=experiment.repeats,
            time_limit_s=block.time_limit_s or experiment.time_limit_s,
            solvers=tuple(describe_solver(spec, profile) for spec in specs),
        )
        cold = [solver.spec for solver in plan.solvers if not solver.warm]
        if block.guess_lengths is not None and cold and "*" not in patterns:
            sentence = (
                f"{plan.key}: {cold[0]} takes no initial guess; expected only solvers that do, or *"
            )
            problems.append(Problem(path, sentence))
        plans.append(plan)
    total = sum(plan.cells for plan in plans)
    if total > MOST_CELLS:  # refused before cells are listed: memory may not hold them
        sentence = (
            f"{total} cells (a cell for every scenario, solver, branch, initial guess and repeat); "
            f"expected at most {MOST_CELLS}"
        )
        problems.append(Problem((), sentence))
    if problems:
        raise ExperimentError(refusal(file, problems, text))
    return plans


def overview(file: ExperimentFile) -> dict[str, Any]:
    """An experiment in numbers.

    A scenario counts once for every block that asks about it.
    """
    experiment = file.experiment
    plans = block_plans(experiment, file.path, file.text)
    keys = {"title", "question", "repeats", "time_limit_s", "memory_limit_gib", "profile"}
    solvers = itertools.chain.from_iterable(plan.solvers for plan in plans)
    branches = itertools.chain.from_iterable(plan.branches for plan in plans)
    return {
        "name": file.name,
        **experiment.model_dump(include=keys),
        "scenarios": sum(block_size(block) for block in experiment.scenarios),
        "cells": sum(plan.cells for plan in plans),
        "solvers": [*dict.fromkeys(solver.spec for solver in solvers)],
        "branches": [*dict.fromkeys(branches)],
    }


class Cell(NamedTuple):
    """One question to one solver.

    All fields up to the code digest form the key of its row.
    """

    scenario_id: str
    solver: str
    profile: str
    branch: str
    initial_guess: str
    repeat: int
    code_digest: str
    scenario: Scenario
    method: Method
    time_limit_s: float

    @property
    def key(self) -> Key:
        """The values of the row's key columns."""
        return self[:7]

    def question(self, guess: Path | None = None) -> Question:
        """The question that is put to the solver."""
        return Question(self.scenario, self.branch, guess, self.repeat)


# Cells that must be solved in this order: all cells of a warm sweep, or a single cell.
Chain = tuple[Cell, ...]


def chains(experiment: Experiment, file: str = "the experiment", text: str = "") -> list[Chain]:
    """The chains of an experiment, in its file's order.

    Together the chains hold all cells. A cell that several blocks ask for is listed once. Blocks
    that are not valid are refused together, by their lines in `text`, the file's TOML.
    """
    problems: list[Problem] = []
    unique: dict[tuple[Key, ...], Chain] = {}
    sweeps: dict[Key, str] = {}  # warm cell -> the block whose sweep it is in
    for plan in block_plans(experiment, file, text):
        if problems and plan.path == ("first",):  # its problems are those of other blocks
            continue
        try:
            for chain in _block_chains(plan, experiment.profile):
                keys = tuple(cell.key for cell in chain)
                if keys in unique:
                    continue
                if chain[0].initial_guess == "warm":
                    _add_sweep(sweeps, keys, plan.key)
                unique[keys] = chain
        except ExperimentError as error:
            problems.append(Problem(plan.path, str(error)))
    if problems:
        raise ExperimentError(refusal(file, problems, text))
    return list(unique.values())


def _block_chains(plan: BlockPlan, profile: str) -> Iterator[Chain]:
    """Yield the chains of one block.

    The warm cells of one solver, branch and repeat are one chain. Every other cell is a chain.
    """
    solvers = [solver for solver in plan.solvers if plan.guess_count(solver)]
    if not solvers:
        return
    block_scenarios = asked_scenarios(plan.block, plan.key, plan.branches)
    ids = [scenario_id(scenario) for scenario in block_scenarios]
    for solver in solvers:
        combinations = itertools.product(*plan.guess_axes(solver))
        # `cold`, `warm`, or lengths such as `0.5 0.0 1.0`
        guesses = [" ".join(map(str, each)) for each in combinations]
        repeats = range(plan.repeats)
        for branch, repeat, guess in itertools.product(plan.branches, repeats, guesses):
            cells = (
                Cell(
                    scenario_id=id_,
                    solver=solver.spec,
                    profile=profile,
                    branch=branch,
                    initial_guess=guess,
                    repeat=repeat,
                    code_digest=solver.code_digest,
                    scenario=scenario,
                    method=solver.method,
                    time_limit_s=plan.time_limit_s,
                )
                for id_, scenario in zip(ids, block_scenarios, strict=True)
            )
            if guess == "warm":
                yield tuple(cells)
            else:
                yield from ((cell,) for cell in cells)


def _add_sweep(sweeps: dict[Key, str], keys: tuple[Key, ...], block_key: str) -> None:
    """Add the cells of a warm sweep to `sweeps`.

    A warm cell starts from the path of one cell before it. A cell that is in another sweep, or
    twice in this one, is refused.
    """
    for place, key in enumerate(keys):
        other = sweeps.get(key)
        if key in keys[:place]:
            other = "itself"
        if other is not None:
            raise ExperimentError(
                f"{block_key}, scenario {place}: already swept by {other}; expected every "
                "warm start in one sweep only: give one of the blocks a label of its own"
            )
    sweeps.update(dict.fromkeys(keys, block_key))


def given_guess(cell: Cell) -> Path | None:
    """The path that a cell's `initial_guess` gives, or None.

    The guess holds three lengths in radii: left turn, right turn, straight. `cold` and `warm` give
    no path. The path begins with the start heading; if that is free, there is no path either.
    """
    if cell.initial_guess in ("cold", "warm") or cell.scenario.heading is None:
        return None
    R = cell.scenario.radius
    lengths = [R * float(length) for length in cell.initial_guess.split()]
    return Path(cell.scenario.start, [1 / R, -1 / R, 0.0], lengths)


def shuffled(chain_list: list[Chain], seed: int) -> list[Chain]:
    """The chains in a random order.

    If the machine is slow for a while, all solvers share that.
    """
    return [chain_list[i] for i in np.random.default_rng(seed).permutation(len(chain_list))]
