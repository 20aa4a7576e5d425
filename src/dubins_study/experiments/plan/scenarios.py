"""The scenarios of a block, and their ids.

If a block gives targets by distance and bearing, or by arc and margin, x and y are computed here.
All functions are those of `math`: numpy's may differ in the last bit between machines.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import struct
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.definition.scenario_block import (
    FIELDS,
    RANDOM,
    SPACINGS,
    Block,
    ListedBlock,
    Route,
    Sample,
    Tour,
)
from dubins_study.experiments.plan.fields import field_points
from dubins_study.study.scenario import NUMBERS, Scenario, ScenarioError
from dubins_study.study.words import Order

_ID_DIGITS = 16
_PACKED_NUMBERS = struct.Struct(f"<{len(NUMBERS)}d")
# Values of a scenario's fields, by their names.
Fields = dict[str, Any]


def scenario_id(scenario: Scenario) -> str:
    """The id of a scenario: 16 hexadecimal digits.

    The digits are the first ones of a SHA-256 of up to three parts. The second and the third begin
    with the byte 255, which is in no UTF-8. Doubles are little-endian; NaN is free or left out.

    Part 1: the fields of `NUMBERS` as doubles, then the label in UTF-8.
    Part 2, if there are any: x and y of the via points, then the final heading, as doubles.
    Part 3, unless all are left out: a byte each for a free order and a closed path, then the
    headings at via points as doubles.
    """
    values = (getattr(scenario, name) for name in NUMBERS)
    doubles = [math.nan if value is None else value for value in values]
    packed = _PACKED_NUMBERS.pack(*doubles)
    packed += scenario.label.encode()
    numbers = list(itertools.chain.from_iterable(point[:2] for point in scenario.via))
    if scenario.final_heading is not None:  # the number of numbers tells it from a point's
        numbers.append(scenario.final_heading)
    if numbers:
        packed += b"\xff" + struct.pack(f"<{len(numbers)}d", *numbers)
    headings = scenario.via_heading or []
    free = scenario.order is Order.FREE
    if headings or free or scenario.closed:
        packed += b"\xff" + struct.pack(f"<2?{len(headings)}d", free, scenario.closed, *headings)
    return hashlib.sha256(packed).hexdigest()[:_ID_DIGITS]


def block_size(block: Block) -> int:
    """How many scenarios a block has."""
    if (listed := _listed(block)) is not None:
        return len(listed)
    size = math.prod(map(len, _axes(block).values()))
    if block.drawn is None:
        return size
    return block.drawn.size * size


def scenarios(block: Block, key: str) -> Iterator[Scenario]:
    """Yield all scenarios of a block.

    The via points vary fastest, then the last of `FIELDS`. Drawn values vary slowest. If a scenario
    is not valid, an ExperimentError names `key`, the block's, and the scenario's number.
    """
    if (listed := _listed(block)) is not None:
        yield from listed
        return
    shared: Fields = {"label": block.label, "order": block.order, "closed": block.closed}
    if block.tour is not None:
        shared |= {"order": Order.FREE, "closed": block.tour.closed}
    for place, fields in enumerate(_combinations(block)):
        try:
            scenario = Scenario(**fields, **shared, _radians=True)
        except ScenarioError as error:
            raise ExperimentError(f"{key}, scenario {place}: {error}") from None
        yield scenario


def _listed(block: Block) -> list[Scenario] | None:
    """The scenarios that a block lists, or None.

    None means that the block combines or draws its scenarios.
    """
    if isinstance(block, ListedBlock):
        return list(block.listed)
    if block.frozen is not None:
        from dubins_study.study.convex.problem import matching  # loads sparse matrices

        return matching(block.frozen)
    return None


def _axes(block: Block) -> dict[str, Sequence[Any]]:
    """Field -> values, for fields of a block.

    A field that the block does not give is left out. One more axis is `via`: its values are lists
    of points. Without any it has one empty list.
    """
    axes: dict[str, Sequence[Any]] = {name: block.axis(name) or () for name in FIELDS}
    present = {name: axis for name, axis in axes.items() if axis}
    return present | {"via": block.via or [()]}


def _combinations(block: Block) -> Iterator[Fields]:
    """Yield the fields of each scenario of a block.

    The fields are arguments of `Scenario`. The label, `order` and `closed` are left out, since all
    scenarios of the block share them.
    """
    axes = _axes(block)
    for draw in _draws(block):
        for values in itertools.product(*axes.values()):
            fields = dict(zip(axes, values, strict=True)) | draw.fields
            if "distance" in fields:
                fields |= _from_bearing(fields, fields.pop("distance"), fields.pop("bearing"))
            if "arc" in fields:
                fields |= _beside_circle(fields, fields.pop("arc"), fields.pop("margin"))
            if draw.points:
                x = fields["x"]
                y = fields["y"]
                radius = fields["radius"]
                fields["via"] = [(x + radius * u, y + radius * v) for u, v in draw.points]
            if draw.to_target:
                fields["target_x"], fields["target_y"] = fields["via"].pop()
            yield fields


class Draw(NamedTuple):
    """Values that a block's table draws for one scenario."""

    fields: Fields
    points: Sequence[Sequence[float]] = ()  # that follow the start, in radii from there
    to_target: bool = False  # whether the last point is the target


