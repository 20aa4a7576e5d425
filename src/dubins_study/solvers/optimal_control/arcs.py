"""Paths of n arcs: their end points, gradients, and the way back to a target.

An arc of turn a and length h leads by h sinc(a/2) along the heading theta + a/2. As sinc(z) is the
mean of cos(z t) over 0 <= t <= 1, a quadrature replaces the quotient, which is undefined for a
straight, by a sum of cosines that every engine can read.

Everything in body coordinates in units of the turning radius. Step k drives the share w_k of the
whole length T, and turns by a_k = theta_k - theta_{k-1} (theta_{-1} = 0): written in the headings
theta instead of the rates, the end point's derivatives are local and |a_k| <= w_k T is linear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from dubins_study.study.path import FloatArray, Path
from dubins_study.study.scenario import Pose

INTEGRATORS = ("exact", "rk4")
_POINTS = 6


def mean_cosine(integrator: str) -> tuple[FloatArray, FloatArray]:
    """Points t in [0, 1] and weights of the quadrature that gives sinc(z) as a sum of cos(z t).

    `exact` is the rule of Gauss and Legendre with 12 points, exact to rounding up to a turn of 3
    pi. `rk4`, the classical Runge-Kutta step, is Simpson's rule, since the heading is linear along
    the arc.
    """
    if integrator == "rk4":
        return np.array((0.0, 1.0)), np.array((2.0, 1.0)) / 3
    points, weights = np.polynomial.legendre.leggauss(2 * _POINTS)
    return points[_POINTS:], weights[_POINTS:]


def chord(heading: Any, turn: Any, length: Any, integrator: str = "exact") -> tuple[Any, Any]:
    """How far an arc leads along x and along y; its heading at the start and its turn in rad."""
    from casadi import cos, sin

    half = turn / 2
    points, weights = mean_cosine(integrator)
    straight = length * sum(w * cos(half * t) for t, w in zip(points, weights, strict=True))
    return straight * cos(heading + half), straight * sin(heading + half)


HERE = Pose(0.0, 0.0, 0.0)
# Bounds on turns (rad). A shortest path turns by less than a full turn and, if it has two arcs, by
# pi/3 at most the other way (docs/derivation.md, section 4): elements of free length share
# MOST_TURN. No equally long element needs more than half a turn. Without these bounds a few
# elements take all the turning: full turns that lead nowhere, which in a collocated element even
# make the path shorter, by the error of the quadrature.
MOST_TURN = 3 * math.pi
MOST_TURN_EACH = math.pi
LEAST = 1e-3  # radii; elements of no length would be a poor guess


class Elements(NamedTuple):
    """Turns (n,) in rad, positive to the left, and lengths (n,) in radii of the elements."""

    turn: FloatArray
    length: FloatArray

    @property
    def rate(self) -> FloatArray:
        """Turn rates (n,) in units of 1 / radius; 0 for an element of no length."""
        some = self.length > 0
        return np.divide(self.turn, self.length, out=np.zeros_like(self.turn), where=some)

    @property
    def total(self) -> float:
        return float(self.length.sum())

    @property
    def path(self) -> Path:
        """The path in body coordinates at unit radius."""
        return Path(HERE, self.rate, self.length)


def cut(path: Path, n: int, shares: FloatArray | None) -> Elements:
    """A path in body coordinates at unit radius as n elements, not all of them of length 0.

    Elements with given shares (n,) of the length turn as the path does over their length. Otherwise
    every arc is cut into equal parts that turn by similar angles; more than n arcs become equally
    long elements.
    """
    some = path.length > 0
    curvature, length = path.curvature[some], path.length[some]
    if shares is None and length.size > n:
        shares = np.full(n, 1 / n)
    if shares is not None:
        ends = np.concatenate(([0.0], np.cumsum(shares)))
        ends[-1] = 1.0
        heading = path.at(ends * path.total_length)[:, 2]
        return Elements(np.diff(heading), shares * path.total_length)
    turn = curvature * length
    parts = np.ones(turn.size, dtype=int)
    for _ in range(n - turn.size):
        parts[np.argmax((np.abs(turn) + LEAST) / parts)] += 1
    return Elements(np.repeat(turn / parts, parts), np.repeat(length / parts, parts))


CLOSE = 1e-10  # turning radii; two digits inside the 1e-8 promised, far above rounding
SHARINGS = ("equal", "graded")
_TURNING = 2 * math.pi  # radii; a turn towards a target far away is shorter than a full circle
_CORRECTIONS = 30  # Newton's method takes 2 to 5; more are needed where rates reach their bounds


@dataclass(frozen=True, eq=False)
class Controls:
    """Headings at the ends of the steps, shape (n,), rad; whole length (turning radii)."""

    heading: FloatArray
    length: float

    @property
    def turns(self) -> FloatArray:
        """Turn of every step, shape (n,), rad, positive to the left."""
        turns = self.heading.copy()
        turns[1:] -= self.heading[:-1]
        return turns


class Rates(NamedTuple):
    """Least and largest turn rate allowed, in units of 1 / radius."""

    lower: float
    upper: float


# by branch: LS and RS forbid turning the other way
RATES = {"best": Rates(-1.0, 1.0), "LS": Rates(0.0, 1.0), "RS": Rates(-1.0, 0.0)}


def step_shares(n: int, mesh: str, distance: float) -> FloatArray:
    """The steps' shares (n,) of the length, summing to 1, for a target so many radii away.

    On `graded` half of the steps share about a full circle's length at the start, where the path
    turns, unless equal steps are shorter than that.
    """
    turning, straight = (n + 1) // 2, n // 2
    share = _TURNING / (_TURNING + distance)
    if mesh == "equal" or share >= turning / n:
        return np.full(n, 1.0 / n)
    return np.repeat((share / turning, (1 - share) / straight), (turning, straight))


class Rollout(NamedTuple):
    """End point (2,), its gradient by the headings (2, n), and the chords of the steps (2, n)."""

    end: FloatArray
    gradient: FloatArray
    chords: FloatArray


def rollout(controls: Controls, shares: FloatArray) -> Rollout:
    """End point of the path, its exact gradient by the headings, and the chords.

    The derivative by the length at fixed headings is `end / length`: every chord grows with it.
    The steps' `shares` (n,) of the length sum to 1.
    """
    half = controls.turns / 2
    lengths = shares * controls.length
    middle = controls.heading - half
    along = np.array([np.cos(middle), np.sin(middle)])
    across = np.array([-along[1], along[0]])
    sinc = _sinc(half)
    chords = lengths * sinc * along
    # d chord / d theta_k and d chord / d theta_{k-1}: the mean heading turns by half of each,
    # and the chord's length changes with the turn
    swing = (0.5 * lengths * sinc) * across
    stretch = (0.5 * lengths * _sinc_slope(half, sinc)) * along
    gradient = swing + stretch
    gradient[:, :-1] += (swing - stretch)[:, 1:]
    return Rollout(chords.sum(axis=1), gradient, chords)


def _sinc(x: FloatArray) -> FloatArray:
    values: FloatArray = np.sinc(x / np.pi)  # numpy's sinc(x) is sin(pi x) / (pi x)
    return values


def _sinc_slope(x: FloatArray, sinc: FloatArray) -> FloatArray:
    """Derivative of sin(x) / x; by its series where the quotient cancels (error below 1e-13)."""
    small = np.abs(x) < 0.02
    safe = np.where(small, 1.0, x)
    slope: FloatArray = np.where(
        small, -x / 3 * (1 - x * x / 10 * (1 - x * x / 28)), (np.cos(x) - sinc) / safe
    )
    return slope


def clipped(controls: Controls, shares: FloatArray, rates: Rates) -> Controls:
    """The controls with every turn rate brought within its bounds."""
    lengths = shares * controls.length
    turns = np.clip(controls.turns, rates.lower * lengths, rates.upper * lengths)
    return Controls(np.cumsum(turns), controls.length)


def corrected(
    controls: Controls, shares: FloatArray, rates: Rates, target: FloatArray, close: float = CLOSE
) -> tuple[Controls, float, int]:
    """Change the controls as little as needed for the path to end at the target.

    Newton's method in the turn rates and the length: the shortest step that solves the linearised
    equations, with rates that would leave their bounds set to the bound. Also returns the miss
    (radii) and the number of rollouts.
    """
    lengths = shares * controls.length
    rate = np.clip(controls.turns / lengths, rates.lower, rates.upper)
    length = controls.length
    best, least, rollouts = controls, np.inf, 0
    while rollouts < _CORRECTIONS:
        now = Controls(np.cumsum(rate * shares * length), length)
        rolled = rollout(now, shares)
        rollouts += 1
        residual = target - rolled.end
        miss = float(np.hypot(*residual))
        if miss < least:
            best, least = now, miss
        if miss <= close or not np.isfinite(miss):
            break
        jacobian = _rate_jacobian(now, rolled, shares)
        rate, length = _least_step(jacobian, residual, rate, length, rates)
    return best, least, rollouts


def _rate_jacobian(controls: Controls, rolled: Rollout, shares: FloatArray) -> FloatArray:
    """Derivatives (2, n + 1) of the end point by the rates and, last, by log(length)."""
    T = controls.length
    by_rate = np.cumsum(rolled.gradient[:, ::-1], axis=1)[:, ::-1] * (shares * T)
    # a longer path at fixed rates has longer chords and larger turns
    by_log_length = rolled.end + rolled.gradient @ controls.heading
    return np.column_stack((by_rate, by_log_length))


def _least_step(
    jacobian: FloatArray, residual: FloatArray, rate: FloatArray, length: float, rates: Rates
) -> tuple[FloatArray, float]:
    """The least-norm Newton step within the bounds on the rates; the length stays positive."""
    n = rate.size
    free = np.ones(n + 1, dtype=bool)
    step = np.zeros(n + 1)
    left = residual
    for _ in range(n):
        step[free] = np.linalg.lstsq(jacobian[:, free], left, rcond=1e-12)[0]
        moved = rate + step[:n]
        out = free[:n] & ((moved < rates.lower) | (moved > rates.upper))
        if not out.any():
            break
        step[:n][out] = np.clip(moved, rates.lower, rates.upper)[out] - rate[out]
        free[:n] &= ~out
        left = residual - jacobian[:, ~free] @ step[~free]
    bounded = np.clip(rate + step[:n], rates.lower, rates.upper)
    return bounded, length * float(np.exp(np.clip(step[n], -0.5, 0.5)))


_STEPS = 30  # Newton's method takes 1 to 4; more are needed where bounds cut steps short
_WITHIN = 0.9  # the share of the way to a bound that a step may go


def miss(elements: Elements, target: FloatArray) -> float:
    """Distance (radii) from where the controls, integrated exactly, end to the target (2,)."""
    end = elements.path.end
    return float(np.hypot(end.x - target[0], end.y - target[1]))


def closed(
    elements: Elements, rates: Rates, target: FloatArray, equal: bool
) -> tuple[Elements, float, int]:
    """Change the controls as little as needed for the path to end at the target.

    Newton's method in the rates and the lengths (only in the whole length if all are `equal`), with
    every variable in units of its distance from its bounds: what the solver left at a bound stays
    there, and to first order the length changes by no more than if the target had moved by the
    miss. Where no variable is free, as on a turning circle, the rates then change as needed. Also
    returns the miss (radii) and the number of rollouts.
    """
    # rounding of such coordinates leaves a miss of this size
    close = max(CLOSE, 8 * np.finfo(float).eps * float(np.abs(target).sum()))
    moved, rollouts = elements, 0
    for _ in range(_STEPS):
        rollouts += 1
        if not moved.total > 0 or (off := miss(moved, target)) <= close:
            break
        moved = _step(moved, rates, target, equal)
    off = miss(moved, target)
    if off <= close or not elements.total > 0:
        return moved, off, rollouts
    shares = elements.length / elements.total
    some = elements.length > 0
    controls = Controls(np.cumsum(elements.turn[some]), elements.total)
    bent, off, used = corrected(controls, shares[some], rates, target, close)
    turn = np.zeros_like(elements.turn)
    turn[some] = bent.turns
    return Elements(turn, shares * bent.length), off, rollouts + used


def _step(elements: Elements, rates: Rates, target: FloatArray, equal: bool) -> Elements:
    turn, length = elements
    rate, total = elements.rate, elements.total
    rolled = rollout(Controls(np.cumsum(turn), total), length / total)
    by_turn = np.cumsum(rolled.gradient[:, ::-1], axis=1)[:, ::-1]
    # derivatives by a rate in units of its distance to the nearer bound, and by a length at a
    # fixed rate
    slack = np.minimum(rate - rates.lower, rates.upper - rate)
    by_rate = by_turn * (length * slack)
    by_length = rolled.chords + by_turn * turn
    if equal:
        by_length = by_length.sum(axis=1, keepdims=True)
    jacobian = np.column_stack((by_rate, by_length))
    step = np.linalg.lstsq(jacobian, target - rolled.end, rcond=None)[0]
    step *= min(1.0, _WITHIN / max(float(np.abs(step).max()), 1e-300))
    rate = np.clip(rate + step[: turn.size] * slack, rates.lower, rates.upper)
    length = length * (1.0 + step[turn.size :])
    return Elements(rate * length, length)
