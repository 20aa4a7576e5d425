"""An experiment expanded into cells: which solver is asked what, and in which order."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from dubins_study.experiments.definition.experiment import (
    Axis,
    Block,
    Experiment,
    ExperimentError,
    GuessLengths,
)
from dubins_study.experiments.plan.block_columns import axis_size, axis_values, scenarios, size
from dubins_study.experiments.plan.scenario_ids import scenario_id
from dubins_study.experiments.plan.solver_description import described
from dubins_study.experiments.plan.solver_specs import expand_solvers
from dubins_study.solvers.registry import SolverError
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Key
from dubins_study.study.scenario import Scenario

_LONGEST = 1e6  # radii; a first guess beyond says nothing
# a cell takes about 700 bytes until its row is written
MOST_CELLS = 2_000_000
# rows that are streamed take no memory, but a disk has an end
MOST_ROWS = 10**10
# each has a name, a hash of its block
MOST_STREAMS = 10_000
# a block of fewer scenarios is solved cell by cell, each with a time of its own
FEWEST_STREAMED = 2000


class Cell(NamedTuple):
    """One attempt to be made; its first fields are the key of its row."""

    scenario_id: str
    solver: str
    profile: str
    branch: str
    initial_guess: str
    repeat: int
    code_digest: str
    scenario: Scenario

    @property
    def key(self) -> Key:
        return self[:7]


# Cells that one worker must solve one after another: a sweep's warm starts, or a single cell.
Chain = tuple[Cell, ...]


def chains(experiment: Experiment) -> list[Chain]:
    """All cells of an experiment in the order of the file, grouped as they must be solved.

    A cell that several blocks ask for is solved once. What `streamed` holds for is left out.

    Raises:
        ExperimentError: if a block holds a scenario that cannot be, two sweeps give one warm
            start different predecessors, or there are more than `MOST_CELLS` cells.
        SolverError: if a solver's spec is not valid.
    """
    found: dict[tuple[Key, ...], Chain] = {}
    swept: dict[Key, int] = {}
    specs = asked(experiment)
    for number, block in enumerate(experiment.scenarios):
        single = [
            spec
            for spec, warm in specs[number].items()
            if not streamed(block, spec, experiment.profile) and _starts(block, experiment, warm)
        ]
        if not single:
            continue  # nobody is asked, however often: `product` would write all repeats out
        made = list(scenarios(block, f"scenarios.{number}"))
        ids = [scenario_id(scenario) for scenario in made]
        for spec, branch, repeat, guess in itertools.product(
            single,
            block.branches or experiment.branches,
            range(experiment.repeats),
            experiment.initial_guesses
            if block.guess_lengths is None
            else _guesses(block.guess_lengths),
        ):
            if guess != "cold" and not specs[number][spec]:
                continue  # the method has no use for a starting point
            digest = described(spec, experiment.profile).code_digest
            cells = [
                Cell(name, spec, experiment.profile, branch, guess, repeat, digest, scenario)
                for name, scenario in zip(ids, made, strict=True)
            ]
            groups = [tuple(cells)] if guess == "warm" else [(cell,) for cell in cells]
            for group in groups:
                keys = tuple(cell.key for cell in group)
                if keys not in found and guess == "warm":
                    _claim(swept, keys, number)
                found.setdefault(keys, group)
    return list(found.values())


def asked(experiment: Experiment) -> list[dict[str, bool]]:
    """Of every block its solvers, and whether their methods have a use for a starting point.

    Raises:
        ExperimentError: if there are more than `MOST_CELLS` cells or `MOST_ROWS` streamed rows.
        SolverError: if a solver's spec is not valid.
    """
    specs = [_specs(block, number, experiment) for number, block in enumerate(experiment.scenarios)]
    _check_size(experiment, specs)
    return specs


def streamed(block: Block, spec: str, profile: str) -> bool:
    """Whether a block's scenarios go to a solver in frames (`experiments.engines.stream`), not as cells.

    Only to our own closed form: a plug-in's answers to whole frames are made where the run is.
    """
    cold = block.guess_lengths is None and size(block) >= FEWEST_STREAMED
    return cold and described(spec, profile).closed_form


def _specs(block: Block, number: int, experiment: Experiment) -> dict[str, bool]:
    """The solvers of a block, and whether its method has a use for a starting point."""
    key, given = "solvers", experiment.solvers
    if block.solvers is not None:
        key, given = f"scenarios.{number}.solvers", block.solvers
    try:
        expanded = expand_solvers(given, experiment.profile)
    except SolverError as error:
        raise SolverError(f"{key}: {error}") from None
    warm = {spec: described(spec, experiment.profile).warm for spec in expanded}
    if block.guess_lengths is not None and "*" not in given and not all(warm.values()):
        idle = next(spec for spec, takes in warm.items() if not takes)
        raise SolverError(
            f"{key}: {idle} takes no initial guess; expected only solvers that do, or *"
        )
    return warm


def _check_size(experiment: Experiment, specs: list[dict[str, bool]]) -> None:
    """Refuse what no memory and no disk would hold, before any of it is expanded."""
    total = rows = frames = 0
    for number, (block, solvers) in enumerate(zip(experiment.scenarios, specs, strict=True)):
        scenarios = size(block)
        branches = len(block.branches or experiment.branches)
        questions = scenarios * branches * experiment.repeats
        counted = {
            spec: _starts(block, experiment, warm)
            for spec, warm in solvers.items()
            if not streamed(block, spec, experiment.profile)
        }
        cells = questions * sum(counted.values())
        total += cells
        rows += questions * (len(solvers) - len(counted))
        frames += branches * experiment.repeats * (len(solvers) - len(counted))
        if total > MOST_CELLS:
            raise ExperimentError(
                f"scenarios.{number}: {scenarios} scenarios and {cells} cells (a cell for every "
                f"solver, branch, initial guess and repeat), {total} cells up to here; expected at most "
                f"{MOST_CELLS} in all"
            )
        if rows > MOST_ROWS:
            raise ExperimentError(
                f"scenarios.{number}: {rows} rows of the closed form up to here; expected at most "
                f"{MOST_ROWS} in all"
            )
        if frames > MOST_STREAMS:
            raise ExperimentError(
                f"scenarios.{number}: {frames} branches and repeats of large blocks up to here; "
                f"expected at most {MOST_STREAMS} in all"
            )


def _starts(block: Block, experiment: Experiment, warm: bool) -> int:
    """From how many starting points a solver is asked each of a block's questions."""
    if block.guess_lengths is None:
        return sum(warm or guess == "cold" for guess in experiment.initial_guesses)
    return warm * math.prod(
        map(axis_size, (block.guess_lengths.z1, block.guess_lengths.z2, block.guess_lengths.z3))
    )


