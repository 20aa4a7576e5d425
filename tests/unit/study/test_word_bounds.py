"""Bounds of the route search's words in boxes.

Each stands beside the least lengths that are found in its box.

The lengths come from circles and tangents that the package does not share. A bound has to hold for
any multipliers, and with the right ones its error falls with the square of the box. A leg's bound
of all words stands beside lengths that other code of the package computes.
"""

import math
from functools import cache

import numba
import numpy as np
import pytest

from dubins_study.study.closed_form.pose_kernel import pose_rows
from dubins_study.study.route import csc_bound as csc
from dubins_study.study.route import leg_bound
from dubins_study.study.route import lrl_bound as lrl
from dubins_study.study.route.box import (
    END_HALF,
    END_LEFT,
    END_RIGHT,
    START_HALF,
    START_LEFT,
    START_RIGHT,
    Box,
    circles_of,
    turning_bound,
)
from dubins_study.study.route.csc_bound import csc_bound
from dubins_study.study.route.lrl_bound import lrl_bound
from tests.cases import driven

LSL, LSR, LRL = range(3)
TOLERANCE = 3e-13  # what the lengths here lose by rounding; each bound is lowered for its own
_PI, _TWO_PI = math.pi, 2 * math.pi
_STEPS = 21  # headings across each interval
_ROUNDS = 40  # of a descent, each with 0.6 times the step before


@numba.njit
def arc(angle, gap):
    """Angle of an arc in [0, 2 pi).

    One that rounding has made negative stays so.
    """
    angle -= _TWO_PI * math.floor(angle / _TWO_PI)
    return angle - _TWO_PI if angle > _TWO_PI - gap else angle


@numba.njit
def word_length(word, x, y, t1, t2):
    """Length of the word.

    Infinite where it has no path; of LRL no outer arc is above the middle.
    """
    last = -1.0 if word == LSR else 1.0
    dx = x - last * math.sin(t2) + math.sin(t1)
    dy = y + last * math.cos(t2) - math.cos(t1)
    d, way = math.hypot(dx, dy), math.atan2(dy, dx)
    if word == LSL:
        gap = 1e-14 + 1e-15 / max(d, 1e-9)
        return d + arc(way - t1, gap) + arc(t2 - way, gap)
    if word == LSR:
        if d < 2.0 - 1e-15:
            return math.inf
        p = math.sqrt(max(0.0, (d - 2.0) * (d + 2.0)))
        way += math.atan2(2.0, p)
        gap = 1e-14 + (0.5 * p if p < 1e-7 else 1e-15 / p)  # with p = 0 the arcs are longer
        return p + arc(way - t1, gap) + arc(way - t2, gap)
    if d > 4.0 + 1e-15:
        return math.inf
    off = math.acos(min(1.0, d / 4.0))  # between the way and that to the middle circle
    gap = 1e-14 + 1e-15 / max(off, 1e-8)
    a = arc(way + off + _PI / 2 - t1, gap)
    c = arc(t2 - way + off - 1.5 * _PI, gap)
    middle = _PI + 2.0 * off
    return math.inf if max(a, c) > middle + 1e-12 else a + middle + c


@numba.njit
def arrivals(word, x, y, t1, found):
    """Final headings of paths with a vanishing segment.

    They begin with heading t1; a segment vanishes, or nearly all of them.

    Where circles touch, the last arc has no length, or the outer circles of LRL are 4 apart.
    """
    u, v = x + math.sin(t1), y - math.cos(t1)  # from the first circle's centre to the end
    q, way = math.hypot(u, v), math.atan2(v, u)
    n = 0
    if word != LRL and q >= 1.0:
        found[n] = way + math.asin(1.0 / q)
        n += 1
    for radius in (2.0, 4.0):
        side = _PI / 2 if radius == 2.0 else -_PI / 2
        cosine = (radius * radius - 1.0 - q * q) / (2.0 * q)
        if word != LSL and abs(cosine) <= 1.0:
            for turned in (math.acos(cosine), -math.acos(cosine)):
                found[n] = way + side + turned
                n += 1
    return n


@numba.njit
def beside(angle, middle):
    """An angle less the middle, in [-pi, pi)."""
    angle -= middle
    return angle - _TWO_PI * math.floor(angle / _TWO_PI + 0.5)


