"""The certified search for the shortest route.

Measured are how many routes it closes, how fast, and how far.

Random routes start at (0, 0) with a given heading and end with a free one; their legs have lengths
and directions drawn from a seed. The smooth circuit has 700 legs along a Fourier curve.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from statistics import median

import numpy as np

from benchmarks import harness
from benchmarks.harness import Measurement, absent, sized
from benchmarks.route_peers import NO_SOURCES, peer_rows
from dubins_study.study.arrays import FloatArray
from dubins_study.study.route.search import Route, search

SEED = 18
START = 0.3  # rad, the heading at the first point
# legs, shortest and longest leg (radii), routes, relative gap, seconds aimed at, limit in seconds
RANDOM = [
    (5, 4.0, 20.0, 50, 1e-12, 0.005, 1.0),
    (10, 4.0, 20.0, 50, 1e-12, 0.02, 1.0),
    (100, 4.0, 20.0, 10, 1e-12, 2.0, 10.0),
    (5, 0.5, 4.0, 20, 1e-9, 0.2, 5.0),
    (10, 0.5, 4.0, 10, 1e-9, 1.0, 10.0),
    (20, 0.5, 4.0, 6, 1e-6, 10.0, 30.0),
    (50, 0.5, 4.0, 2, 1e-6, 60.0, 90.0),
]


def random_route(rng: np.random.Generator, legs: int, least: float, most: float) -> FloatArray:
    """Points of a route with random legs.

    Directions and lengths of its legs (radii) are drawn uniformly.
    """
    direction = rng.uniform(-math.pi, math.pi, legs)
    length = rng.uniform(least, most, legs)
    steps = length[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    return np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])


def circuit(legs: int) -> FloatArray:
    """Points along a smooth closed curve.

    Its legs have 5 to 30 radii.
    """
    rng = np.random.default_rng(SEED)
    steps = 17.5 + 12.0 * np.sin(np.linspace(0.0, 40 * math.pi, legs) + rng.uniform(0.0, math.pi))
    turning = sum(
        rng.normal() / k * np.sin(2 * math.pi * k * np.arange(legs) / legs + rng.uniform(0.0, 6.0))
        for k in range(1, 12)
    )
    heading = 2 * math.pi * np.arange(legs) / legs + turning
    way = steps[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    return np.vstack([[0.0, 0.0], np.cumsum(way, axis=0)])


def measure() -> Iterable[Measurement]:
    search(random_route(np.random.default_rng(0), 3, 0.5, 8.0), START, limit=10.0)  # compiles
    for legs, least, most, routes, tolerance, aim, limit in RANDOM:
        rng = np.random.default_rng([SEED, legs, int(most)])
        points = [random_route(rng, legs, least, most) for _ in range(sized(routes, 1))]
        run = partial(search, first=START, limit=sized(limit, 1), tolerance=tolerance)
        yield from _rows(f"{legs} legs of {least:g}R to {most:g}R", points, run, aim)
    points = [circuit(sized(700, 20))] * sized(3, 1)
    run = partial(search, first=0.0, limit=30.0, tolerance=1e-12)
    yield from _rows("smooth circuit of 700 legs of 5R to 30R", points, run, 5.0)
    if harness.peer_sources is None:
        yield absent("routes against gdip and MPDP", NO_SOURCES)


def _rows(
    what: str, points: list[FloatArray], run: partial[Route], aim: float
) -> Iterable[Measurement]:
    """Our search, then its peers on the same routes."""
    routes = [run(some) for some in points]
    seconds = median(route.seconds for route in routes)
    gaps = [(route.high - route.low) / route.high for route in routes]
    closed = sum(route.closed for route in routes)
    yield Measurement(
        what,
        ours=seconds,
        peer=aim,
        unit="s",
        ratio=seconds / aim,
        target=1.0,
        note=f"median; {closed} of {len(routes)} closed to {run.keywords['tolerance']:g}, "
        f"gap {median(gaps):.0e}, at most {max(gaps):.0e}",
    )
    yield from peer_rows(points, routes, **run.keywords)
