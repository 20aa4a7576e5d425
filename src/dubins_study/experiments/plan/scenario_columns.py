"""The scenarios of a block as columns: any window of its rows, computed without the other rows.

If a block gives targets by distance and bearing, or by arc and margin, x and y are computed here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.experiments.definition.axes import Axis, Linear, Log
from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.definition.scenario_block import (
    CIRCULAR,
    FIELDS,
    POLAR,
    Block,
    ListedBlock,
)
from dubins_study.experiments.plan.sample_points import SamplePoints
from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import NUMBERS, Scenario, ScenarioError, check_frame
from dubins_study.study.scenario import scenarios as listed_scenarios

# One array of shape (rows of the window,) for each name in `NUMBERS`.
Columns = dict[str, FloatArray]
# Number of the first row, number of rows.
Window = tuple[int, int]

_WINDOW_ROWS = 2**15  # if the caller wants all rows


def block_size(block: Block) -> int:
    """How many scenarios a block has."""
    if isinstance(block, ListedBlock):
        return len(block.listed)
    return _combinations(block) * (1 if block.sample is None else block.sample.count)


def _combinations(block: Block) -> int:
    """Number of combinations of the block's own fields, without the sample."""
    return math.prod(axis_size(block.axis(field)) for field in FIELDS)


def axis_size(axis: Axis | None) -> int:
    """Number of values of an axis; 1 for a field that the block does not give."""
    if isinstance(axis, Linear):
        return axis.linear[2]
    if isinstance(axis, Log):
        return axis.log[2]
    return len(axis) if isinstance(axis, list) else 1


def tiled(rows: int, window_rows: int) -> Iterator[Window]:
    """Windows of `window_rows` rows that cover `rows` rows; the last one may be smaller."""
    for first in range(0, rows, window_rows):
        yield first, min(window_rows, rows - first)


def windows(block: Block, key: str, wanted: Iterable[Window]) -> Iterator[Columns]:
    """The scenarios in windows of a block's rows; ascending windows are the cheapest.

    From row to row the last of `FIELDS` varies fastest, and the sample's point slowest. A row has
    the same numbers, to the last bit, in every window that holds it.

    Args:
        block: the scenarios.
        key: the block's key in the experiment, such as `scenarios.0`, for messages.
        wanted: the windows.

    Raises:
        ExperimentError: naming key, row, field and value, if a window holds a scenario that is not
            valid.
    """
    combinations, points = _combinations(block), SamplePoints(block.sample, key)
    for first, count in wanted:
        row = np.arange(first, first + count)
        fields = _combined(block, row % combinations) | points.at(row // combinations)
        contiguous = {name: np.ascontiguousarray(values) for name, values in fields.items()}
        yield _checked(contiguous, key, first)


def scenarios(block: Block, key: str) -> Iterator[Scenario]:
    """All scenarios of a block, one by one.

    Raises:
        ExperimentError: as `windows`.
    """
    if isinstance(block, ListedBlock):
        yield from listed_scenarios(block.listed)
        return
    for columns in windows(block, key, tiled(block_size(block), _WINDOW_ROWS)):
        values = (columns[name].tolist() for name in NUMBERS)
        for numbers in zip(*values, strict=True):
            yield Scenario(**dict(zip(NUMBERS, numbers, strict=True)), label=block.label)


def _combined(block: Block, row: NDArray[np.int64]) -> Columns:
    """The values of the block's own fields at combinations given by their numbers."""
    columns = {}
    for field in reversed(FIELDS):
        axis = block.axis(field)
        if axis is not None:
            row, index = np.divmod(row, axis_size(axis))
            columns[field] = axis_values(axis, index)
    return columns


def axis_values(axis: Axis, index: NDArray[np.int64]) -> FloatArray:
    """The values of an axis at indices from 0, equal to those of np.linspace and np.geomspace."""
    if isinstance(axis, Linear):
        return _evenly_spaced(*axis.linear, index)
    if isinstance(axis, Log):
        first, last, count = axis.log
        values = 10.0 ** _evenly_spaced(math.log10(first), math.log10(last), count, index)
        values[index == 0] = first
        values[(index == count - 1) & (index > 0)] = last
        return values
    return np.asarray(axis if isinstance(axis, list) else [axis], np.float64)[index]


def _evenly_spaced(first: float, last: float, count: int, index: NDArray[np.int64]) -> FloatArray:
    """`np.linspace(first, last, count)[index]`, equal to the last bit."""
    span, steps = last - first, max(1, count - 1)
    step = span / steps
    values = index.astype(np.float64)
    if step:
        values *= step
    else:  # the step is too small for a double: divide before multiplying, as numpy does
        values /= steps
        values *= span
    values += first
    values[(index == count - 1) & (index > 0)] = last
    return values


def _checked(fields: Columns, key: str, first: int) -> Columns:
    """The columns of `NUMBERS` with computed targets; an error if a row is not valid."""
    columns = _target_columns(fields)
    try:
        check_frame(pd.DataFrame(columns, copy=False))
    except ScenarioError:
        _refuse(columns, key, first)
    return columns


def _refuse(columns: Columns, key: str, first: int) -> None:
    """Raise an error about the first row that is not valid, with the message of `Scenario`."""
    for i in range(len(columns["x"])):
        try:
            Scenario(**{name: float(columns[name][i]) for name in NUMBERS}, label="")
        except ScenarioError as error:
            raise ExperimentError(f"{key}, scenario {first + i}: {error}") from None


def _target_columns(fields: Columns) -> Columns:
    """The columns of `NUMBERS`; the target is computed if the fields give it in another way.

    Args:
        fields: start, radius, speed and target (see `definition.scenario_block.Block`), one array
            of shape (n,) per field.
    """
    targets: Columns = {}
    if "distance" in fields:
        targets = _from_bearing(fields)
    if "arc" in fields:
        targets = _beside_circle(fields)
    columns = {**fields, **targets}
    return {name: columns[name] for name in NUMBERS}


def _from_bearing(fields: Columns) -> Columns:
    distance, bearing = (fields[name] for name in POLAR)
    length, direction = distance * fields["radius"], fields["heading"] + bearing
    return {
        "target_x": fields["x"] + length * _each(math.cos, direction),
        "target_y": fields["y"] + length * _each(math.sin, direction),
    }


def _beside_circle(fields: Columns) -> Columns:
    """Targets at an angle along a turning circle and at a distance from it."""
    arc, margin = (fields[name] for name in CIRCULAR)
    r, side = 1 + margin, np.copysign(1.0, arc)
    half = _each(math.sin, arc / 2)
    # In the vehicle's frame and in radii. The offset to the side is 1 - r cos(arc). It is computed
    # with 1 - cos(arc) = 2 sin^2(arc / 2), which is accurate for a small arc.
    ahead = r * _each(math.sin, np.abs(arc))
    left = 2 * (half * half) - margin * _each(math.cos, arc)
    cos, sin = _each(math.cos, fields["heading"]), _each(math.sin, fields["heading"])
    R = fields["radius"]
    return {
        "target_x": fields["x"] + R * (ahead * cos - side * left * sin),
        "target_y": fields["y"] + R * (ahead * sin + side * left * cos),
    }


def _each(function: Callable[[float], float], values: FloatArray) -> FloatArray:
    """A function of `math` at every value. numpy's functions may differ between machines."""
    return np.fromiter(map(function, values.tolist()), np.float64, values.size)
