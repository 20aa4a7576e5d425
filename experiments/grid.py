"""An experiment expanded into cells: which solver is asked what, and in which order."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from experiments.fingerprint import code
from experiments.patterns import expand_solvers
from experiments.spec import (
    CIRCULAR,
    FIELDS,
    POLAR,
    Axis,
    Begin,
    Block,
    Experiment,
    ExperimentError,
    Linear,
    LinearRange,
    Log,
    Range,
    Sample,
)
from solvers.registry import SolverError, load
from study.path import FloatArray, Path
from study.scenario import Scenario, ScenarioError
from study.schema import SCENARIO, Key, names

_LONGEST = 1e6  # radii; a first guess beyond says nothing
# a cell takes about 700 bytes until its row is written
MOST_CELLS = 2_000_000


class Cell(NamedTuple):
    """One attempt to be made; its first fields are the key of its row."""

    scenario_id: str
    solver: str
    profile: str
    branch: str
    start: str
    repeat: int
    code: str
    scenario: Scenario

    @property
    def key(self) -> Key:
        return self[:7]


# Cells that one worker must solve one after another: a sweep's warm starts, or a single cell.
Chain = tuple[Cell, ...]


def scenario_id(scenario: Scenario) -> str:
    """A name for a scenario that depends on its numbers to the last bit, and on its label."""
    values = [getattr(scenario, name) for name in names(SCENARIO)]
    text = "|".join(value.hex() if isinstance(value, float) else value for value in values)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def chains(experiment: Experiment) -> list[Chain]:
    """All cells of an experiment in the order of the file, grouped as they must be solved.

    A cell that several blocks ask for is solved once.

    Raises:
        ExperimentError: if a block holds a scenario that cannot be, two sweeps give one warm
            start different predecessors, or there are more than `MOST_CELLS` cells.
        SolverError: if a solver's spec is not valid.
    """
    found: dict[tuple[Key, ...], Chain] = {}
    swept: dict[Key, int] = {}
    specs = [_specs(block, number, experiment) for number, block in enumerate(experiment.scenarios)]
    _check_size(experiment, specs)
    for number, block in enumerate(experiment.scenarios):
        scenarios = list(block_scenarios(block, f"scenarios.{number}"))
        ids = [scenario_id(scenario) for scenario in scenarios]
        for spec, branch, repeat, start in itertools.product(
            specs[number],
            block.branches or experiment.branches,
            range(experiment.repeats),
            experiment.starts if block.begin is None else _begins(block.begin),
        ):
            if start != "cold" and not specs[number][spec]:
                continue  # the method has no use for a starting point
            digest = code(spec, experiment.profile)
            cells = [
                Cell(name, spec, experiment.profile, branch, start, repeat, digest, scenario)
                for name, scenario in zip(ids, scenarios, strict=True)
            ]
            groups = [tuple(cells)] if start == "warm" else [(cell,) for cell in cells]
            for group in groups:
                keys = tuple(cell.key for cell in group)
                if keys not in found and start == "warm":
                    _claim(swept, keys, number)
                found.setdefault(keys, group)
    return list(found.values())


def _specs(block: Block, number: int, experiment: Experiment) -> dict[str, bool]:
    """The solvers of a block, and whether its method has a use for a starting point."""
    key, given = "solvers", experiment.solvers
    if block.solvers is not None:
        key, given = f"scenarios.{number}.solvers", block.solvers
    try:
        expanded = expand_solvers(given, experiment.profile)
    except SolverError as error:
        raise SolverError(f"{key}: {error}") from None
    warm = {spec: load(spec).warm for spec in expanded}
    if block.begin is not None and "*" not in given and not all(warm.values()):
        idle = next(spec for spec, takes in warm.items() if not takes)
        raise SolverError(f"{key}: {idle} takes no start; expected only solvers that do, or *")
    return warm


def _check_size(experiment: Experiment, specs: list[dict[str, bool]]) -> None:
    """Refuse what no memory would hold, before any of it is expanded."""
    total = 0
    for number, (block, solvers) in enumerate(zip(experiment.scenarios, specs, strict=True)):
        scenarios = math.prod(_count(getattr(block, name)) for name in FIELDS)
        scenarios *= 1 if block.sample is None else block.sample.count
        branches = len(block.branches or experiment.branches)
        asked = sum(_starts(block, experiment, warm) for warm in solvers.values())
        cells = scenarios * branches * experiment.repeats * asked
        total += cells
        if total > MOST_CELLS:
            raise ExperimentError(
                f"scenarios.{number}: {scenarios} scenarios and {cells} cells (a cell for every "
                f"solver, branch, start and repeat), {total} cells up to here; expected at most "
                f"{MOST_CELLS} in all"
            )


def _starts(block: Block, experiment: Experiment, warm: bool) -> int:
    """From how many starting points a solver is asked each of a block's questions."""
    if block.begin is None:
        return sum(warm or start == "cold" for start in experiment.starts)
    return warm * math.prod(map(_count, (block.begin.z1, block.begin.z2, block.begin.z3)))


