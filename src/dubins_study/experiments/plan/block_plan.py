"""The questions that an experiment asks about each block of scenarios, and their number."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from dubins_study.experiments.definition.experiment import Experiment, ExperimentError
from dubins_study.experiments.definition.scenario_block import Block, ListedBlock
from dubins_study.experiments.plan.scenario_columns import axis_size, axis_values, block_size
from dubins_study.experiments.plan.solver_description import SolverDescription, describe_solver
from dubins_study.experiments.plan.solver_specs import expand_solvers
from dubins_study.solvers.registry import SolverError

# A cell takes about 700 bytes of memory until its row is written.
MOST_CELLS = 2_000_000
# Streamed rows are not kept in memory, but they must fit on a disk.
MOST_ROWS = 10**10
# Each stream costs a hash over its whole block.
MOST_STREAMS = 10_000
# A block with fewer scenarios is solved cell by cell, and each row has its own measured time.
FEWEST_STREAMED = 2000


class BlockPlan(NamedTuple):
    """What an experiment asks about the scenarios of one block.

    Args:
        number: the number of the block in the experiment, from 0.
        block: the scenarios.
        branches: the branches that are asked for.
        initial_guesses: `cold`, `warm`, or both; not used where the block has `guess_lengths`.
        repeats: how many times every question is asked.
        cell_solvers: the solvers that answer one scenario at a time.
        stream_solvers: the solvers that answer many scenarios at a time (see `plan.streams`).
    """

    number: int
    block: Block
    branches: tuple[str, ...]
    initial_guesses: tuple[str, ...]
    repeats: int
    cell_solvers: tuple[SolverDescription, ...]
    stream_solvers: tuple[SolverDescription, ...]

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
        values = (axis_values(axis, np.arange(axis_size(axis))).tolist() for axis in lengths.axes)
        for point in itertools.product(*values):
            yield " ".join(repr(length) for length in point)


def block_plans(experiment: Experiment) -> list[BlockPlan]:
    """The plans of all blocks of an experiment.

    Raises:
        ExperimentError: if there are more than `MOST_CELLS` cells, `MOST_ROWS` streamed rows or
            `MOST_STREAMS` streams.
        SolverError: if a solver's spec is not valid.
    """
    plans = [
        _block_plan(number, block, experiment) for number, block in enumerate(experiment.blocks)
    ]
    _check_size(plans)
    return plans


def _block_plan(number: int, block: Block, experiment: Experiment) -> BlockPlan:
    solvers = _solvers(number, block, experiment)
    computed = block.guess_lengths is None and not isinstance(block, ListedBlock)
    large = computed and block_size(block) >= FEWEST_STREAMED
    # Only our own closed form is streamed: a plug-in's code must not run in the run's process.
    streamed = tuple(solver for solver in solvers if large and solver.closed_form)
    return BlockPlan(
        number,
        block,
        tuple(block.branches or experiment.branches),
        tuple(experiment.initial_guesses),
        experiment.repeats,
        tuple(solver for solver in solvers if solver not in streamed),
        streamed,
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
    """Refuse an experiment that is too large for the memory or the disk, before it is expanded."""
    total_cells = total_rows = total_streams = 0
    for plan in plans:
        scenarios = block_size(plan.block)
        questions = scenarios * len(plan.branches) * plan.repeats
        cells = questions * sum(map(plan.guess_count, plan.cell_solvers))
        total_cells += cells
        total_rows += questions * len(plan.stream_solvers)
        total_streams += len(plan.branches) * plan.repeats * len(plan.stream_solvers)
        sizes = (
            (
                total_cells,
                MOST_CELLS,
                f"{scenarios} scenarios and {cells} cells (a cell for every "
                f"solver, branch, initial guess and repeat), {total_cells} cells",
            ),
            (total_rows, MOST_ROWS, f"{total_rows} rows of the closed form"),
            (total_streams, MOST_STREAMS, f"{total_streams} branches and repeats of large blocks"),
        )
        for total, most, amount in sizes:
            if total > most:
                raise ExperimentError(
                    f"{plan.key}: {amount} up to here; expected at most {most} in all"
                )
