"""The scenarios of a block as columns or one by one, and their ids.

If a block gives targets by distance and bearing, or by arc and margin, x and y are computed here.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import struct
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from dubins_study.experiments.definition.axes import Points
from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.definition.scenario_block import (
    CIRCULAR,
    FIELDS,
    POLAR,
    SPACINGS,
    Block,
    ListedBlock,
    Route,
    Sample,
    Tour,
)
from dubins_study.study.arrays import FloatArray
from dubins_study.study.scenario import HEADINGS, NUMBERS, Scenario, ScenarioError
from dubins_study.study.words import Order

_ID_DIGITS = 16
_PACKED_NUMBERS = struct.Struct(f"<{len(NUMBERS)}d")


def scenario_id(scenario: Scenario) -> str:
    """The id of a scenario: 16 hexadecimal digits.

    They are the first digits of the SHA-256 of the fields of `NUMBERS` as little-endian doubles,
    followed by the label in UTF-8 and, if the scenario has via points or a final heading, by the
    byte 255, which is in no UTF-8, and these numbers as doubles. Headings at via points, an order
    that is free and a path that is closed follow after another such byte. What is free or left out
    is NaN.
    """
    values = (getattr(scenario, name) for name in NUMBERS)
    packed = _PACKED_NUMBERS.pack(*(math.nan if value is None else value for value in values))
    packed += scenario.label.encode()
    numbers = [coordinate for x, y, *_ in scenario.via for coordinate in (x, y)]
    if scenario.final_heading is not None:  # the number of numbers tells it from a point's
        numbers.append(scenario.final_heading)
    if numbers:
        packed += b"\xff" + struct.pack(f"<{len(numbers)}d", *numbers)
    headings, free = scenario.via_heading or [], scenario.order is Order.FREE
    if headings or free or scenario.closed:
        packed += b"\xff" + struct.pack(f"<2?{len(headings)}d", free, scenario.closed, *headings)
    return hashlib.sha256(packed).hexdigest()[:_ID_DIGITS]


def sampled(sample: Sample) -> dict[str, FloatArray]:
    """One array of shape (count,) for each sampled field; the same on every machine."""
    from scipy.stats import qmc  # takes half a second; most experiments have no sample

    engine = qmc.Sobol if sample.method == "sobol" else qmc.LatinHypercube
    points = engine(len(sample.ranges), rng=np.random.default_rng(sample.seed))
    with warnings.catch_warnings():
        # scipy warns if the number of points is not a power of 2, which is the author's choice
        warnings.simplefilter("ignore", UserWarning)
        unit = points.random(sample.count)
    scaled: dict[str, FloatArray] = {}
    for (field, over), share in zip(sample.ranges.items(), unit.T, strict=True):
        if over.linear is not None:
            low, high = over.linear
            scaled[field] = low + share * (high - low)
        elif over.log is not None:
            low, high = over.log
            scaled[field] = low * _each(partial(pow, high / low), share)
    return scaled


# One array of shape (n,) for each field.
Columns = dict[str, FloatArray]


def block_size(block: Block) -> int:
    """How many scenarios a block has."""
    if isinstance(block, ListedBlock):
        return len(block.listed)
    drawn = 1 if block.sample is None else block.sample.count
    several = block.route or block.tour
    if several is not None:
        drawn = several.size
    return _combinations(block) * drawn


def _combinations(block: Block) -> int:
    """Number of combinations of the block's own fields, without what is drawn."""
    return len(block.via or [()]) * math.prod(len(block.axis(name) or [None]) for name in FIELDS)


