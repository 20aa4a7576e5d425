"""A leg's lower bound over boxes of headings, beside lengths that other code computes."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from dubins_study.study.closed_form.pose_kernel import pose_rows
from dubins_study.study.route import leg_bound
from dubins_study.study.route.word_bounds import Box

STEPS = 41  # headings across each interval


@numba.njit
def bounds_of(boxes):
    bounds = np.empty(len(boxes))
    for i in range(len(boxes)):
        x, y, c1, h1, slope1, c2, h2, slope2 = boxes[i]
        bounds[i], _ = leg_bound.box_bound(Box(x, y, c1, h1, slope1, c2, h2, slope2))
    return bounds


def sampled(boxes):
    """The least of the potential's lengths on a grid of headings in each box."""
    share = np.linspace(-1.0, 1.0, STEPS)
    least = np.empty(len(boxes))
    for low in range(0, len(boxes), 500):
        x, y, c1, h1, slope1, c2, h2, slope2 = boxes[low : low + 500].T[:, :, None, None]
        t1, t2 = h1 * share[:, None], h2 * share
        columns = np.broadcast_arrays(0.0, 0.0, c1 + t1, x, y, 1.0, c2 + t2)
        lengths = pose_rows(*(column.ravel() for column in columns)).length
        values = lengths.reshape(columns[2].shape) + slope1 * t1 - slope2 * t2
        least[low : low + 500] = values.min(axis=(1, 2))
    return least


def ends(rng, x, y, a, b, slopes):
    """Boxes of all sizes that hold these headings, somewhere."""
    n = x.size
    h1, h2 = 10 ** rng.uniform(-6, -0.3, n), 10 ** rng.uniform(-6, -0.3, n)
    together = rng.random(n) < 0.5
    h2 = np.where(together, h1, h2)
    h1 = np.where(rng.random(n) < 0.1, 0.0, h1)  # a heading that is given
    c1, c2 = a + h1 * rng.uniform(-1, 1, n), b + h2 * rng.uniform(-1, 1, n)
    size = slopes * (rng.random(n) < 0.7)
    slope1, slope2 = size * rng.uniform(-1, 1, n), size * rng.uniform(-1, 1, n)
    return np.stack([x, y, c1, h1, slope1, c2, h2, slope2], axis=1)


def anywhere(n, seed):
    rng = np.random.default_rng(seed)
    distance = np.exp(rng.uniform(math.log(0.05), math.log(20.0), n))
    direction = rng.uniform(-math.pi, math.pi, n)
    x, y = distance * np.cos(direction), distance * np.sin(direction)
    return ends(rng, x, y, *rng.uniform(-math.pi, math.pi, (2, n)), 2.5)


def at_edges(n, seed):
    """Boxes about paths of which one segment or two have no length: where lengths jump."""
    rng = np.random.default_rng(seed)
    a = rng.uniform(-math.pi, math.pi, n)
    x, y, heading = np.zeros(n), np.zeros(n), a.copy()
    turn = rng.choice([-1.0, 1.0], n)
    missing = rng.integers(0, 3, n)
    twice = rng.random(n) < 0.3
    straight = rng.random(n) < 0.7
    for segment in range(3):
        length = np.where(rng.random(n) < 0.5, rng.uniform(0.0, 1.0, n), rng.uniform(0.0, 6.0, n))
        absent = (missing == segment) | (twice & (missing == (segment + 1) % 3))
        length = np.where(absent, 0.0, length)
        if segment == 1:
            ahead = np.where(straight, length, 0.0)
            x, y = x + ahead * np.cos(heading), y + ahead * np.sin(heading)
            side, length = -turn, np.where(straight, 0.0, length)
        elif segment == 2:
            side = np.where(straight & (rng.random(n) < 0.5), -turn, turn)
        else:
            side = turn
        after = heading + side * length
        x, y = (
            x + side * (np.sin(after) - np.sin(heading)),
            y - side * (np.cos(after) - np.cos(heading)),
        )
        heading = after
    return ends(rng, x, y, a, heading, 2.5)


