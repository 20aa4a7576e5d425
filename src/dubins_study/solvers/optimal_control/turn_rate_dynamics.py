"""A path of n arcs described by its headings: end point, gradients, correction to a target.

Everything in the vehicle's frame in units of the turning radius. Step k drives the length
h_k = w_k T, where the shares w_k sum to 1 and T is the whole length, and turns by
a_k = theta_k - theta_{k-1} (theta_{-1} = 0), so its turn rate is u_k = a_k / h_k. Written in the
headings theta instead of the rates, the end point's derivatives are local and |u_k| <= 1 is the
linear |a_k| <= w_k T, exact for every T.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dubins_study.study.path import FloatArray

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

    On the mesh `equal` they are alike. On `graded` half of the steps share about a full circle's
    length at the start, where the path turns, unless equal steps are shorter than that.
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

    Args:
        controls: headings and whole length.
        shares: shape (n,), the steps' shares of the length, summing to 1.
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

    Newton's method on the two equations of the end point, in the turn rates and the length. The
    shortest step that solves the linearised equations is taken; a rate that would leave its
    bounds is set to the bound. Returns the controls, the miss (radii) and the number of rollouts.
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
