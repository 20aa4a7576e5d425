"""The QP of `turn-rate-qp`: stated in cvxpy, compiled once, solved for many parameter values."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import diags_array, issparse

from dubins_study.study.path import FloatArray


def _options(engine: str, n: int, seconds: float) -> dict[str, Any]:
    if engine == "piqp":
        return {"compute_timings": True}  # its limit of 250 iterations is short enough
    if engine == "clarabel":
        return {"time_limit": seconds}
    if engine == "osqp":
        # at 1e-6 and less it takes twice as long and stops at its limit, for the same paths
        return {"eps_abs": 1e-5, "eps_rel": 1e-5, "max_iter": 20_000, "time_limit": seconds}
    # its active-set method takes about 4 n steps, or cycles without end
    return {"threads": 1, "time_limit": seconds, "qp_iteration_limit": 20 * n + 200}


class Compiled:
    """A cvxpy problem in its engine's own form, with the place of every parameter in it.

    `problem.solve()` takes 1.2 ms at n = 50 to rebuild the matrices for new values, six times what
    PIQP needs for the solve itself. Here the problem is compiled for two sets of random values: an
    entry that differs is a parameter, or its negative, and its value tells which. New values are
    then written straight into the engine's arrays. Each parameter is an attribute, an array to be
    written into.
    """

    def __init__(self, problem: Any, parameters: list[Any], engine: str) -> None:
        self.problem = problem
        random = np.random.default_rng(1)
        sizes = [parameter.size for parameter in parameters]
        first, second = 1 + random.random((2, sum(sizes)))
        old, *_ = self._data(parameters, first, engine)
        new, self.chain, self.inverse = self._data(parameters, second, engine)
        self.frame = new
        self.places = {}
        for key, array in new.items():
            values, before = _numbers(array), _numbers(old.get(key))
            if values is not None and before is not None:
                self.places[key] = _places(before, values, first, second)
        self.values = np.zeros(sum(sizes))
        parts = np.split(self.values, np.cumsum(sizes)[:-1])
        self.memory: dict[str, Any] = {}  # the engine's, from one QP to the next
        for part, parameter in zip(parts, parameters, strict=True):
            setattr(self, parameter.name(), part.reshape(parameter.shape))

    def forget(self) -> None:
        """Let the engine start cold, so that no answer depends on an earlier question."""
        self.memory.clear()

    def _data(self, parameters: list[Any], values: FloatArray, engine: str) -> Any:
        done = 0
        for parameter in parameters:
            parameter.value = values[done : done + parameter.size].reshape(parameter.shape)
            done += parameter.size
        return self.problem.get_problem_data(engine, solver_opts={})

    def solve_compiled(self, options: dict[str, Any]) -> None:
        """Solve for the present `values`; the answer is in the problem and its variables.

        The arrays are fresh every time, since the engines' interfaces compare them with the last
        ones.
        """
        data = dict(self.frame)
        for key, (where, which, sign) in self.places.items():
            array = data[key].copy()
            _numbers(array)[where] = sign * self.values[which]
            data[key] = array
        raw = self.chain.solver.solve_via_data(
            data, warm_start=True, verbose=False, solver_opts=options, solver_cache=self.memory
        )
        # OSQP catches Ctrl-C itself
        if getattr(getattr(raw, "info", None), "status", None) == "interrupted":
            raise KeyboardInterrupt
        with warnings.catch_warnings():
            # the caller judges an answer at the engine's limit
            warnings.filterwarnings("ignore", "Solution may be inaccurate")
            self.problem.unpack_results(raw, self.chain, self.inverse)


class Answer(NamedTuple):
    """A QP's solution: changes of the headings z (n,) and of the length t, duals (2,), objective.

    `slack` is the sum of the slacks; `solved` is False if the engine stopped at a limit.
    """

    z: FloatArray
    t: float
    duals: FloatArray
    slack: float
    value: float
    solved: bool


class EngineError(RuntimeError):
    """The QP engine gave no usable answer; the message is the engine's."""


