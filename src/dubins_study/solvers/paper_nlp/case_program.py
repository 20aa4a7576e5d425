"""Cases of the paper's model (4.12) as programs.

They are for NLP engines, in the free lengths alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from dubins_study.solvers.nlp_engines.program import (
    Entries,
    Expressions,
    Functions,
    NlpCall,
    Program,
)
from dubins_study.solvers.nlp_engines.violation import violation_slope
from dubins_study.solvers.one_leg.model import Case, end_point, equations, hessian, jacobian
from dubins_study.solvers.runs import EngineResult
from dubins_study.study.arrays import FloatArray

# (the case, an initial guess z of shape (3,) in radii, the seconds left) -> the end of the run,
# whose point is z and whose duals are those of the two equations
Solve = Callable[[Case, FloatArray, float], EngineResult]


def program(case: Case) -> Program:
    """The program of a case.

    Its variables are the free lengths in the case's unit, shape (n,). Its parameters are the target
    (X, Y), and the radius if the unit is not the radius.
    """
    X, Y, _ = case.target
    free = case.subproblem.free
    unit = case.unit
    scaled = unit != 1.0
    parameters = [X, Y]
    written = None
    if scaled:
        parameters.append(1.0)
    else:
        written = _written(case)
    return Program(
        partial(expressions, free, scaled),
        p=unit * np.array(parameters),
        lower=np.zeros(len(free)),
        upper=unit * case.upper[case.subproblem.mask],
        written=written,
        magnitude=unit * math.hypot(X, Y),
    )


def solve(case: Case, guess: FloatArray, seconds: float, engine: NlpCall) -> EngineResult:
    """The point z that an engine reaches from `guess`.

    Both have shape (3,). The engine stops after `seconds`.
    """
    free = list(case.subproblem.free)
    result = engine(program(case), case.unit * guess[free], seconds)
    z = np.zeros(3)
    if np.isnan(result.x).all():  # there is no point
        z[:] = np.nan
    z[free] = result.x / case.unit
    return result._replace(x=z)


def measured(solve: Solve) -> Solve:
    """The function `solve`, with `slope` in each result.

    The field `slope` is a function that computes the violation's slope at the result's point.
    """

    def run(case: Case, guess: FloatArray, seconds: float) -> EngineResult:
        result = solve(case, guess, seconds)
        x = case.unit * result.x[list(case.subproblem.free)]
        return result._replace(slope=partial(violation_slope, program(case), x))

    return run


@cache
def expressions(free: tuple[int, ...], scaled: bool) -> Expressions:
    """Model (4.12) with only the `free` lengths of z.

    The radius is a parameter if `scaled`.
    """
    import casadi

    x = casadi.SX.sym("z", len(free))
    p = casadi.SX.sym("p", 2 + scaled)
    R = casadi.SX(1)
    if scaled:
        R = p[2]
    z = [casadi.SX(0)] * 3
    for place, i in enumerate(free):
        z[i] = x[place]
    x_end, y_end = end_point(z[0] / R, (z[0] - z[1]) / R, z[2], casadi, R)
    gaps = casadi.vertcat(p[0] - x_end, p[1] - y_end)
    return Expressions(x, p, f=casadi.sum1(x), g=gaps)


def _written(case: Case) -> Functions:
    """A case's functions, written by hand.

    Their variables are the free lengths, in radii.
    """
    X, Y, _ = case.target
    free = case.subproblem.free
    ones = np.ones(len(free))
    places = slice(free[0], free[-1] + 1, free[1] - free[0])  # (0, 2) as 0:3:2

    def lengths(z: FloatArray) -> list[float]:
        """All three lengths, as Python's own numbers.

        Sums of these are five times as quick.
        """
        full = [0.0, 0.0, 0.0]
        full[places] = z.tolist()
        return full

    def slopes(z: FloatArray) -> FloatArray:
        return jacobian(lengths(z))[:, places]

    def curvatures(z: FloatArray, weights: FloatArray) -> FloatArray:
        return hessian(lengths(z), weights)[places, places]

    lower = np.tril_indices(ones.size)
    entries = Entries(
        np.indices((2, ones.size)).reshape(2, -1),
        lambda z: slopes(z).ravel(),
        np.array(lower),
        lambda z, weight, weights: curvatures(z, weights)[lower],  # the objective is linear
    )
    return Functions(
        objective=lambda z: sum(z.tolist()),
        gradient=lambda z: ones,
        equations=lambda z: equations(lengths(z), X, Y),
        jacobian=slopes,
        hessian=curvatures,
        entries=entries,
    )