@pytest.mark.parametrize("draw", [anywhere, at_edges])
@pytest.mark.parametrize("n", [2_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_a_bound_is_below_every_length_in_its_box(draw, n):
    """With slopes of the potential and without, at distances from 0.05 R to 20 R."""
    boxes = draw(n, seed=n)

    margin = sampled(boxes) - bounds_of(boxes)

    # what the kernel's own rounding may take from a length; the bound is lowered for its own
    assert margin.min() >= -1e-14 * 30


def test_a_bound_beyond_four_radii_is_as_high_as_a_grid_can_tell():
    """Boxes up to 0.4 rad: not looser than the distance between grid points allows."""
    boxes = anywhere(4_000, seed=7)
    far = np.hypot(boxes[:, 0], boxes[:, 1]) >= 4.0
    boxes = boxes[far & (np.maximum(boxes[:, 3], boxes[:, 6]) < 0.4)]
    slope = np.abs(boxes[:, [4, 7]]) + 2.0  # of the length and of the potential
    step = 2.0 * boxes[:, [3, 6]] / (STEPS - 1)

    loose = sampled(boxes) - bounds_of(boxes)

    # the least is within half a step of the grid in both headings
    error = 0.5 * (slope * step).sum(axis=1)
    assert len(boxes) > 500
    assert (loose <= error + 2e-3 * boxes[:, [3, 6]].max(axis=1) + 1e-12).all()
    assert np.median(loose) < 1e-6


def test_a_bound_nearer_is_loose_by_little_in_small_boxes():
    """By at most a fifth of the box in nine of ten boxes: bounds there are of second order."""
    boxes = anywhere(6_000, seed=8)
    half = np.maximum(boxes[:, 3], boxes[:, 6])
    boxes, half = boxes[half < 0.01], half[half < 0.01]

    loose = (sampled(boxes) - bounds_of(boxes)) / half

    assert len(boxes) > 1_000
    assert np.quantile(loose, 0.9) < 0.2
    assert np.quantile(loose, 0.99) < 1.0


def shrinking(x, y, a, b, slope1, slope2):
    """How loose the bound is in boxes that shrink about a pair of headings, their place skew."""
    halves = 10.0 ** -np.arange(3, 6)
    boxes = [(x, y, a + 0.3 * h, h, slope1, b - 0.4 * h, h, slope2) for h in halves]
    length = pose_rows(*(np.array([v]) for v in (0.0, 0.0, a, x, y, 1.0, b))).length[0]
    values = length - slope1 * 0.3 * halves - slope2 * 0.4 * halves
    return halves, values - bounds_of(np.array(boxes))


def test_the_slopes_of_a_path_make_its_bound_exact():
    """Away from edges, with the derivatives of its length as slopes: to second order."""
    for x, y, a, b, slope1, slope2 in smooth_paths():
        halves, loose = shrinking(x, y, a, b, slope1, slope2)

        assert (loose >= 0.0).all()
        assert (loose <= 60.0 * halves**2 + 1e-9 * halves + 1e-12).all()


def smooth_paths():
    rng = np.random.default_rng(5)
    while True:
        distance, direction = rng.uniform(1.0, 8.0), rng.uniform(-3.0, 3.0)
        x, y = distance * math.cos(direction), distance * math.sin(direction)
        a, b = rng.uniform(-3.0, 3.0, 2)
        h = 1e-5
        grid = [(a, b), (a + h, b), (a - h, b), (a, b + h), (a, b - h)]
        rows = pose_rows(
            *(
                np.array(v)
                for v in zip(*((0.0, 0.0, s, x, y, 1.0, t) for s, t in grid), strict=True)
            )
        )
        at = rows.length
        same = (rows.word == rows.word[0]).all() and min(rows.first[0], rows.last[0]) > 0.3
        if same and rows.middle[0] > 0.5 and max(rows.first[0], rows.last[0]) < 2.5:
            yield x, y, a, b, (at[2] - at[1]) / (2 * h), (at[3] - at[4]) / (2 * h)
            if rng.random() < 0.05:
                return
