"""Dense tracks: closed curves, noisy receivers, survey rows.

Where neighbours are nearer than 2R, headings that are a little off cost a full turn at each point:
a search that begins there gives a route of loops. Points are in radii.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from tests.adversary.leg_lengths import length_table, route_length
from tests.cases import walked

Array = Any  # numpy arrays
Rng = np.random.Generator

FEWEST, MOST = 50, 5000  # points


def _closed_curve(rng: Rng, n: int, spacing: float) -> Array:
    """Points on a smooth closed curve.

    They lie at equal arc lengths, once around the curve.
    """
    angle = np.linspace(0.0, 2.0 * math.pi, 40 * n)
    radius = np.ones(angle.size)
    for wave in range(2, 6):
        radius += rng.normal(scale=0.2 / wave) * np.cos(wave * angle + rng.uniform(0.0, 6.0))
    curve = radius * np.array([np.cos(angle), np.sin(angle)])
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(curve)))))
    places = np.linspace(0.0, along[-1], n, endpoint=False)
    points = np.column_stack([np.interp(places, along, row) for row in curve])
    return points * (spacing * n / along[-1])


def _noisy(rng: Rng, n: int, spacing: float) -> Array:
    """A closed curve as a receiver reports it."""
    noise = spacing * rng.uniform(0.02, 0.3)
    return _closed_curve(rng, n, spacing) + rng.normal(scale=noise, size=(n, 2))


def _rows(rng: Rng, n: int, spacing: float) -> Array:
    """Rows there and back, less than two radii apart."""
    apart = rng.uniform(0.3, 1.9)
    in_row = max(2, round(math.sqrt(n) * rng.uniform(0.5, 2.0)))
    place = np.arange(1, n)
    step = np.where(place % in_row == 0, apart, spacing)
    back = place // in_row % 2
    direction = np.where(place % in_row == 0, math.pi / 2, back * math.pi)
    return walked(step, direction)


KINDS: dict[str, Callable[[Rng, int, float], Array]] = {
    "closed curve": _closed_curve,
    "with noise": _noisy,
    "rows": _rows,
}


def track_of_seed(seed: int) -> tuple[str, Array, float]:
    """Kind of a track, its points, its first heading.

    The points have shape (n, 2).
    """
    rng = np.random.default_rng((32, seed))
    kind = list(KINDS)[seed % len(KINDS)]
    n = round(math.exp(rng.uniform(math.log(FEWEST), math.log(MOST))))
    points = KINDS[kind](rng, n, rng.uniform(0.1, 1.0))
    first = math.atan2(*(points[1] - points[0])[::-1])
    if rng.random() < 0.3:
        first = rng.uniform(-math.pi, math.pi)
    return kind, points, first


def bisecting(points: Array, first: float) -> Array:
    """Headings half way between the neighbouring chords."""
    chord = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    return np.concatenate(([first], 0.5 * (chord[1:] + chord[:-1]), [chord[-1]]))


def lengths(points: Array, first: float) -> tuple[float, float]:
    """Lengths of the route by two choices of headings.

    First with bisecting headings, then with the best of a few headings at each point.
    """
    legs = np.diff(points, axis=0)
    headings = bisecting(points, first)
    grid = [np.array([first])]
    grid += [heading + np.arange(8) * (math.pi / 4) for heading in headings[1:]]
    cost = np.zeros(1)
    for leg, (a, b) in zip(legs, pairwise(grid), strict=True):
        cost = (cost[:, None] + length_table(*leg, a, b)).min(axis=0)
    return route_length(legs, headings), float(cost.min())


def circle(n: int, spacing: float, radius: float) -> Array:
    """The origin and n points on a circle.

    They are `spacing` apart; the circle begins with heading 0.
    """
    angle = np.arange(n + 1) * spacing / radius
    return radius * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