@numba.njit
def value_at(word, box, t1, t2):
    """Length with the potential.

    It is at headings less the middles; infinite outside of the box.
    """
    x, y, c1, h1, slope1, c2, h2, slope2 = box
    if abs(t1) > h1 or abs(t2) > h2:
        return math.inf
    return word_length(word, x, y, c1 + t1, c2 + t2) + slope1 * t1 - slope2 * t2


@numba.njit
def along_edges(word, box, t, forward, found):
    """Headings at the other end with vanishing segments.

    They are less the middle.
    """
    x, y, c1, _, _, c2, _, _ = box
    if forward:
        n = arrivals(word, x, y, c1 + t, found)
    elif word == LSR:  # driven backwards the word is the same
        n = arrivals(word, -x, -y, c2 + t + _PI, found)
    else:  # the mirror image is
        n = arrivals(word, -x, y, -c2 - t - _PI, found)
    for i in range(n):
        angle = found[i] if forward or word == LSR else -found[i]
        found[i] = beside(angle, c2 if forward else c1 + _PI)
    return n


@numba.njit
def single_arc_headings(x, y, kind):
    """Headings at both ends of an arc.

    It is one of the four arcs through both points.
    """
    half = math.asin(min(1.0, 0.5 * math.hypot(x, y)))
    half = (half if kind < 2 else _PI - half) * (1.0 if kind % 2 else -1.0)
    way = math.atan2(y, x)
    return way - half, way + half


