"""The scenarios of a block as columns: any window of its rows, without the rows before them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.experiments.definition.experiment import (
    CIRCULAR,
    FIELDS,
    POLAR,
    Axis,
    Block,
    ExperimentError,
    Linear,
    LinearRange,
    Log,
    Range,
    Sample,
)
from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import NUMBERS, Scenario, ScenarioError, check_frame

# columns of a window: the fields of `NUMBERS`, arrays of shape (rows of the window,)
Columns = dict[str, FloatArray]
# the first row of a window, and how many
Window = tuple[int, int]

# of a Latin hypercube every point depends on how many there are, so it is drawn whole
MOST_LATIN = 2_000_000
_ROWS = 2**15  # of a window where the caller wants all rows


def size(block: Block) -> int:
    """How many scenarios a block has."""
    return _products(block) * (1 if block.sample is None else block.sample.count)


def _products(block: Block) -> int:
    return math.prod(axis_size(getattr(block, name)) for name in FIELDS)


def axis_size(axis: Axis | None) -> int:
    """How many values an axis has; 1 if there is none, as a product needs it."""
    if isinstance(axis, Linear):
        return axis.linear[2]
    if isinstance(axis, Log):
        return axis.log[2]
    return len(axis) if isinstance(axis, list) else 1


def tiled(rows: int, window: int, first: int = 0) -> Iterator[Window]:
    """Rows from `first` on in windows of one size, the last one smaller if need be."""
    for start in range(first, rows, window):
        yield start, min(window, rows - start)


def windows(block: Block, where: str, wanted: Iterable[Window]) -> Iterator[Columns]:
    """The scenarios in windows of a block's rows, cheapest in ascending order.

    Row by row the fields vary in the order of `FIELDS`, the last one fastest, and a sample's points
    slowest. A row's numbers are the same to the last bit whatever the window.

    Raises:
        ExperimentError: naming the block (`where`), the row, the field and its value, if a window
            holds a scenario that cannot be.
    """
    inner, points = _products(block), _Points(block.sample, where)
    for first, count in wanted:
        row = np.arange(first, first + count)
        fields = _crossed(block, row % inner) | points.at(row // inner)
        made = {name: np.ascontiguousarray(values) for name, values in fields.items()}
        yield _checked(made, where, first)


def scenarios(block: Block, where: str) -> Iterator[Scenario]:
    """All scenarios of a block, one by one.

    Raises:
        ExperimentError: as `windows`.
    """
    for columns in windows(block, where, tiled(size(block), _ROWS)):
        values = (columns[name].tolist() for name in NUMBERS)
        for numbers in zip(*values, strict=True):
            yield Scenario(**dict(zip(NUMBERS, numbers, strict=True)), label=block.label)


def _crossed(block: Block, row: NDArray[np.int64]) -> Columns:
    """The fields that a block gives itself, at rows of their product."""
    crossed = {}
    for name in reversed(FIELDS):
        axis = getattr(block, name)
        if axis is not None:
            row, place = np.divmod(row, axis_size(axis))
            crossed[name] = axis_values(axis, place)
    return crossed


def axis_values(axis: Axis, place: NDArray[np.int64]) -> FloatArray:
    """Values of an axis at places counted from 0; as `np.linspace` and `np.geomspace` have them."""
    if isinstance(axis, Linear):
        return _evenly(*axis.linear, place)
    if isinstance(axis, Log):
        first, last, count = axis.log
        spread = 10.0 ** _evenly(math.log10(first), math.log10(last), count, place)
        spread[place == 0] = first
        spread[(place == count - 1) & (place > 0)] = last
        return spread
    return np.asarray(axis if isinstance(axis, list) else [axis], np.float64)[place]


def _evenly(first: float, last: float, count: int, place: NDArray[np.int64]) -> FloatArray:
    span, steps = last - first, max(1, count - 1)
    step = span / steps
    values = place.astype(np.float64)
    if step:
        values *= step
    else:  # too small for a double: the division comes first
        values /= steps
        values *= span
    values += first
    values[(place == count - 1) & (place > 0)] = last
    return values


class _Points:
    """The points of a sample, drawn as they are asked for."""

    def __init__(self, sample: Sample | None, where: str) -> None:
        self.sample = sample
        self.first, self.drawn = 0, np.empty((0, len(sample.ranges) if sample else 0))
        if sample is not None and sample.method == "latin hypercube":
            if sample.count > MOST_LATIN:
                raise ExperimentError(
                    f"{where}: sample.count is {sample.count}; expected at most {MOST_LATIN} for "
                    "method 'latin hypercube', which is drawn whole: 'sobol' takes more"
                )
            from scipy.stats import qmc  # here: half a second, and most experiments sample nothing

            rng = np.random.default_rng(sample.seed)
            self.drawn = qmc.LatinHypercube(len(sample.ranges), rng=rng).random(sample.count)
        self.engine: Any = None

    def at(self, index: NDArray[np.int64]) -> Columns:
        """The sampled fields at points counted from 0, in ascending order."""
        if self.sample is None:
            return {}
        if self.sample.method == "sobol":
            self._draw(int(index[0]), int(index[-1]) + 1)
        unit = self.drawn[index - self.first]
        ranges = self.sample.ranges.items()
        return {name: _spread(unit[:, i], over) for i, (name, over) in enumerate(ranges)}

    def _draw(self, first: int, end: int) -> None:
        """Have the points from `first` to `end` at hand; the engine only goes forward."""
        assert self.sample is not None
        if self.engine is None or first < self.first:
            from scipy.stats import qmc

            rng = np.random.default_rng(self.sample.seed)
            self.engine = qmc.Sobol(len(self.sample.ranges), rng=rng)
            self.first, self.drawn = 0, self.drawn[:0]
        at_hand = self.first + len(self.drawn)
        if first > at_hand:
            self.engine.fast_forward(first - at_hand)
            at_hand = first
        kept = self.drawn[first - self.first :] if first < at_hand else self.drawn[:0]
        with warnings.catch_warnings():
            # that a window is no power of two says nothing of the whole
            warnings.simplefilter("ignore", UserWarning)
            more = [self.engine.random(end - at_hand)] if end > at_hand else []
        self.first, self.drawn = first, np.concatenate([kept, *more])


def _spread(unit: FloatArray, over: Range) -> FloatArray:
    if isinstance(over, LinearRange):
        low, high = over.linear
        return low + unit * (high - low)
    low, high = over.log
    spread: FloatArray = low * (high / low) ** unit
    return spread


def _checked(fields: Columns, where: str, first: int) -> Columns:
    """The columns with their targets, once no row of them is wrong."""
    columns = _targets(fields)
    try:
        if "arc" in fields and fields["margin"].size and fields["margin"].min() < -1:
            raise ScenarioError
        check_frame(pd.DataFrame(columns, copy=False))
    except ScenarioError:
        _refuse(fields, columns, where, first)
    return columns


def _refuse(fields: Columns, columns: Columns, where: str, first: int) -> None:
    """Name the first row that is wrong, with the words for a single scenario."""
    for i in range(len(columns["x"])):
        try:
            if "arc" in fields and fields["margin"][i] < -1:
                raise ScenarioError(
                    f"margin is {fields['margin'][i]}; expected at least -1, the circle's centre"
                )
            Scenario(**{name: float(columns[name][i]) for name in NUMBERS}, label="")
        except ScenarioError as error:
            raise ExperimentError(f"{where}, scenario {first + i}: {error}") from None


def _each(function: Callable[[float], float], values: FloatArray) -> FloatArray:
    """A function of `math` at every value: numpy's own may differ from machine to machine."""
    return np.fromiter(map(function, values.tolist()), np.float64, values.size)