class Template(Compiled):
    """The QP for a number of steps and an engine.

    Lengths are in units of the present length, headings in units that the caller chooses:

        minimise    t + 1/2 sum_k c_k z_k^2 + penalty * sum(s)
        subject to  G z + q t + s_+ - s_- = r,  s >= 0     the end point, linearised
                    z_k - z_{k-1} - upper_k t <= above_k   |u| <= b, exact
                    z_{k-1} - z_k + lower_k t <= below_k
                    |z_k| <= reach,  |t| <= stretch        the trust region

    The parameters G (2, n), q, r (2,), upper, lower, above, below, c (n,), penalty, reach and
    stretch (1,) are attributes, arrays to be written into.
    """

    G: FloatArray
    q: FloatArray
    r: FloatArray
    upper: FloatArray
    lower: FloatArray
    above: FloatArray
    below: FloatArray
    c: FloatArray
    penalty: FloatArray
    reach: FloatArray
    stretch: FloatArray

    def __init__(self, n: int, engine: str) -> None:
        import cvxpy as cp

        self.n, self.engine = n, engine
        shapes: dict[str, Any] = {"G": (2, n), "q": 2, "r": 2}
        shapes |= dict.fromkeys(("penalty", "reach", "stretch"), 1)
        shapes |= dict.fromkeys(("upper", "lower", "above", "below", "c"), n)
        p = {
            name: cp.Parameter(shape, name=name, nonneg=name in ("c", "penalty"))
            for name, shape in shapes.items()
        }
        self.z, self.t, self.s = cp.Variable(n), cp.Variable(1), cp.Variable(4)
        ones = np.ones(n)
        turn = diags_array([ones, -ones[1:]], offsets=[0, -1], format="csc") @ self.z
        self.end = p["G"] @ self.z + cp.multiply(p["q"], self.t) + self.s[:2] - self.s[2:] == p["r"]
        bounds = [
            turn - cp.multiply(p["upper"], self.t) <= p["above"],
            cp.multiply(p["lower"], self.t) - turn <= p["below"],
            self.z <= p["reach"],
            -self.z <= p["reach"],
            self.t <= p["stretch"],
            -self.t <= p["stretch"],
            self.s >= 0,
        ]
        bend = 0.5 * (p["c"] @ cp.square(self.z))
        objective = cp.sum(self.t) + bend + cp.sum(cp.multiply(p["penalty"], self.s))
        problem = cp.Problem(cp.Minimize(objective), [self.end, *bounds])
        super().__init__(problem, list(p.values()), engine.upper())

    def solve(self, seconds: float) -> Answer:
        """Solve the QP for the parameters' present values; an EngineError if there is no answer."""
        import cvxpy as cp

        problem = self.problem
        try:
            self.solve_compiled(_options(self.engine, self.n, seconds))
        except cp.error.SolverError as error:
            raise EngineError(str(error)) from error
        if self.z.value is None or problem.status not in cp.settings.SOLUTION_PRESENT:
            raise EngineError(str(problem.status))
        z, t, slack = self.z.value, float(self.t.value[0]), float(np.abs(self.s.value).sum())
        # not problem.value, which is the objective at the parameters of the compilation
        value = t + 0.5 * float(self.c @ z**2) + float(self.penalty[0]) * slack
        if not (np.isfinite(value) and np.isfinite(self.end.dual_value).all()):
            raise EngineError(f"{problem.status}, with numbers that are not finite")
        return Answer(z, t, -self.end.dual_value, slack, value, problem.status == cp.OPTIMAL)


def _numbers(array: Any) -> Any:
    """A writable view of the floating-point numbers of a dense or sparse array; else None."""
    numbers = array.data if issparse(array) else array
    floats = isinstance(numbers, np.ndarray) and numbers.dtype == np.float64
    return numbers if floats and numbers.size else None


def _places(
    old: FloatArray, new: FloatArray, first: FloatArray, second: FloatArray
) -> tuple[Any, Any, FloatArray]:
    """Places, indices and signs of the parameters in an array compiled for two sets of values."""
    where = np.flatnonzero(old != new)
    order = np.argsort(first)
    nearest = np.searchsorted(first[order], np.abs(old[where]) - 1e-12)
    which = order[np.minimum(nearest, first.size - 1)]
    sign = np.sign(old[where])
    # a problem stated so that parameters are added or scaled would be a mistake in this file
    assert np.allclose(sign * first[which], old[where], rtol=0, atol=1e-12)
    assert np.allclose(sign * second[which], new[where], rtol=0, atol=1e-12)
    return where, which, sign


@lru_cache(maxsize=32)
def template(n: int, engine: str) -> Template:
    """The compiled QP; kept, since compiling takes as long as many solves."""
    return Template(n, engine)
