"""Problem (2.2) shot: the nonlinear programs of multiple shooting and of turn rates.

In the vehicle's frame at unit radius. Segment k has a turn rate u_k and a length h_k, so it turns
by a_k = u_k h_k; from the heading theta it leads along its chord

    h sinc(a/2) (cos(theta + a/2), sin(theta + a/2)),   sinc(z) = sin(z) / z.

As sinc(z) is the mean of cos(z t) over 0 <= t <= 1, a quadrature replaces the quotient, which is
undefined at rate 0, by a sum of cosines that every engine can read. Gauss and Legendre's rule with
12 points, six of which are positive, is exact to rounding for turns up to 3 pi. Simpson's rule is
the classical Runge-Kutta step of order 4 (`rk4`), since the heading is linear in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import Engine, Expressions, Program
from dubins_study.solvers.optimal_control.elements import Elements
from dubins_study.solvers.optimal_control.transcription import Transcribed
from dubins_study.solvers.optimal_control.turn_rate_dynamics import Rates
from dubins_study.study.path import FloatArray

_POINTS = 6  # positive ones
INTEGRATORS = ("exact", "rk4")


def mean_cosine(integrator: str) -> tuple[FloatArray, FloatArray]:
    """Points in [0, 1] and weights of the quadrature that gives sinc(z) as a sum of cos(z t)."""
    if integrator == "rk4":
        return np.array((0.0, 1.0)), np.array((2.0, 1.0)) / 3
    points, weights = np.polynomial.legendre.leggauss(2 * _POINTS)
    return points[_POINTS:], weights[_POINTS:]


def _chord(heading: Any, turn: Any, length: Any, integrator: str) -> tuple[Any, Any]:
    """How far a segment leads along x and along y."""
    from casadi import cos, sin

    half = turn / 2
    points, weights = mean_cosine(integrator)
    chord = length * sum(w * cos(half * t) for t, w in zip(points, weights, strict=True))
    return chord * cos(heading + half), chord * sin(heading + half)


@lru_cache(maxsize=32)
def expressions(n: int, free: bool, states: bool, integrator: str) -> Expressions:
    """The program over n segments; its variables are

        the turn rates (n,), the lengths (n,) or, if they are not free, the whole length (1,),
        and with states the pose (x, y, heading) at the start of each segment but the first.

    With states (multiple shooting) equations close the gaps between the segments; without them
    (single shooting) the only equations are those of the end point. The parameters are the target
    (2,) and, if the lengths are not free, the segments' shares (n,) of the whole length.
    """
    import casadi as ca

    rate, length = ca.SX.sym("u", n), ca.SX.sym("h", n if free else 1)
    target, shares = ca.SX.sym("target", 2), ca.SX.sym("share", 0 if free else n)
    lengths = length if free else shares * length
    pose = ca.SX.sym("pose", 3, n - 1 if states else 0)
    x, y, heading = ca.SX(0), ca.SX(0), ca.SX(0)
    gaps = []
    for k in range(n):
        turn = rate[k] * lengths[k]
        along, across = _chord(heading, turn, lengths[k], integrator)
        x, y, heading = x + along, y + across, heading + turn
        if states and k < n - 1:
            gaps += [pose[0, k] - x, pose[1, k] - y, pose[2, k] - heading]
            x, y, heading = pose[0, k], pose[1, k], pose[2, k]
    gaps += [target[0] - x, target[1] - y]
    variables = ca.vertcat(rate, length, ca.vec(pose))
    parameters = ca.vertcat(target, shares)
    return Expressions(variables, parameters, ca.sum1(length), ca.vertcat(*gaps))


@dataclass(frozen=True, eq=False)
class Shooting:
    """A shooting program and its engine.

    Args:
        n: number of segments.
        shares: their shares of the whole length, shape (n,); None if their lengths are free.
        states: whether the poses between segments are variables.
    """

    n: int
    shares: FloatArray | None
    states: bool
    integrator: str
    engine: Engine

    def solve(self, guess: Elements, rates: Rates, target: FloatArray, until: float) -> Transcribed:
        """As `transcription.Template.solve`; the poses of the guess follow its controls."""
        n, shares = self.n, self.shares
        free = shares is None
        length = guess.length if free else np.array([guess.total])
        m = 3 * (n - 1) if self.states else 0
        start = guess.path.at(np.cumsum(guess.length)[:-1]) if self.states else np.zeros(0)
        end = n + length.size
        lower, upper = np.full(end + m, -np.inf), np.full(end + m, np.inf)
        lower[:n], upper[:n], lower[n:end] = rates.lower, rates.upper, 0.0
        program = Program(
            expressions(n, free, self.states, self.integrator),
            target if shares is None else np.concatenate((target, shares)),
            lower,
            upper,
        )
        begin = np.concatenate((guess.rate, length, start.ravel()))
        result = self.engine(program, np.clip(begin, lower, upper), until - perf_counter())
        length = np.maximum(result.x[n:end], 0.0)
        if shares is not None:
            length = shares * length
        elements = Elements(np.clip(result.x[:n], rates.lower, rates.upper) * length, length)
        duals = None if result.duals is None else result.duals[-2:]
        return Transcribed(elements, result._replace(duals=duals))
