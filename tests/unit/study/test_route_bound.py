"""A leg's lower bound over boxes of headings, beside lengths that other code computes."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from cases import driven

from dubins_study.study.closed_form.pose_kernel import pose_rows
from dubins_study.study.route import leg_bound
from dubins_study.study.route.box import (
    END_HALF,
    END_LEFT,
    END_RIGHT,
    START_HALF,
    START_LEFT,
    START_RIGHT,
    Box,
)

STEPS = 41  # headings across each interval


@numba.njit
def bounds_apart(boxes, apart):
    bounds = np.empty(len(boxes))
    for i in range(len(boxes)):
        x, y, c1, h1, slope1, c2, h2, slope2 = boxes[i]
        bounds[i], _ = leg_bound.box_bound(Box(x, y, c1, h1, slope1, c2, h2, slope2, apart[i]))
    return bounds


def bounds_of(boxes):
    return bounds_apart(boxes, np.zeros(len(boxes), np.int64))


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
    pose = np.zeros(n), np.zeros(n), a
    turn = rng.choice([-1.0, 1.0], n)
    missing = rng.integers(0, 3, n)
    twice, straight, changed = (rng.random(n) < share for share in (0.3, 0.7, 0.5))
    turns = turn, np.where(straight, 0.0, -turn), np.where(straight & changed, -turn, turn)
    for segment in range(3):
        length = np.where(rng.random(n) < 0.5, rng.uniform(0.0, 1.0, n), rng.uniform(0.0, 6.0, n))
        absent = (missing == segment) | (twice & (missing == (segment + 1) % 3))
        pose = driven(pose, turns[segment], np.where(absent, 0.0, length))
    x, y, heading = pose
    return ends(rng, x, y, a, heading, 2.5)


@pytest.mark.parametrize("draw", [anywhere, at_edges])
@pytest.mark.parametrize("n", [2_000, pytest.param(30_000, marks=pytest.mark.slow)])
def test_a_bound_is_below_every_length_in_its_box(draw, n):
    """With slopes of the potential and without, at distances from 0.05 R to 20 R."""
    boxes = draw(n, seed=n)

    margin = sampled(boxes) - bounds_of(boxes)

    # what the kernel's own rounding may take from a length; the bound is lowered for its own
    assert margin.min() >= -1e-14 * 30


def beside_arcs(n, seed):
    """Boxes with a point on the turning circle of a given heading, beside the heading of the arc.

    Also which circle it is. Every third arc is half a turn, every second leg driven backwards.
    """
    rng = np.random.default_rng(seed)
    arc = np.where(np.arange(n) % 3, rng.uniform(0.05, 6.2, n), math.pi)
    left, back = rng.random(n) < 0.5, np.arange(n) % 2 == 1
    side, way = np.where(left, 1.0, -1.0), np.where(back, -1.0, 1.0)
    # from a start at the origin; backwards its arcs end there
    x, y = way * np.sin(arc), side * (1.0 - np.cos(arc))
    heading = side * way * arc
    half = 10 ** rng.uniform(-4, -0.5, n)
    off = (half + 10 ** rng.uniform(-5, -1, n)) * rng.choice([-1.0, 1.0], n)
    slopes, zero = rng.uniform(-2.5, 2.5, n), np.zeros(n)
    start, end = [zero, zero, zero], [heading + off, half, slopes]
    columns = [np.where(back, b, a) for a, b in zip(start + end, end + start, strict=True)]
    x, y = np.where(back, -x, x), np.where(back, -y, y)
    circles = [
        np.where(left, START_LEFT, START_RIGHT) + np.where(arc == math.pi, START_HALF, 0),
        np.where(left, END_LEFT, END_RIGHT) + np.where(arc == math.pi, END_HALF, 0),
    ]
    return np.stack([x, y, *columns], axis=1), np.where(back, circles[1], circles[0])


@pytest.mark.parametrize("n", [2_000, pytest.param(30_000, marks=pytest.mark.slow)])
def test_a_bound_beside_an_arc_is_below_every_length(n):
    """Where a point lies on a turning circle words are left out that no other heading has."""
    boxes, apart = beside_arcs(n, seed=n)

    lengths, bounds = sampled(boxes), bounds_apart(boxes, apart)

    # no box is nearer to the arc's heading than 1e-5, where rounding moves circles 4 apart by its
    # size, and the angles of the triangle with the third one 1e5 times as much
    assert (lengths - bounds).min() >= -1e-14 * 30 * 1e3
    assert (lengths - bounds)[apart < START_HALF].min() >= -1e-14 * 30
    assert np.median(lengths - bounds) < 1e-2
    # without this knowledge boxes beside a quarter turn have the arc's own length
    assert (bounds - bounds_of(boxes) > 1.0).mean() > 0.05


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