def columns(block: Block) -> Columns:
    """The numbers of the scenarios of a block, not checked; a heading that is free is NaN.

    A target or a final heading that no scenario has is no column. From row to row the via points
    vary fastest, then the last of `FIELDS`, and the sample's point, the route or the tour slowest.
    """
    row, combinations = np.arange(block_size(block)), _combinations(block)
    combination, fields = row % combinations // len(block.via or [()]), Columns()
    for field in reversed(FIELDS):
        axis = block.axis(field)
        if axis is not None:
            combination, index = np.divmod(combination, len(axis))
            fields[field] = np.array(axis, np.float64)[index]
    if block.sample is not None:
        fields |= {
            name: values[row // combinations] for name, values in sampled(block.sample).items()
        }
    if "distance" in fields:
        fields |= _from_bearing(fields)
    if "arc" in fields:
        fields |= _beside_circle(fields)
    walks = _walks(block)
    if walks is not None:
        place = row // combinations
        fields |= {name: headings[place] for name, headings in walks.headings.items()}
        if walks.to_target:
            ends = np.array([points[-1] for points in walks.points])[place]
            for name, end in zip("xy", ends.T, strict=True):
                fields[f"target_{name}"] = fields[name] + fields["radius"] * end
    return {name: fields[name] for name in (*NUMBERS, "final_heading") if name in fields}


class Walks(NamedTuple):
    """Routes or tours that are drawn at random."""

    points: list[FloatArray]  # of each after its start, shape (n, 2), in radii from there
    to_target: bool  # whether the last point is the target
    headings: Columns  # those that are drawn


def _walks(block: Block) -> Walks | None:
    if block.route is not None:
        return sampled_routes(block.route)
    if block.tour is not None:
        return sampled_tours(block.tour)
    return None


def sampled_routes(route: Route) -> Walks:
    """The routes that a table draws."""
    low, high = SPACINGS[route.spacing]
    walks, finals = [], []
    for legs in route.legs:
        rng = np.random.default_rng([route.seed, legs])
        for _ in range(route.count):
            length, turn = rng.random((2, legs))
            steps = np.stack([_each(f, 2 * math.pi * turn) for f in (math.cos, math.sin)], axis=1)
            walks.append(np.cumsum((low + length * (high - low))[:, None] * steps, axis=0))
            finals.append(2 * math.pi * rng.random())
    headings: Columns = {}
    if route.final_heading == "sampled":
        headings["final_heading"] = np.array(finals)
    return Walks(walks, True, headings)


def sampled_tours(tour: Tour) -> Walks:
    """The tours that a table draws."""
    drawn, headings = [], []
    for n, density in itertools.product(tour.points, tour.density):
        side = density * math.sqrt(n)
        rng = np.random.default_rng([tour.seed, n])
        for _ in range(tour.count):
            places = side * rng.random((n + 1, 2))
            drawn.append(places[1:] - places[0])
            headings.append(2 * math.pi * rng.random())
    start = np.array(headings)
    if tour.heading == "free":
        start = np.full(len(drawn), math.nan)
    return Walks(drawn, tour.to_target, {"heading": start})


def _vias(block: Block, numbers: Columns) -> Iterator[Points]:
    """The via points of each scenario of a block whose numbers are known."""
    walks = _walks(block)
    if walks is None:
        yield from itertools.islice(itertools.cycle(block.via or [()]), block_size(block))
        return
    combinations = _combinations(block)
    places = zip(*(numbers[name].tolist() for name in ("x", "y", "radius")), strict=True)
    for row, (x, y, radius) in enumerate(places):
        points = walks.points[row // combinations].tolist()
        if walks.to_target:
            points.pop()
        yield tuple((x + radius * u, y + radius * v) for u, v in points)


def scenarios(block: Block, key: str) -> Iterator[Scenario]:
    """All scenarios of a block, one by one; one that is not valid is named by the block's key."""
    if isinstance(block, ListedBlock):
        yield from block.listed
        return
    order: str = block.order
    closed = block.closed
    if block.tour is not None:
        order = Order.FREE
        closed = block.tour.closed
    found = columns(block)
    values = (array.tolist() for array in found.values())
    rows = zip(zip(*values, strict=True), _vias(block, found), strict=True)
    for i, (numbers, via) in enumerate(rows):
        fields: dict[str, Any] = dict(zip(found, numbers, strict=True))
        for name in HEADINGS:
            if math.isnan(fields.get(name, 0.0)):
                fields[name] = None
        other: dict[str, Any] = {"label": block.label, "order": order, "closed": closed}
        try:
            scenario = Scenario(**fields, **other, via=via, _radians=True)
        except ScenarioError as error:
            raise ExperimentError(f"{key}, scenario {i}: {error}") from None
        yield scenario


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