def _count(axis: Axis | None) -> int:
    if isinstance(axis, Linear):
        return axis.linear[2]
    if isinstance(axis, Log):
        return axis.log[2]
    return len(axis) if isinstance(axis, list) else 1


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


def _begins(begin: Begin) -> Iterator[str]:
    """Starting points as the column `start` has them: z1, z2 and z3 to the last bit."""
    for point in itertools.product(*(_values(axis) for axis in (begin.z1, begin.z2, begin.z3))):
        if not all(0 <= length <= _LONGEST for length in point):
            raise ExperimentError(
                f"begin is {point}; expected lengths from 0 to {_LONGEST:g} radii: z1, z2, z3"
            )
        yield " ".join(repr(length) for length in point)


def given_start(cell: Cell) -> Path | None:
    """The path that a cell names as its starting point, or None if it names none."""
    if cell.start in ("cold", "warm"):
        return None
    R = cell.scenario.radius
    lengths = [R * float(length) for length in cell.start.split()]
    return Path(cell.scenario.start, [1 / R, -1 / R, 0.0], lengths)


def shuffled(groups: list[Chain], seed: int) -> list[Chain]:
    """The chains in an order drawn from the seed, so that no solver owns the warm part of a run."""
    order = np.random.default_rng(seed).permutation(len(groups))
    return [groups[i] for i in order]


def block_scenarios(block: Block, where: str) -> Iterator[Scenario]:
    """The scenarios of one block: fields vary in the order of `FIELDS`, the last one fastest."""
    named = [name for name in FIELDS if getattr(block, name) is not None]
    axes = [_values(getattr(block, name)) for name in named]
    sampled = _sampled(block.sample) if block.sample is not None else [{}]
    for row, (point, values) in enumerate(itertools.product(sampled, itertools.product(*axes))):
        fields = dict(zip(named, values, strict=True)) | point
        try:
            yield _scenario(fields, block.label)
        except ScenarioError as error:
            raise ExperimentError(f"{where}, scenario {row}: {error}") from None


def _scenario(fields: dict[str, float], label: str) -> Scenario:
    if "distance" in fields:
        distance, bearing = (fields.pop(name) for name in POLAR)
        reach, direction = distance * fields["radius"], fields["heading"] + bearing
        fields["target_x"] = fields["x"] + reach * math.cos(direction)
        fields["target_y"] = fields["y"] + reach * math.sin(direction)
    if "arc" in fields:
        arc, margin = (fields.pop(name) for name in CIRCULAR)
        if margin < -1:
            raise ScenarioError(f"margin is {margin}; expected at least -1, the circle's centre")
        r, side = 1 + margin, math.copysign(1.0, arc)
        # from the start: 1 - r cos(arc), written so that a small arc keeps its digits
        ahead, left = r * math.sin(abs(arc)), 2 * math.sin(arc / 2) ** 2 - margin * math.cos(arc)
        cos, sin = math.cos(fields["heading"]), math.sin(fields["heading"])
        R = fields["radius"]
        fields["target_x"] = fields["x"] + R * (ahead * cos - side * left * sin)
        fields["target_y"] = fields["y"] + R * (ahead * sin + side * left * cos)
    return Scenario(**fields, label=label)


def _values(axis: Axis) -> list[float]:
    if isinstance(axis, Linear):
        return [float(v) for v in np.linspace(*axis.linear)]
    if isinstance(axis, Log):
        return [float(v) for v in np.geomspace(*axis.log)]
    return axis if isinstance(axis, list) else [axis]


def _sampled(sample: Sample) -> list[dict[str, float]]:
    dimension = len(sample.ranges)
    rng = np.random.default_rng(sample.seed)
    engine = (
        qmc.Sobol(dimension, rng=rng)
        if sample.method == "sobol"
        else qmc.LatinHypercube(dimension, rng=rng)
    )
    points = engine.random(sample.count)
    columns = [_spread(points[:, i], r) for i, r in enumerate(sample.ranges.values())]
    return [
        dict(zip(sample.ranges, map(float, row), strict=True)) for row in zip(*columns, strict=True)
    ]


def _spread(unit: FloatArray, over: Range) -> FloatArray:
    if isinstance(over, LinearRange):
        low, high = over.linear
        return low + unit * (high - low)
    low, high = over.log
    spread: FloatArray = low * (high / low) ** unit
    return spread
