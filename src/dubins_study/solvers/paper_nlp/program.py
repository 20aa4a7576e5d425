"""Cases of the paper's model (4.12) as programs for the engines of `solvers.nlp_engines`.

A program has the free lengths of its case alone: min z1 + z2 + z3 such that the two equations
(`paper_nlp.model.equations`) are zero and 0 <= z <= upper.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import (
    DeferredExpressions,
    Engine,
    EngineResult,
    Expressions,
    Functions,
    Program,
)
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.solvers.paper_nlp.model import end_point, equations, hessian, jacobian
from dubins_study.study.path import FloatArray


def program(case: Case) -> Program:
    """The program of a case; its variables are the free lengths in the case's unit, shape (n,).

    The parameters are the target (X, Y), and the radius after it where the unit is not the radius.
    """
    X, Y = case.target
    subproblem, unit = case.subproblem, case.unit
    upper, lower = case.upper[subproblem.mask], _zeros(len(subproblem.free))
    if unit == 1.0:
        posed = expressions(subproblem.free), np.array((X, Y)), lower, upper
        return Program(*posed, _written_in_radii(case), math.hypot(X, Y))
    posed = expressions(subproblem.free, True), unit * np.array((X, Y, 1.0)), lower, unit * upper
    return Program(*posed, _written(case), unit * math.hypot(X, Y))


def solve(case: Case, guess: FloatArray, seconds: float, engine: Engine) -> EngineResult:
    """The point z that an engine reaches from `guess`, both of shape (3,), in so many seconds."""
    free = list(case.subproblem.free)
    result = engine(program(case), case.unit * guess[free], seconds)
    return result._replace(x=_point(result.x if case.unit == 1.0 else result.x / case.unit, free))


@cache
def expressions(free: tuple[int, ...], scaled: bool = False) -> Expressions:
    """Model (4.12) with only the `free` lengths of z, the others zero.

    The radius is 1, or a parameter if `scaled`.
    """

    def write() -> Expressions:
        import casadi

        x = casadi.SX.sym("z", len(free))
        p = casadi.SX.sym("p", 3 if scaled else 2)
        R = p[2] if scaled else casadi.SX(1)
        z = [x[free.index(i)] if i in free else casadi.SX(0) for i in range(3)]
        x_end, y_end = end_point(z[0] / R, (z[0] - z[1]) / R, z[2], casadi, R)
        return Expressions(x, p, casadi.sum1(x), casadi.vertcat(p[0] - x_end, p[1] - y_end))

    return DeferredExpressions(write)


def _written_in_radii(case: Case) -> Functions:
    """The functions written by hand, for the unit of one radius."""
    X, Y = case.target
    free = list(case.subproblem.free)
    ones = _ones(len(free))
    return Functions(
        np.sum,
        lambda z: ones,
        lambda z: equations(_full(z, free), X, Y),
        lambda z: jacobian(_full(z, free))[:, free],
        lambda z, weights: hessian(_full(z, free), weights)[_block(case.subproblem.free)],
    )


@cache
def _zeros(n: int) -> FloatArray:
    return np.zeros(n)


@cache
def _ones(n: int) -> FloatArray:
    return np.ones(n)


@cache  # to make it takes as long as three evaluations
def _block(free: tuple[int, ...]) -> tuple[Any, ...]:
    """The index of the free lengths' rows and columns."""
    return np.ix_(free, free)


def _written(case: Case) -> Functions:
    """The same functions, their variables and equations in another unit."""
    unit, radii = case.unit, _written_in_radii(case)
    return Functions(
        radii.objective,
        radii.gradient,
        lambda z: unit * radii.equations(z / unit),
        lambda z: radii.jacobian(z / unit),
        lambda z, weights: radii.hessian(z / unit, weights) / unit,
    )


def _point(z: FloatArray, free: list[int]) -> FloatArray:
    """All three lengths, or three NaN where the engine returned no point."""
    full = _full(z, free)
    return full if math.isfinite(full.sum()) or not np.isnan(z).all() else np.full(3, np.nan)


def _full(z: FloatArray, free: list[int]) -> FloatArray:
    full = np.zeros(3)
    full[free] = z
    return full
