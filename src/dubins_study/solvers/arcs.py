"""Paths of N arcs or straights over several legs.

The module computes where the legs end, and corrects a path that misses its points.

An arc of turn a and length h leads by h sinc(a/2) along the heading theta + a/2. The quotient in
sinc(z) is undefined for a straight. But sinc(z) is the mean of cos(z t) over 0 <= t <= 1, so a
quadrature replaces it by a sum of cosines that every engine can read.

Everything is in body coordinates in units of the turning radius. All legs have n elements, so that
N = n legs. The headings theta replace the turns a_k = theta_k - theta_{k-1} (theta_{-1} = 0): the
derivatives of a leg's end are then local, and |a_k| <= h_k is linear.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.course import Course, wrapped
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose

_POINTS = 12  # exact to rounding up to a turn of 3 pi
# points t in [0, 1] and weights of the rule of Gauss and Legendre for the mean of cos(z t)
_AT, _WEIGHTS = (half[_POINTS // 2 :] for half in np.polynomial.legendre.leggauss(_POINTS))


def chord(heading: Any, turn: Any, length: Any) -> tuple[Any, Any]:
    """The chord (x, y) of an arc, in radii.

    `heading` is the heading at the arc's start and `turn` its turn, both in rad. `length` is in
    radii. The values may be numbers or casadi expressions.
    """
    from casadi import cos, sin

    half = turn / 2
    # the sum is sinc(half), by the quadrature of the module's docstring
    straight = length * sum(w * cos(half * t) for t, w in zip(_AT, _WEIGHTS, strict=True))
    return straight * cos(heading + half), straight * sin(heading + half)


HERE = Pose(0.0, 0.0, 0.0)
# Bounds on turns (rad). A shortest path to a free final heading turns by less than a full turn and,
# if it has two arcs, by pi/3 at most the other way (docs/derivation.md, section 4): elements of
# free length share 3 pi. Three arcs between given headings, the middle one of up to a full turn,
# take 4 pi. No equally long element needs more than half a turn. Without these bounds a few
# elements take all the turning: full turns that lead nowhere, which in a collocated element even
# make the path shorter, by the error of the quadrature.
MOST_TURN_EACH = math.pi
LEAST = 1e-3  # radii; elements of no length would be a poor guess


def most_turn(course: Course, n: int, equal: bool) -> float:
    """The largest turn (rad) that one element may have.

    The largest turn of `equal` elements is pi. The n elements of free length on a leg share 4 pi.
    They share 3 pi if the course is one leg with a free final heading (see `MOST_TURN_EACH`).
    """
    if equal:
        return MOST_TURN_EACH
    arcs = 3
    if course.target is None:
        arcs = 4
    return arcs * math.pi / n


class Rates(NamedTuple):
    """Bounds on the turn rate (1 / radius)."""

    lower: float
    upper: float


# by branch: LS and RS forbid turning the other way
RATES = {"best": Rates(-1.0, 1.0), "LS": Rates(0.0, 1.0), "RS": Rates(-1.0, 0.0)}


class Elements(NamedTuple):
    """Turns and lengths of N elements.

    Turns (N,) are in rad, positive to the left. Lengths (N,) are in radii.
    """

    turn: FloatArray
    length: FloatArray

    @property
    def rate(self) -> FloatArray:
        """Turn rates (N,) in units of 1 / radius.

        The rate of an element of no length is 0.
        """
        long = self.length > 0
        return np.divide(self.turn, self.length, out=np.zeros_like(self.turn), where=long)

    @property
    def total(self) -> float:
        return float(self.length.sum())

    def within(self, rates: Rates) -> Elements:
        """New elements, with lengths and turn rates within bounds.

        Lengths below 0 become 0. A turn rate beyond a bound becomes that bound.
        """
        length = np.maximum(self.length, 0.0)
        return Elements(np.clip(self.turn, rates.lower * length, rates.upper * length), length)


def cut(path: Path, n: int, shares: FloatArray | None) -> Elements:
    """Cut a path into n elements.

    The path is in body coordinates at unit radius.

    With `shares`, shape (n,), each element gets its share of the path's length. It turns as much as
    the path does over that part. With None each arc is cut into equal parts; arcs that turn more
    get more parts. A path of no arc or of more than n arcs is cut into n equal lengths instead.
    """
    driven = path.lengths > 0
    curvature = path.curvatures[driven]
    length = path.lengths[driven]
    if shares is None and not 0 < length.size <= n:
        shares = np.full(n, 1 / n)
    if shares is not None:
        ends = np.concatenate(([0.0], np.cumsum(shares)))
        ends[-1] = 1.0
        heading = path.at(ends * path.length)[:, 2]
        return Elements(np.diff(heading), shares * path.length)
    turn = curvature * length
    parts = np.ones(turn.size, dtype=int)
    for _ in range(n - turn.size):
        # one more part for the arc whose parts turn most; `LEAST` lets a straight be cut too
        parts[np.argmax((np.abs(turn) + LEAST) / parts)] += 1
    return Elements(np.repeat(turn / parts, parts), np.repeat(length / parts, parts))


CLOSE = 1e-10  # turning radii; two digits inside the 1e-8 promised, far above rounding
SHARINGS = ("equal", "graded")
_TURNING = 2 * math.pi  # radii; a turn towards a target far away is shorter than a full circle


def step_shares(n: int, mesh: str, course: Course) -> FloatArray:
    """The share of each step in its leg's length.

    Shape (legs, n); each row sums to 1. On the mesh `equal` all shares are 1 / n. On the mesh
    `graded` the first half of the steps shares about a full circle's length, since a leg turns at
    its start. A leg on which equal steps are even shorter has equal steps.
    """
    turning = (n + 1) // 2
    straight = n // 2
    shares = np.full((course.legs, n), 1.0 / n)
    for leg, distance in enumerate(np.hypot(*course.steps.T).tolist()):
        share = _TURNING / (_TURNING + distance)  # of the turning steps together
        if mesh == "graded" and share < turning / n:
            parts = (share / turning, (1 - share) / straight)
            shares[leg] = np.repeat(parts, (turning, straight))
    return shares


class Rollout(NamedTuple):
    """Elements driven exactly, with derivatives of their chords.

    Each array has shape (2, N): x and y (radii) of each element's chord, or their derivatives. The
    derivatives are by the heading before and the heading after the element, at fixed lengths.
    """

    chords: FloatArray
    by_before: FloatArray
    by_after: FloatArray

    def gaps(self, elements: Elements, course: Course) -> FloatArray:
        """Each leg's step minus the sum of its chords.

        Shape (legs, 2), in radii.
        """
        legs = self.chords.reshape(2, course.legs, -1).sum(axis=2)
        gaps: FloatArray = course.steps - legs.T
        return gaps


def rollout(elements: Elements) -> Rollout:
    """Drive the elements from heading 0.

    Returns the chords and their derivatives. Both are exact.
    """
    half = elements.turn / 2
    middle = np.cumsum(elements.turn) - half
    along = np.array([np.cos(middle), np.sin(middle)])
    across = np.array([-along[1], along[0]])
    sinc: FloatArray = np.sinc(half / np.pi)  # numpy's sinc(x) is sin(pi x) / (pi x)
    # the mean heading turns by half of each heading, and the chord's length changes with the turn
    swing = (0.5 * elements.length * sinc) * across
    stretch = (0.5 * elements.length * _sinc_slope(half, sinc)) * along
    return Rollout(elements.length * sinc * along, swing - stretch, swing + stretch)


def _sinc_slope(x: FloatArray, sinc: FloatArray) -> FloatArray:
    """Derivative of sin(x) / x.

    Near 0, where the quotient cancels, the series is used (error below 1e-13).
    """
    small = np.abs(x) < 0.02
    safe = np.where(small, 1.0, x)
    slope: FloatArray = np.where(
        small, -x / 3 * (1 - x * x / 10 * (1 - x * x / 28)), (np.cos(x) - sinc) / safe
    )
    return slope


def remaining_turn(elements: Elements, course: Course) -> float:
    """The turn (rad) that remains to the final heading.

    The turn is from -pi to pi. It is 0 if the final heading is free.
    """
    if course.last is None:
        return 0.0
    return float(wrapped(course.last - elements.turn.sum()))


def missed(elements: Elements, course: Course, rolled: Rollout | None = None) -> FloatArray:
    """Differences between the points and the path, shape (m,).

    Each point has two (x, y in radii): the point minus the place where the path's leg ends. A final
    heading, if given, adds one: the turn that remains (rad). `rolled` is the elements' rollout if
    the caller has it.
    """
    # gaps of legs add up to those of points
    gaps = np.cumsum((rolled or rollout(elements)).gaps(elements, course), axis=0).ravel()
    if course.last is None:
        return gaps
    return np.append(gaps, remaining_turn(elements, course))


def miss(elements: Elements, course: Course) -> float:
    """The largest miss of a path.

    Distances from the points (radii) and the angle from the final heading (rad) are compared as
    numbers.
    """
    return largest(missed(elements, course), course)


def largest(gaps: FloatArray, course: Course) -> float:
    """The largest of the differences that `missed` returns.

    A point's two differences count as one distance.
    """
    away = np.hypot(*gaps[: 2 * course.legs].reshape(-1, 2).T)
    return float(np.append(away, np.abs(gaps[2 * course.legs :])).max())


def slopes(elements: Elements, course: Course, rolled: Rollout) -> tuple[FloatArray, FloatArray]:
    """Derivatives of the places where legs end.

    Returns two arrays of shape (m, N), with rows in the order of `missed`: x and y of each leg's
    end, then a final heading if one is given. The first array is by the elements' turns. The second
    is by the elements' growth g at fixed rates, which multiplies length and turn by 1 + g.
    """
    legs = course.legs
    N = elements.turn.size
    ends = np.cumsum(rolled.chords, axis=1)
    last = np.arange(1, legs + 1) * (N // legs) - 1  # index of each leg's last element
    before = np.arange(N) <= last[:, None]  # a leg ends after these elements
    arm = (ends[:, last].T[:, :, None] - ends) * before[:, None]  # a turn swings what follows it
    by_turn = np.stack((-arm[:, 1], arm[:, 0]), axis=1) + rolled.by_after * before[:, None]
    by_growth = rolled.chords * before[:, None] + by_turn * elements.turn
    by_turn = by_turn.reshape(-1, N)
    by_growth = by_growth.reshape(-1, N)
    if course.last is not None:
        by_turn = np.vstack((by_turn, np.ones(N)))
        by_growth = np.vstack((by_growth, elements.turn))
    return by_turn, by_growth


def close_enough(course: Course) -> float:
    """The largest miss (radii) that needs no correction.

    It is `CLOSE`, or more if the rounding of far coordinates leaves more.
    """
    return max(CLOSE, 8 * np.finfo(float).eps * (course.magnitude - 1.0))


class Closed(NamedTuple):
    """Elements after a correction.

    `miss` is in radii. `rollouts` counts all rollouts of the correction. `rolled` is the rollout of
    these elements.
    """

    elements: Elements
    miss: float
    rollouts: int
    rolled: Rollout


_STEPS = 30  # at most; Newton's method takes 1 to 5, and more where rates reach their bounds
_MOST_GROWTH = 0.5  # of the logarithm of a length, in one step
_WITHIN = 0.9  # the share of the way to a bound that a gentle step may go


def closed(elements: Elements, rates: Rates, course: Course, equal: bool) -> Closed:
    """Change the controls as little as the points need.

    Returns them with their miss, and the number of rollouts of both corrections.

    First the correction is gentle: every variable is in units of its distance from its bounds. A
    variable that the solver left at a bound therefore stays there. To first order the length
    changes by no more than if the points had moved by the miss. If `equal`, all elements of a leg
    grow by one factor.

    If that misses, for instance because no variable is free on a turning circle, a second
    correction starts from the same elements, with one factor a leg and rates that may leave the
    neighbourhood of their bounds.
    """
    gentle_result = corrected(elements, rates, course, equal=equal, gentle=True)
    if gentle_result.miss <= close_enough(course):
        return gentle_result
    free_result = corrected(elements, rates, course, equal=True)
    return free_result._replace(rollouts=gentle_result.rollouts + free_result.rollouts)


def corrected(
    elements: Elements,
    rates: Rates,
    course: Course,
    equal: bool = True,
    gentle: bool = False,
    steps: int = _STEPS,
) -> Closed:
    """Newton's method for the path to meet its points.

    Returns the iterate that misses least, after at most `steps` steps. The unknowns are the rates
    and the lengths. With `equal` all elements of a leg grow by one factor. With `gentle` the
    variables are in units of their distance from their bounds.
    """
    close = close_enough(course)
    current = elements
    best = None
    for rollouts in range(1, steps + 2):
        rolled = rollout(current)
        gaps = missed(current, course, rolled)
        off = largest(gaps, course)
        if best is None or off < best.miss:
            best = Closed(current, off, rollouts, rolled)
        # near enough, lost, or out of steps
        if not close < off < math.inf or not current.total > 0 or rollouts > steps:
            break
        by_turn, by_length = slopes(current, course, rolled)
        if equal:
            by_length = by_length.reshape(len(by_length), course.legs, -1).sum(axis=2)
        current = _moved(current, rates, by_turn, by_length, gaps, gentle)
    assert best is not None
    return best._replace(rollouts=rollouts)


def _moved(
    elements: Elements,
    rates: Rates,
    by_turn: FloatArray,
    by_length: FloatArray,
    gaps: FloatArray,
    gentle: bool,
) -> Elements:
    """The elements after one step of the correction.

    The step is the shortest one that solves the linearised equations. Rates stop at their bounds.
    `by_length` holds the derivatives by growth: one column a leg if all elements of a leg grow by
    one factor, else one column an element.
    """
    rate = elements.rate
    n = rate.size
    unit = np.ones(n)
    if gentle:
        unit = np.minimum(rate - rates.lower, rates.upper - rate)
    # by the rates in their units, and by the lengths' growth at fixed rates
    jacobian = np.column_stack((by_turn * (elements.length * unit), by_length))
    free = np.ones(jacobian.shape[1], dtype=bool)
    step = np.zeros(free.size)
    # a rate that a step takes beyond a bound is fixed there, and the others are solved for again
    for _ in range(n):
        residual = gaps - jacobian[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(jacobian[:, free], residual, rcond=1e-12)[0]
        if gentle:
            step *= min(1.0, _WITHIN / max(float(np.abs(step).max()), 1e-300))
        moved = rate + step[:n] * unit
        outside = free[:n] & ((moved < rates.lower) | (moved > rates.upper))
        if gentle or not outside.any():
            break
        fixed = np.flatnonzero(outside)
        step[fixed] = (np.clip(moved, rates.lower, rates.upper) - rate)[fixed]
        free[fixed] = False
    rate = np.clip(rate + step[:n] * unit, rates.lower, rates.upper)
    growth = 1.0 + step[n:]
    if not gentle:
        growth = np.exp(np.clip(step[n:], -_MOST_GROWTH, _MOST_GROWTH))
    length = elements.length * np.repeat(growth, n // growth.size)
    return Elements(rate * length, length)