def _claim(swept: dict[Key, int], keys: tuple[Key, ...], block: int) -> None:
    """Note the warm cells of a sweep: each may follow but one other, in but one sweep."""
    for place, key in enumerate(keys):
        if key in swept or key in keys[:place]:
            other = "itself" if key in keys[:place] else f"scenarios.{swept[key]}"
            raise ExperimentError(
                f"scenarios.{block}, scenario {place}: already swept by {other}; expected every "
                "warm start in one sweep only: give one of the blocks a label of its own"
            )
    swept.update(dict.fromkeys(keys, block))


def _guesses(begin: GuessLengths) -> Iterator[str]:
    """Starting points as the column `start` has them: z1, z2 and z3 to the last bit."""
    for point in itertools.product(*map(_values, (begin.z1, begin.z2, begin.z3))):
        if not all(0 <= length <= _LONGEST for length in point):
            raise ExperimentError(
                f"guess_lengths is {point}; expected lengths from 0 to {_LONGEST:g} radii: z1, z2, z3"
            )
        yield " ".join(repr(length) for length in point)


def given_guess(cell: Cell) -> Path | None:
    """The path that a cell names as its starting point, or None if it names none."""
    if cell.initial_guess in ("cold", "warm"):
        return None
    R = cell.scenario.radius
    lengths = [R * float(length) for length in cell.initial_guess.split()]
    return Path(cell.scenario.start, [1 / R, -1 / R, 0.0], lengths)


def shuffled(groups: list[Chain], seed: int) -> list[Chain]:
    """The chains in an order drawn from the seed, so that no solver owns the warm part of a run."""
    order = np.random.default_rng(seed).permutation(len(groups))
    return [groups[i] for i in order]


def _values(axis: Axis) -> list[float]:
    return [float(value) for value in axis_values(axis, np.arange(axis_size(axis)))]