def _targets(fields: Columns) -> Columns:
    found = fields
    if "distance" in fields:
        distance, bearing = (fields[name] for name in POLAR)
        reach, direction = distance * fields["radius"], fields["heading"] + bearing
        found = fields | {
            "target_x": fields["x"] + reach * _each(math.cos, direction),
            "target_y": fields["y"] + reach * _each(math.sin, direction),
        }
    if "arc" in fields:
        found = fields | _beside_circle(fields)
    return {name: found[name] for name in NUMBERS}


def _beside_circle(fields: Columns) -> Columns:
    """Targets so far along a turning circle, and so many radii outside it."""
    arc, margin = (fields[name] for name in CIRCULAR)
    r, side = 1 + margin, np.copysign(1.0, arc)
    half = _each(math.sin, arc / 2)
    # from the start: 1 - r cos(arc), written so that a small arc keeps its digits
    ahead = r * _each(math.sin, np.abs(arc))
    left = 2 * (half * half) - margin * _each(math.cos, arc)
    cos, sin = _each(math.cos, fields["heading"]), _each(math.sin, fields["heading"])
    R = fields["radius"]
    return {
        "target_x": fields["x"] + R * (ahead * cos - side * left * sin),
        "target_y": fields["y"] + R * (ahead * sin + side * left * cos),
    }