def _draws(block: Block) -> Iterable[Draw]:
    """The draws of a block; at least one."""
    if block.sample is not None:
        return _samples(block.sample)
    if block.route is not None:
        return _routes(block.route)
    if block.tour is not None:
        return _tours(block.tour)
    return [Draw({})]


def _samples(sample: Sample) -> Iterator[Draw]:
    """Yield a draw for each point of a sample.

    The points are the same on every machine.
    """
    from scipy.stats import qmc  # takes half a second; most experiments have no sample

    engine = qmc.LatinHypercube
    if sample.method == "sobol":
        engine = qmc.Sobol
    points = engine(len(sample.ranges), rng=np.random.default_rng(sample.seed))
    with warnings.catch_warnings():
        # scipy warns if the number of points is not a power of 2, which is the author's choice
        warnings.simplefilter("ignore", UserWarning)
        unit = points.random(sample.count)
    for shares in unit.tolist():
        ranges = zip(sample.ranges, sample.ranges.values(), shares, strict=True)
        yield Draw({name: over.value_at(share) for name, over, share in ranges})


def _routes(route: Route) -> Iterator[Draw]:
    """Yield a draw for each route.

    Each number of legs has its own generator. The final heading is drawn even if it is free, so
    that the points do not depend on it.
    """
    low, high = SPACINGS[route.spacing]
    for legs in route.legs:
        rng = np.random.default_rng([route.seed, legs])
        for _ in range(route.count):
            if route.field == RANDOM:
                points = _walk(rng, legs, low, high)
            else:
                points = field_points(route.field, rng, legs, (low + high) / 2).tolist()
            final_heading = 2 * math.pi * rng.random()
            fields: Fields = {}
            if route.final_heading == "sampled":
                fields["final_heading"] = final_heading
            yield Draw(fields, points, to_target=True)


def _walk(rng: np.random.Generator, legs: int, low: float, high: float) -> list[list[float]]:
    """Points of a random walk from (0, 0).

    There are as many points as legs: the start is left out. The way from each point to the next has
    any direction, and a length from `low` to `high` (radii).
    """
    x = y = 0.0
    points = []
    for share, turn in rng.random((2, legs)).T.tolist():
        length = low + share * (high - low)
        x += length * math.cos(2 * math.pi * turn)
        y += length * math.sin(2 * math.pi * turn)
        points.append([x, y])
    return points


def _tours(tour: Tour) -> Iterator[Draw]:
    """Yield a draw for each tour.

    The generator is not seeded by the density: squares of all sizes have the same points. The start
    heading is drawn even if it is free.
    """
    for n, density in itertools.product(tour.points, tour.density):
        side = density * math.sqrt(n)
        rng = np.random.default_rng([tour.seed, n])
        for _ in range(tour.count):
            if tour.field == RANDOM:
                places = side * rng.random((n + 1, 2))
                points = (places[1:] - places[0]).tolist()
            else:
                points = field_points(tour.field, rng, n, density).tolist()
            fields: Fields = {"heading": 2 * math.pi * rng.random()}
            if tour.heading == "free":
                fields["heading"] = None
            yield Draw(fields, points, tour.to_target)


def _from_bearing(start: Fields, distance: float, bearing: float) -> Fields:
    """The target at a distance (radii) and bearing (rad)."""
    length = distance * start["radius"]
    direction = start["heading"] + bearing
    return {
        "target_x": start["x"] + length * math.cos(direction),
        "target_y": start["y"] + length * math.sin(direction),
    }


def _beside_circle(start: Fields, arc: float, margin: float) -> Fields:
    """The target beside a turning circle.

    `arc` is the angle along the circle (rad): positive on the left circle, negative on the right.
    `margin` is the distance outside the circle (radii).
    """
    r = 1 + margin
    half = math.sin(arc / 2)
    # In the vehicle's frame and in radii. The offset to the side is 1 - r cos(arc). It is computed
    # with 1 - cos(arc) = 2 sin^2(arc / 2), which is accurate for a small arc.
    ahead = r * math.sin(abs(arc))
    left = math.copysign(1.0, arc) * (2 * (half * half) - margin * math.cos(arc))
    cos = math.cos(start["heading"])
    sin = math.sin(start["heading"])
    return {
        "target_x": start["x"] + start["radius"] * (ahead * cos - left * sin),
        "target_y": start["y"] + start["radius"] * (ahead * sin + left * cos),
    }
