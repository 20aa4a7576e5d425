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

from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.study.arrays import FloatArray, IntArray
from dubins_study.study.body_coordinates import EPS


class Stages(NamedTuple):
    """The sizes of a control problem's stages.

    Each stage has a number of states, of controls and of equations. The equations of the next state
    are not counted.
    """

    nx: tuple[int, ...]
    nu: tuple[int, ...]
    ng: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Expressions:
    """A program in casadi's SX symbols.

    min f(x, p) subject to g(x, p) = 0 and bounds on x, with shapes (n,) for x, (k,) for p and (m,)
    for g. Engines keep their compiled form of an object, so a formulation keeps the object. With
    `stages`, x and g follow those of a control problem. x has the state of each stage, then its
    controls. g has the equations of each stage: first that it ends at the next state, then the
    others.
    """

    x: Any
    p: Any
    f: Any
    g: Any
    stages: Stages | None = None

    @cached_property
    def _compiled(self) -> _Compiled:
        """The compiled functions of casadi.

        The functions of derivatives return only the entries that may differ from zero. Beside them
        stand the rows and columns of these entries.
        """
        import casadi

        x = self.x
        f = self.f
        g = self.g
        weight = casadi.SX.sym("weight")
        weights = casadi.SX.sym("weights", g.numel())
        lagrangian = weight * f + casadi.dot(weights, g)
        jacobian = casadi.jacobian(g, x)
        hessian: Any = casadi.tril(casadi.hessian(lagrangian, x)[0])
        inputs = [x, self.p]
        return _Compiled(
            f=casadi.Function("f", inputs, [f]),
            gradient=casadi.Function("gradient", inputs, [casadi.gradient(f, x)]),
            g=casadi.Function("g", inputs, [g]),
            slopes=casadi.Function("slopes", inputs, [jacobian.nz[:]]),
            curvatures=casadi.Function("curvatures", [*inputs, weight, weights], [hessian.nz[:]]),
            jacobian_at=np.array(jacobian.sparsity().get_triplet()),
            hessian_at=np.array(hessian.sparsity().get_triplet()),
        )

    def functions(self, p: FloatArray) -> Functions:
        """The program's functions for parameters p, shape (k,).

        Whole matrices are filled here: casadi takes ten times as long, 50 ms at 200 legs.
        """
        compiled = self._compiled
        n = self.x.numel()
        m = self.g.numel()

        def slopes(x: FloatArray) -> FloatArray:
            return np.asarray(compiled.slopes(x, p).full()).ravel()

        def curvatures(x: FloatArray, weight: float, weights: FloatArray) -> FloatArray:
            return np.asarray(compiled.curvatures(x, p, weight, weights).full()).ravel()

        def jacobian(x: FloatArray) -> FloatArray:
            whole = np.zeros((m, n))
            whole[tuple(compiled.jacobian_at)] = slopes(x)
            return whole

        def hessian(x: FloatArray, weights: FloatArray) -> FloatArray:
            whole = np.zeros((n, n))
            rows, columns = compiled.hessian_at
            whole[rows, columns] = whole[columns, rows] = curvatures(x, 1.0, weights)
            return whole

        return Functions(
            objective=lambda x: float(compiled.f(x, p)),
            gradient=lambda x: np.asarray(compiled.gradient(x, p).full()).ravel(),
            equations=lambda x: np.asarray(compiled.g(x, p).full()).ravel(),
            jacobian=jacobian,
            hessian=hessian,
            entries=Entries(compiled.jacobian_at, slopes, compiled.hessian_at, curvatures),
        )


class _Compiled(NamedTuple):
    """A program's `casadi.Function`s, and its entries' places.

    The functions take x and p; `curvatures` takes weights too.
    """

    f: Any
    gradient: Any
    g: Any
    slopes: Any  # the Jacobian's entries
    curvatures: Any  # the entries of the Hessian's lower triangle
    jacobian_at: IntArray  # rows and columns, shape (2, entries)
    hessian_at: IntArray


class Entries(NamedTuple):
    """The derivatives' entries that may differ from zero.

    `jacobian_at` and `hessian_at` hold their rows and columns, shape (2, entries).
    """

    jacobian_at: IntArray
    jacobian: Callable[[FloatArray], FloatArray]  # of the equations at x, shape (entries,)
    hessian_at: IntArray  # of the lower triangle
    # (x, weight of f, weights of g (m,)) -> shape (entries,)
    hessian: Callable[[FloatArray, float, FloatArray], FloatArray]


class Functions(NamedTuple):
    """A program's functions of x, shape (n,).

    The Hessian is that of f + weights g.
    """

    objective: Callable[[FloatArray], float]
    gradient: Callable[[FloatArray], FloatArray]  # of f, shape (n,)
    equations: Callable[[FloatArray], FloatArray]  # shape (m,)
    jacobian: Callable[[FloatArray], FloatArray]  # of the equations, shape (m, n)
    hessian: Callable[[FloatArray, FloatArray], FloatArray]  # (x, weights (m,)) -> shape (n, n)
    entries: Entries  # for engines that take the derivatives' places


@dataclass(frozen=True, eq=False)
class Program:
    """One question's program.

    It has the values of p (k,), and bounds of x (n,), maybe infinite. Functions may be `written` by
    hand if these are quicker than casadi's. An engine that calls functions then loads no casadi, if
    `source` is a function that gives the expressions. `magnitude` is the size of the terms that the
    equations add up; some 1e-16 of it is their rounding. `bounds` of g, if they are not 0, are read
    by the engines of `casadi_nlpsol` only.
    """

    source: Expressions | Callable[[], Expressions]
    p: FloatArray
    lower: FloatArray
    upper: FloatArray
    written: Functions | None = None
    magnitude: float = 1.0
    bounds: tuple[FloatArray, FloatArray] | None = None

    @cached_property
    def expressions(self) -> Expressions:
        """The expressions, for engines that read them."""
        if isinstance(self.source, Expressions):
            return self.source
        return self.source()

    @cached_property
    def functions(self) -> Functions:
        """The functions, for engines that call them."""
        return self.written or self.expressions.functions(self.p)

    def attainable(self, options: Mapping[str, Any], *names: str) -> OptionValues:
        """A copy of options, with tolerances that rounding allows.

        `names` are options on the equations' violation. Values below the rounding of the equations
        are raised to it.
        """
        least = 64 * EPS * self.magnitude
        return {**options, **{key: max(options[key], least) for key in names if key in options}}


_QUICK_ITERATIONS = 3000  # Ipopt's default; on ten variables they take a third of a second


def needs_watch(max_iter: int | None, n: int) -> bool:
    """Whether runs on n variables watch the time.

    A run that may take half a second does: one with many variables, or with a high limit of
    iterations. In a quicker run these looks would cost a tenth of the time, or more than the
    iterations do.
    """
    return n > 10 or (max_iter or 0) > _QUICK_ITERATIONS


# (the program, an initial guess of shape (n,), the seconds left) -> the result
NlpCall = Callable[[Program, FloatArray, float], EngineResult]
