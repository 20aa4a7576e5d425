"""A nonlinear program with equations and bounds.

A formulation writes it once in casadi's expressions with parameters; a question gives these, the
bounds and an initial guess. Engines that want functions get compiled ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim


class Stages(NamedTuple):
    """How many states, controls and equations, but for those of the next state, a stage has."""

    nx: tuple[int, ...]
    nu: tuple[int, ...]
    ng: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Expressions:
    """min f(x, p) subject to g(x, p) = 0 and bounds on x, in casadi's SX symbols.

    Of shapes (n,) for x, (k,) for p, (m,) for g. Engines keep what they compiled of an object, so a
    formulation keeps it. With `stages`, x and g follow those of a control problem: the state, then
    the controls of a stage; that it ends at the next state, then its other equations.
    """

    x: Any
    p: Any
    f: Any
    g: Any
    stages: Stages | None = None

    @cached_property
    def _compiled(self) -> list[Any]:
        """f, its gradient, g, its Jacobian and the Lagrangian's Hessian as `casadi.Function`s."""
        import casadi

        x, f, g = self.x, self.f, self.g
        weights = casadi.SX.sym("weights", g.numel())
        curved = casadi.hessian(f + casadi.dot(weights, g), x)[0]
        first_order = (f, casadi.gradient(f, x), g, casadi.jacobian(g, x))
        return [
            *(casadi.Function("compiled", [x, self.p], [each]) for each in first_order),
            casadi.Function("compiled", [x, self.p, weights], [curved]),
        ]

    def functions(self, p: FloatArray) -> Functions:
        """The program's functions for parameters p, shape (k,)."""
        f, gradient, g, jacobian, hessian = self._compiled
        return Functions(
            lambda x: float(f(x, p)),
            lambda x: np.asarray(gradient(x, p).full()).ravel(),
            lambda x: np.asarray(g(x, p).full()).ravel(),
            lambda x: np.asarray(jacobian(x, p).full()),
            lambda x, weights: np.asarray(hessian(x, p, weights).full()),
        )


class DeferredExpressions(Expressions):
    """Expressions that are written when an engine first reads them.

    One that calls functions which a formulation has written by hand loads no casadi.
    """

    def __init__(self, write: Callable[[], Expressions]) -> None:
        vars(self)["write"] = write

    def __getattr__(self, name: str) -> Any:
        # called for what is not set yet
        if name not in ("x", "p", "f", "g"):
            raise AttributeError(name)
        vars(self).update(vars(self.write()))
        return vars(self)[name]


class Functions(NamedTuple):
    """A program's functions of x, shape (n,); the Hessian is that of f + weights g."""

    objective: Callable[[FloatArray], float]
    gradient: Callable[[FloatArray], FloatArray]  # of f, shape (n,)
    equations: Callable[[FloatArray], FloatArray]  # shape (m,)
    jacobian: Callable[[FloatArray], FloatArray]  # of the equations, shape (m, n)
    hessian: Callable[[FloatArray, FloatArray], FloatArray]  # (x, weights (m,)) -> shape (n, n)

    def curvature(self, x: FloatArray, objective: float, weights: FloatArray) -> FloatArray:
        """Second derivative of f times `objective` and g times `weights` (m,); shape (n, n)."""
        curved = self.hessian(x, weights)
        if objective == 1.0:
            return curved
        return curved + (objective - 1.0) * self.hessian(x, np.zeros(weights.size))


@dataclass(frozen=True, eq=False)
class Program:
    """One question's program: values of p (k,), and bounds of x (n,), maybe infinite.

    `written` are functions written by hand, if these are quicker than casadi's. Some 1e-16 of
    `magnitude`, that of the terms which the equations add up, is their rounding. `bounds` of g, if
    they are not 0, are read by the engines of `casadi_nlpsol` only.
    """

    expressions: Expressions
    p: FloatArray
    lower: FloatArray
    upper: FloatArray
    written: Functions | None = None
    magnitude: float = 1.0
    bounds: tuple[FloatArray, FloatArray] | None = None

    @cached_property
    def functions(self) -> Functions:
        """The functions, for engines that call some."""
        return self.written or self.expressions.functions(self.p)

    def attainable(self, options: Mapping[str, Any], *names: str) -> dict[str, Any]:
        """Options, no named tolerance on the equations less than what their rounding leaves."""
        least = 64 * EPS * self.magnitude
        return {**options, **{key: max(options[key], least) for key in names if key in options}}


class EngineResult(NamedTuple):
    """The end of one run. x, shape (n,), is NaN where the engine returns no point.

    With the duals, shape (m,), f + duals g is stationary in the free variables. Evaluations are
    those of the equations (or of the objective, if more), not of derivatives.
    """

    x: FloatArray
    claim: Claim
    duals: FloatArray | None
    iterations: int | None
    evaluations: int | None
    status: str
    message: str


_QUICK_ITERATIONS = 3000  # Ipopt's default; on ten variables they take a third of a second


def needs_watch(max_iter: int | None, n: int) -> bool:
    """Whether a run on n variables may take half a second, so that it looks at the time.

    In a quicker one these looks would cost a tenth of it, or more than the iterations do.
    """
    return n > 10 or (max_iter or 0) > _QUICK_ITERATIONS


def no_point(n: int, claim: Claim, status: str, message: str) -> EngineResult:
    """The end of a run that returned no point of the n variables, and counts nothing."""
    return EngineResult(np.full(n, np.nan), claim, None, None, None, status, message)


# (the program, an initial guess of shape (n,), the seconds left) -> the result
NlpCall = Callable[[Program, FloatArray, float], EngineResult]