@numba.njit
def least(word, box):
    """Least length in a box, with the potential.

    The search is on a grid, on edges, and downhill.
    """
    h1, h2 = box[3], box[6]
    best = math.inf
    t1 = 0.0
    t2 = 0.0
    for kind in range(4):
        a, b = single_arc_headings(box[0], box[1], kind)
        a, b = beside(a, box[2]), beside(b, box[5])
        value = value_at(word, box, a, b)
        if value < best:
            best = value
            t1 = a
            t2 = b
    found = np.empty(5)
    for place in range(_STEPS * _STEPS + 9 * _ROUNDS):
        # a grid at first, then ever smaller steps from the best headings
        on_grid = place < _STEPS * _STEPS
        step = (place - _STEPS * _STEPS) // 9
        if on_grid:
            near1 = h1 * (2.0 * (place % _STEPS) / (_STEPS - 1) - 1.0)
            near2 = h2 * (2.0 * (place // _STEPS) / (_STEPS - 1) - 1.0)
        else:
            if place % 9 == _STEPS * _STEPS % 9:
                s1 = t1
                s2 = t2
                size = 0.6**step / _STEPS
            near1 = min(max(s1 + (place % 3 - 1) * h1 * size, -h1), h1)
            near2 = min(max(s2 + (place // 3 % 3 - 1) * h2 * size, -h2), h2)
        value = value_at(word, box, near1, near2)
        if value < best:
            best = value
            t1 = near1
            t2 = near2
        for forward in (True, False):
            n = along_edges(word, box, near1 if forward else near2, forward, found)
            for i in range(n):
                a, b = (near1, found[i]) if forward else (found[i], near2)
                value = value_at(word, box, a, b)
                if value < best:
                    best = value
                    t1 = a
                    t2 = b
    return best


@numba.njit
def all_least(word, boxes):
    values = np.empty(len(boxes))
    for i in range(len(boxes)):
        values[i] = least(word, boxes[i])
    return values


def ends_of(word, t1, a, s, c):
    """Ends of the words' paths and final headings.

    The paths begin at the origin; the arrays have one shape.
    """
    pose = np.zeros_like(a), np.zeros_like(a), t1
    for turn, length in ((1.0, a), (-1.0 if word == LRL else 0.0, s), (1 - 2 * (word == LSR), c)):
        pose = driven(pose, turn, length)
    return pose


def holding(rng, word, arcs, half, slope1, slope2):
    """Boxes that hold the headings of paths.

    They lie somewhere in the box. All have one size, or any with None.
    """
    n = arcs[0].size
    t1 = rng.uniform(-_PI, _PI, n)
    x, y, t2 = ends_of(word, t1, *arcs)
    h1, h2 = np.full((2, n), half) if half else 10 ** rng.uniform(-14.0, -0.3, (2, n))
    if not half:
        h1, h2 = np.where(rng.random(n) < 0.1, 0.0, h1), np.where(rng.random(n) < 0.5, h1, h2)
        h2 = np.where(rng.random(n) < 0.1, 0.0, h2)
        slope1, slope2 = (
            np.where(rng.random(n) < 0.5, slope, rng.uniform(-2.5, 2.5, n))
            for slope in (slope1, slope2)
        )
    c1, c2 = t1 + h1 * rng.uniform(-0.9, 0.9, n), t2 + h2 * rng.uniform(-0.9, 0.9, n)
    return np.stack([x, y, c1, h1, slope1, c2, h2, slope2], axis=1)


def single_arc(rng, n, half):
    """LSL of one arc.

    Both circles are one. It is flat for a costate that no S between beats.
    """
    T = rng.uniform(0.2, 6.0, 20 * n)
    # of t1 = 0
    rho = rng.uniform(0.0, 3.0, 20 * n)
    angle = rng.uniform(-_PI, _PI, 20 * n)
    along = np.linspace(0.0, 1.0, 200)[:, None] * T
    flat = np.flatnonzero((rho * np.cos(along - angle)).max(axis=0) < 1.0)[:n]
    T = T[flat]
    rho = rho[flat]
    angle = angle[flat]
    slopes = 1.0 - rho * np.cos(angle), 1.0 - rho * np.cos(T - angle)
    return holding(rng, LSL, (T, 0 * T, 0 * T), half, *slopes)


def touching(rng, n, half):
    """LSR without S.

    It is flat with a multiplier of the circles' distance.
    """
    a, c = rng.uniform(0.3, 5.9, (2, n))
    tau = rng.uniform(0.0, 3.0, n)
    slope1, slope2 = (1.0 - np.cos(x) + tau * np.sin(x) for x in (a, c))
    return holding(rng, LSR, (a, 0 * a, c), half, slope1, -slope2)


def single_arc_of_two(rng, n, half):
    """LSR of one arc.

    It is the last one or the first. LSR is flat with multipliers of what vanishes.
    """
    arc = rng.uniform(0.3, 5.9, n)
    mu = rng.uniform(0.0, 3.0, n)
    tau = rng.uniform(-2.0, 2.0, n)
    flat = -0.5 * mu, 1.0 - (1.0 - 0.5 * mu) * np.cos(arc) + tau * np.sin(arc)
    last = rng.random(n) < 0.5
    arcs = np.where(last, 0.0, arc), 0.0 * arc, np.where(last, arc, 0.0)
    return holding(rng, LSR, arcs, half, np.where(last, *flat), -np.where(last, *flat[::-1]))


def smooth(word):
    def draw(rng, n, half):
        """Paths of three segments, flat by the length's derivatives."""
        a, c = rng.uniform(0.1, 3.0, (2, n))
        s = rng.uniform(_PI + 0.3, _TWO_PI - 0.3, n) if word == LRL else rng.uniform(1.0, 9.0, n)
        if word == LRL:
            a = a % (s / 2)
            c = c % (s / 2)
        pull = 0.0 if word != LRL else s / 2
        slope1, slope2 = (1.0 - np.cos(pull - x) / np.cos(pull) for x in (a, c))
        side = 1 if word != LSR else -1
        return holding(rng, word, (a, s, c), half, slope1, side * slope2)

    return draw


def vanishing_outer_arcs(rng, n, half):
    """LRL without its first arc, last, or both.

    It is flat with a multiplier for each of them.
    """
    s = rng.uniform(_PI + 0.3, _TWO_PI - 0.3, n)
    kind = rng.integers(3, size=n)
    a, c = (np.where(kind == i, rng.uniform(0.3, 3.0, n), 0.0) for i in (0, 1))
    mu1, mu2 = (np.where(arc > 0.0, 0.0, rng.uniform(0.0, 3.0, n)) for arc in (a, c))
    # with t1 = 0: the arcs' derivatives, by differences
    x, y, t2 = ends_of(LRL, 0.0 * s, a, s, c)

    def outer(t1, t2):
        dx, dy = x - np.sin(t2) + np.sin(t1), y + np.cos(t2) - np.cos(t1)
        way = np.arctan2(dy, dx)
        off = np.arccos(np.hypot(dx, dy) / 4.0)
        return np.array([way + off - t1, t2 - way + off]), _PI + 2.0 * off

    step = 1e-6
    parts = []
    for d1, d2 in ((step, 0.0), (0.0, step)):
        up, middle_up = outer(d1, t2 + d2)
        down, middle_down = outer(-d1, t2 - d2)
        off = np.remainder(up - down + _PI, _TWO_PI) - _PI
        rest = off.sum(axis=0) + middle_up - middle_down - mu1 * off[0] - mu2 * off[1]
        parts.append(rest / (2 * step))
    return holding(rng, LRL, (a, s, c), half, -parts[0], parts[1])


# of the search's bounds, each with the word that it is of
PARTS = {
    "csc": (LSL, LSR),
    "lrl": (LRL,),
    "straight in any direction": (LSL, LSR),
    "one circle, by turning": (LSL,),
    "one circle, by a costate": (LSL,),
    "no straight, best multipliers": (LSR,),
    "no straight, any multiplier": (LSR,),
    "no straight and a short arc, any multipliers": (LSR,),
    "triangle, any multipliers": (LRL,),
}
_CSC, _LRL, _STRAIGHT, _TURNING, _APEX, _EDGE, _TOUCHING, _SHORT, _TRIANGLE = range(len(PARTS))


@numba.njit
def part_bound(part, word, box, any1, any2, any3):
    """Bound of one of `PARTS`.

    It has multipliers from numbers in [0, 1); -infinite where it says nothing.
    """
    last = -1.0 if word == LSR else 1.0
    if part == _CSC:
        return csc_bound(box, last, math.inf)
    if part == _LRL:
        return lrl_bound(box)
    if part == _STRAIGHT:
        shift = 2.0 * any1 - 1.0
        return csc._straight_bound(box, last, shift, -_PI - shift, _PI - shift, 0.0)[0]
    circles = circles_of(box, last)
    if part == _TURNING:
        return circles.nearest + turning_bound(box, -1e-13)
    if part == _APEX:
        return csc._apex_bound(box, circles)
    if part == _TRIANGLE:
        if circles.nearest >= 4.0 or circles.turned > 0.5:
            return -math.inf
        low = _PI - math.asin(min(1.0, 0.25 * circles.farthest)) - 1e-13
        psis = (low, _PI - math.asin(0.25 * circles.nearest) + 1e-13)
        mu1, mu2 = max(0.0, 8.0 * any1 - 1.0), max(0.0, 8.0 * any2 - 1.0)
        tilt = 2.0 * any3 - 1.0 if mu1 + mu2 > 0.0 else 0.0
        rho = 0.3 + 6.0 * ((any1 + any2 + any3) % 1.0)
        axis = math.atan2(circles.dy, circles.dx)
        return lrl._triangle_bound(box, axis, psis, circles.turned, rho, tilt, mu1, mu2)
    if circles.farthest < 2.0:
        return -math.inf
    if part == _EDGE:
        return csc._edge_bound(box, circles)
    if part == _TOUCHING:
        return csc._touching_bound(box, circles, 4.0 * any1, 0.0, -1, 0.0)
    end = int(2.0 * any3)
    switch = math.atan2(circles.dy, circles.dx) + 0.5 * _PI
    short = abs(beside(switch, box.c1 if end == 0 else box.c2))
    short += box.h1 if end == 0 else box.h2
    if short > 1.0:
        return -math.inf
    return csc._short_bound(box, circles, 6.0 * any1 - 3.0, 4.0 * any2, end, short)


@numba.njit
def part_bounds(part, word, boxes, anything):
    bounds = np.empty(len(boxes))
    for i in range(len(boxes)):
        x, y, c1, h1, slope1, c2, h2, slope2 = boxes[i]
        box = Box(x, y, c1, h1, slope1, c2, h2, slope2, 0)
        any1, any2, any3 = anything[i]
        bounds[i] = part_bound(part, word, box, any1, any2, any3)
    return bounds


FAMILIES = {
    LSL: (smooth(LSL), single_arc),
    LSR: (smooth(LSR), touching, single_arc_of_two),
    LRL: (smooth(LRL), vanishing_outer_arcs),
}


@cache
@cache
def random_boxes(word, n):
    """Boxes of all sizes, and their lengths.

    They lie about paths of the word, at its edges and elsewhere.
    """
    rng = np.random.default_rng(n + word)
    boxes = np.concatenate([draw(rng, n, None) for draw in FAMILIES[word]])
    return boxes, all_least(word, boxes)


@pytest.mark.slow
@pytest.mark.parametrize("n", [40, 10_000])
@pytest.mark.parametrize(
    ("part", "word"), [(part, word) for part, words in PARTS.items() for word in words]
)
def test_a_bound_is_above_no_length_in_its_box(part, word, n):
    """A bound is above no length in its box.

    That holds whatever the slopes are and, where a part is asked for alone, its multipliers.
    """
    boxes, lengths = random_boxes(word, n)
    anything = np.random.default_rng(n).random((len(boxes), 3))

    bounds = part_bounds(list(PARTS).index(part), word, boxes, anything)

    assert np.isfinite(lengths).mean() > 0.98
    assert np.isfinite(bounds).mean() > 0.2
    assert (lengths - bounds).min() >= -TOLERANCE


# of each family the part that decides there, and by how many squares of its size the bound of a box
# may be loose: the median, and in 19 of 20 boxes
DECIDES = {
    "LSL": (smooth(LSL), LSL, "csc", 1e-3, 1e-3),
    "LSR": (smooth(LSR), LSR, "csc", 1e-3, 1e-3),
    "LRL": (smooth(LRL), LRL, "lrl", 2.0, 6.0),
    "LSL of one arc": (single_arc, LSL, "one circle, by a costate", 0.5, 10.0),
    "LSR without S": (touching, LSR, "no straight, best multipliers", 2.0, 4.0),
    "LSR of one arc": (single_arc_of_two, LSR, "no straight, best multipliers", 4.0, 16.0),
    "LRL without outer arcs": (vanishing_outer_arcs, LRL, "lrl", 2.0, 12.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("family", DECIDES)
def test_a_bound_of_a_flat_box_is_loose_by_the_square_of_its_size(family):
    """A flat box's bound is quadratically tight.

    It is loose by the square of its size, with the slopes of the path in it, and of the conditions
    that end there.
    """
    n = 600  # two quantiles need no more
    draw, word, part, median, most = DECIDES[family]
    for half in (1e-2, 1e-3, 1e-4):
        boxes = draw(np.random.default_rng(n), n, half)
        anything = np.zeros((len(boxes), 3))

        loose = all_least(word, boxes) - part_bounds(list(PARTS).index(part), word, boxes, anything)

        squares = np.maximum(loose - 1e-12, 0.0) / half**2
        assert np.median(squares) < median
        assert np.quantile(squares, 0.95) < most


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
    """Least potential lengths on grids in boxes.

    A grid is one of headings, in each box.
    """
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
    """Boxes at which lengths jump.

    They lie about paths of which one segment or two have no length.
    """
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
    """A bound is below every length in its box.

    It has slopes of the potential or none, at distances from 0.05 R to 20 R.
    """
    boxes = draw(n, seed=n)

    margin = sampled(boxes) - bounds_of(boxes)

    # what the kernel's own rounding may take from a length; the bound is lowered for its own
    assert margin.min() >= -1e-14 * 30


def beside_arcs(n, seed):
    """Boxes with a point on a turning circle.

    It is that of a given heading; the box is beside the heading of the arc.

    Also which circle it is. Every third arc is half a turn, every second leg driven backwards.
    """
    rng = np.random.default_rng(seed)
    arc = np.where(np.arange(n) % 3, rng.uniform(0.05, 6.2, n), math.pi)
    left = rng.random(n) < 0.5
    back = np.arange(n) % 2 == 1
    side = np.where(left, 1.0, -1.0)
    way = np.where(back, -1.0, 1.0)
    # from a start at the origin; backwards its arcs end there
    x, y = way * np.sin(arc), side * (1.0 - np.cos(arc))
    heading = side * way * arc
    half = 10 ** rng.uniform(-4, -0.5, n)
    off = (half + 10 ** rng.uniform(-5, -1, n)) * rng.choice([-1.0, 1.0], n)
    slopes = rng.uniform(-2.5, 2.5, n)
    zero = np.zeros(n)
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
    """A bound beside an arc is below every length.

    Where a point lies on a turning circle words are left out that no other heading has.
    """
    boxes, apart = beside_arcs(n, seed=n)

    lengths = sampled(boxes)
    bounds = bounds_apart(boxes, apart)

    # no box is nearer to the arc's heading than 1e-5, where rounding moves circles 4 apart by its
    # size, and the angles of the triangle with the third one 1e5 times as much
    assert (lengths - bounds).min() >= -1e-14 * 30 * 1e3
    assert (lengths - bounds)[apart < START_HALF].min() >= -1e-14 * 30
    assert np.median(lengths - bounds) < 1e-2
    # without this knowledge boxes beside a quarter turn have the arc's own length
    assert (bounds - bounds_of(boxes) > 1.0).mean() > 0.05
