"""The way along an arc, as casadi's expressions of its turn and its length.

An arc of turn a and length h leads from the heading theta along its chord,

    h sinc(a/2) (cos(theta + a/2), sin(theta + a/2)),   sinc(z) = sin(z) / z.

As sinc(z) is the mean of cos(z t) over 0 <= t <= 1, a quadrature replaces the quotient, which is
undefined for a straight, by a sum of cosines that every engine can read.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dubins_study.study.path import FloatArray

INTEGRATORS = ("exact", "rk4")
_POINTS = 6


def mean_cosine(integrator: str) -> tuple[FloatArray, FloatArray]:
    """Points t in [0, 1] and weights of the quadrature that gives sinc(z) as a sum of cos(z t).

    `exact` is Gauss and Legendre's rule with 12 points, six of them positive: exact to rounding
    for |z| up to 3 pi / 2, a turn of 3 pi. `rk4`, the classical Runge-Kutta step of order 4, is
    Simpson's rule, since the heading is linear along the arc.
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
