"""The QP of `turn-rate-qp`: stated in cvxpy, compiled once, solved for many sets of numbers."""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.sparse import diags_array, eye_array, issparse, kron

from dubins_study.study.arrays import FloatArray


class QpAnswer(NamedTuple):
    """A QP's solution: changes of headings z (N,) and lengths t (legs,), duals (legs, 2), value.

    `slack` is the sum of the slacks; `solved` is False if the engine stopped at a limit.
    """

    z: FloatArray
    t: FloatArray
    duals: FloatArray
    slack: float
    value: float
    solved: bool


class EngineError(RuntimeError):
    """The QP engine gave no usable answer; the message is the engine's."""


class QpTemplate:
    """The QP for n steps a leg, N in all, a final heading or none, and an engine.

    A leg's length changes by its part t of itself; headings are in units that the caller chooses,
    lengths in those of the caller too:

        minimise    sum_i w_i t_i + 1/2 sum_k c_k z_k^2 + penalty * sum(s)
        subject to  sum_k G_k z_k + P_i z_before + q_i t_i + s_+ - s_- = r_i,  s >= 0
                    z_k - z_{k-1} - upper_k t_i <= above_k   |u| <= b, exact
                    z_{k-1} - z_k + lower_k t_i <= below_k
                    h z_N + s_+ - s_- = r_h                  the final heading, if one is given
                    |z_k| <= reach,  |t_i| <= stretch        the trust region

    The first equation, two a leg, says where the leg leads, linearised; its z are those of its own
    steps, and the one before them. The numbers G (2, N), P, q, r (2, legs), w (legs,), upper,
    lower, above, below, c (N,), penalty, reach, stretch, h and r_h (1,) are attributes, arrays to
    be written into.

    cvxpy takes 1.2 ms at n = 50 to state the problem for new numbers, six times what PIQP needs to
    solve it; with cvxpy's parameters it takes gigabytes to compile 200 legs. Here the problem is
    compiled for two sets of random numbers: an entry of the engine's matrices that differs is one
    of these numbers, or its negative, and its value tells which. New numbers are then written
    straight into the engine's arrays.
    """

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> FloatArray: ...

    def __init__(self, n: int, legs: int, final: bool, engine: str) -> None:
        import cvxpy as cp

        self.engine, self.n, self.legs, N = engine, n, legs, n * legs
        self.z, self.t = cp.Variable(N), cp.Variable(legs)
        self.s = cp.Variable((4, legs))
        self.s_h = cp.Variable(2 if final else 0)
        shapes: dict[str, Any] = {"G": (2, N), "w": (legs,)}
        shapes |= dict.fromkeys(("P", "q", "r"), (2, legs))
        shapes |= dict.fromkeys(("penalty", "reach", "stretch", "h", "r_h"), (1,))
        shapes |= dict.fromkeys(("upper", "lower", "above", "below", "c"), (N,))
        sizes = [int(np.prod(shape)) for shape in shapes.values()]

        def parts(values: FloatArray) -> dict[str, FloatArray]:
            split = np.split(values, np.cumsum(sizes)[:-1])
            return {k: v.reshape(shapes[k]) for k, v in zip(shapes, split, strict=True)}

        self.names = tuple(shapes)
        first, second = 1 + np.random.default_rng(1).random((2, sum(sizes)))
        (earlier, _), (problem, self.ends) = (self.stated(parts(v)) for v in (first, second))
        old, *_ = earlier.get_problem_data(engine.upper(), solver_opts={})
        new, self.chain, self.inverse = problem.get_problem_data(engine.upper(), solver_opts={})
        # the engines' interfaces compare the arrays with the last ones: two sets take turns
        self.frames = [deepcopy(new), new]
        self.places = {}
        for key, array in new.items():
            values, before = _numbers(array), _numbers(old.get(key))
            if values is not None and before is not None:
                self.places[key] = _places(before, values, first, second)
        self.values = np.zeros(sum(sizes))
        self.memory: dict[str, Any] = {}  # the engine's, from one QP to the next
        for name, part in parts(self.values).items():
            setattr(self, name, part)

    def stated(self, p: dict[str, FloatArray]) -> tuple[Any, list[Any]]:
        """The problem in cvxpy for these numbers, and its first two equations."""
        import cvxpy as cp

        n, legs = self.n, self.legs
        ones = np.ones(n * legs)
        turn = diags_array([ones, -ones[1:]], offsets=[0, -1], format="csc") @ self.z
        a_leg = kron(eye_array(legs), np.ones((1, n)), format="csr")  # adds up a leg's steps
        before = diags_array([np.ones(legs - 1)], offsets=[-1], shape=(legs, legs)) @ (
            kron(eye_array(legs), np.eye(1, n, n - 1), format="csr")
        )
        ends = [
            a_leg @ cp.multiply(p["G"][i], self.z)
            + cp.multiply(p["P"][i], before @ self.z)
            + cp.multiply(p["q"][i], self.t)
            + self.s[2 * i]
            - self.s[2 * i + 1]
            == p["r"][i]
            for i in range(2)
        ]
        stretched = a_leg.T @ self.t
        bounds = [
            turn - cp.multiply(p["upper"], stretched) <= p["above"],
            cp.multiply(p["lower"], stretched) - turn <= p["below"],
            self.z <= p["reach"],
            -self.z <= p["reach"],
            self.t <= p["stretch"],
            -self.t <= p["stretch"],
            self.s >= 0,
        ]
        if self.s_h.size:
            arrives = cp.multiply(p["h"], self.z[-1:]) + self.s_h[:1] - self.s_h[1:] == p["r_h"]
            bounds += [arrives, self.s_h >= 0]
        bend = 0.5 * (p["c"] @ cp.square(self.z))
        slack = cp.sum(self.s) + cp.sum(self.s_h)
        objective = p["w"] @ self.t + bend + p["penalty"] @ cp.reshape(slack, (1,), order="C")
        return cp.Problem(cp.Minimize(objective), [*ends, *bounds]), ends

    def forget(self) -> None:
        """Let the engine start cold, so that no answer depends on an earlier question."""
        self.memory.clear()

    def _solved(self, options: dict[str, Any]) -> Any:
        """cvxpy's own solution for the present `values`.

        It is not written into the problem, which would evaluate the objective.
        """
        self.frames.reverse()
        data = dict(self.frames[0])
        for key, (where, which, sign) in self.places.items():
            _numbers(data[key])[where] = sign * self.values[which]
        raw = self.chain.solver.solve_via_data(
            data, warm_start=True, verbose=False, solver_opts=options, solver_cache=self.memory
        )
        # OSQP catches Ctrl-C itself
        if getattr(getattr(raw, "info", None), "status", None) == "interrupted":
            raise KeyboardInterrupt
        return self.chain.invert(raw, self.inverse)

    def solve(self, options: dict[str, Any], seconds: float) -> QpAnswer:
        """Solve the QP for the present numbers; an EngineError if there is no answer."""
        import cvxpy as cp

        try:
            # PIQP has no limit of time; its 250 iterations are short enough
            limits: dict[str, Any] = {} if self.engine == "piqp" else {"time_limit": seconds}
            if self.engine == "highs":  # takes about four iterations a step, or cycles without end
                limits["qp_iteration_limit"] = 20 * self.z.size + 200
            self.solution = self._solved(options | limits)
        except cp.error.SolverError as error:
            raise EngineError(str(error)) from error
        solution, status = self.solution, str(self.solution.status)
        if status not in cp.settings.SOLUTION_PRESENT:
            raise EngineError(status)
        values, dual_values = solution.primal_vars, solution.dual_vars
        z, t = values[self.z.id], values[self.t.id]
        slack = sum(float(np.abs(values[s.id]).sum()) for s in (self.s, self.s_h) if s.size)
        # not the problem's value, which is at the numbers of the compilation
        value = float(self.w @ t + 0.5 * (self.c @ z**2)) + float(self.penalty[0]) * slack
        duals = -np.column_stack([dual_values[end.id] for end in self.ends])
        if not (np.isfinite(value) and np.isfinite(duals).all()):
            raise EngineError(f"{status}, with numbers that are not finite")
        return QpAnswer(z, t, duals, slack, value, status == cp.OPTIMAL)


def _numbers(array: Any) -> Any:
    """A writable view of the floating-point numbers of a dense or sparse array; else None."""
    numbers = array.data if issparse(array) else array
    floats = isinstance(numbers, np.ndarray) and numbers.dtype == np.float64
    return numbers if floats and numbers.size else None


def _places(
    old: FloatArray, new: FloatArray, first: FloatArray, second: FloatArray
) -> tuple[Any, Any, FloatArray]:
    """Places, indices and signs of the numbers in an array compiled for two sets of them."""
    where = np.flatnonzero(old != new)
    order = np.argsort(first)
    nearest = np.searchsorted(first[order], np.abs(old[where]) - 1e-12)
    which = order[np.minimum(nearest, first.size - 1)]
    sign = np.sign(old[where])
    # a problem stated so that numbers are added or scaled would be a mistake in this file
    assert np.allclose(sign * first[which], old[where], rtol=0, atol=1e-12)
    assert np.allclose(sign * second[which], new[where], rtol=0, atol=1e-12)
    return where, which, sign


@lru_cache(maxsize=32)
def template(n: int, legs: int, final: bool, engine: str) -> QpTemplate:
    """The compiled QP; kept, since compiling takes as long as many solves."""
    return QpTemplate(n, legs, final, engine)
