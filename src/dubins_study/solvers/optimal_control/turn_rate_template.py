"""The QP of `turn-rate-qp`, compiled once.

It is stated in cvxpy and solved for many sets of numbers.
"""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import diags_array, eye_array, issparse, kron

from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.study.arrays import FloatArray


class QpAnswer(NamedTuple):
    """A QP's solution.

    It has the changes of the headings z (N,) and of the lengths t (legs,), the duals (legs, 2) and
    the objective's value. `slack` is the sum of the slacks. `solved` is False if the engine stopped
    at a limit.
    """

    z: FloatArray
    t: FloatArray
    duals: FloatArray
    slack: float
    value: float
    solved: bool


class EngineError(RuntimeError):
    """The QP engine gave no usable answer.

    The message is the engine's.
    """


class Numbers(NamedTuple):
    """The numbers of a QP with N steps.

    `QpTemplate` has the program in which they stand, under the same names. Scalars are arrays of
    shape (1,).
    """

    G: FloatArray  # (2, N)
    P: FloatArray  # (2, legs), like q and r
    q: FloatArray
    r: FloatArray
    w: FloatArray  # (legs,)
    upper: FloatArray  # (N,), like lower, above, below and c
    lower: FloatArray
    above: FloatArray
    below: FloatArray
    c: FloatArray
    penalty: FloatArray
    reach: FloatArray
    stretch: FloatArray
    h: FloatArray
    r_h: FloatArray


_MARK = 1000.0  # larger than any other number in a compiled QP


class QpTemplate:
    """The compiled QP for n steps a leg.

    There are N steps in all, a final heading or none, and one engine. A leg's length changes by its
    part t of itself. Headings and lengths are in units that the caller chooses:

        minimise    sum_i w_i t_i + 1/2 sum_k c_k z_k^2 + penalty * sum(s)
        subject to  sum_k G_k z_k + P_i z_before + q_i t_i + s_+ - s_- = r_i,  s >= 0
                    z_k - z_{k-1} - upper_k t_i <= above_k   |u| <= b, exact
                    z_{k-1} - z_k + lower_k t_i <= below_k
                    h z_N + s_+ - s_- = r_h                  the final heading, if one is given
                    |z_k| <= reach,  |t_i| <= stretch        the trust region

    The first equation, two a leg, is the linearised end of the leg. Its z are those of the leg's
    own steps, and the one before them.

    cvxpy takes 1.2 ms at n = 50 to state the problem for new numbers, six times the time in which
    PIQP solves it. With cvxpy's parameters it takes gigabytes to compile 200 legs. Here the problem
    is compiled once, for marks: large numbers, each of its own size. An entry of the engine's
    matrices that is as large as a mark is this mark, or its negative. New numbers are later written
    to these places, straight into the engine's arrays.
    """

    def __init__(self, n: int, legs: int, final: bool, engine: str) -> None:
        import cvxpy as cp

        self.engine = engine
        self.n = n
        self.legs = legs
        N = n * legs
        self.z = cp.Variable(N)
        self.t = cp.Variable(legs)
        self.s = cp.Variable((4, legs))
        self.s_h = cp.Variable(2 * final)
        # the shapes of the numbers, in the order of the fields of `Numbers`
        shapes = [
            (2, N),  # G
            *[(2, legs)] * 3,  # P, q, r
            (legs,),  # w
            *[(N,)] * 5,  # upper, lower, above, below, c
            *[(1,)] * 5,  # penalty, reach, stretch, h, r_h
        ]
        ends = np.cumsum([np.prod(shape) for shape in shapes])
        # all marks in one line, cut where the next number begins
        parts = np.split(_MARK + np.arange(ends[-1]), ends[:-1])
        marks = Numbers(*[part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)])
        problem, self.ends = self.stated(marks)
        data, self.chain, self.inverse = problem.get_problem_data(engine.upper(), solver_opts={})
        # the engines' interfaces compare the arrays with the last ones: two sets take turns
        self.frames = [deepcopy(data), data]
        # for each array: places of marks in it, the numbers that go there, and their signs
        self.places = {}
        for key, array in data.items():
            values = _values(array)
            if values is not None:
                where = np.flatnonzero((np.abs(values) >= _MARK) & np.isfinite(values))
                # the number's place in the line of all numbers; `_solved` builds the same line
                which = (np.abs(values[where]) - _MARK).astype(int)
                self.places[key] = where, which, np.sign(values[where])
        self.memory: dict[str, Any] = {}  # the engine's, from one QP to the next

    def stated(self, p: Numbers) -> tuple[Any, list[Any]]:
        """State the problem in cvxpy for these numbers.

        Returns two values: the problem, and its equations of the legs' ends, for x and for y.
        """
        import cvxpy as cp

        n = self.n
        legs = self.legs
        ones = np.ones(n * legs)
        turn = diags_array([ones, -ones[1:]], offsets=[0, -1], format="csc") @ self.z
        a_leg = kron(eye_array(legs), np.ones((1, n)), format="csr")  # adds up a leg's steps
        # takes for each leg the heading at the end of the leg before it; 0 for the first leg
        before = diags_array([np.ones(legs - 1)], offsets=[-1], shape=(legs, legs)) @ (
            kron(eye_array(legs), np.eye(1, n, n - 1), format="csr")
        )
        ends = [
            a_leg @ cp.multiply(p.G[i], self.z)
            + cp.multiply(p.P[i], before @ self.z)
            + cp.multiply(p.q[i], self.t)
            + self.s[2 * i]
            - self.s[2 * i + 1]
            == p.r[i]
            for i in range(2)
        ]
        stretched = a_leg.T @ self.t
        bounds = [
            turn - cp.multiply(p.upper, stretched) <= p.above,
            cp.multiply(p.lower, stretched) - turn <= p.below,
            self.z <= p.reach,
            -self.z <= p.reach,
            self.t <= p.stretch,
            -self.t <= p.stretch,
            self.s >= 0,
        ]
        if self.s_h.size:
            arrives = cp.multiply(p.h, self.z[-1:]) + self.s_h[:1] - self.s_h[1:] == p.r_h
            bounds += [arrives, self.s_h >= 0]
        bend = 0.5 * (p.c @ cp.square(self.z))
        slack = cp.sum(self.s) + cp.sum(self.s_h)
        objective = p.w @ self.t + bend + p.penalty @ cp.reshape(slack, (1,), order="C")
        return cp.Problem(cp.Minimize(objective), [*ends, *bounds]), ends

    def _solved(self, numbers: Numbers, options: OptionValues) -> Any:
        """Solve the QP; return cvxpy's `Solution`.

        The solution is not written into the problem, which would evaluate the objective.
        """
        self.frames.reverse()
        data = dict(self.frames[0])
        every = np.concatenate([part.ravel() for part in numbers])
        for key, (where, which, sign) in self.places.items():
            _values(data[key])[where] = sign * every[which]
        raw = self.chain.solver.solve_via_data(
            data, warm_start=True, verbose=False, solver_opts=options, solver_cache=self.memory
        )
        # OSQP catches Ctrl-C itself
        if getattr(getattr(raw, "info", None), "status", None) == "interrupted":
            raise KeyboardInterrupt
        return self.chain.invert(raw, self.inverse)

    def solve(self, numbers: Numbers, options: OptionValues, seconds: float) -> QpAnswer:
        """Solve the QP for these numbers.

        Raises an EngineError if there is no answer.
        """
        import cvxpy as cp

        # PIQP has no limit of time; its 250 iterations are short enough
        limits: OptionValues = {}
        if self.engine != "piqp":
            limits["time_limit"] = seconds
        if self.engine == "highs":  # takes about four iterations a step, or cycles without end
            limits["qp_iteration_limit"] = 20 * self.z.size + 200
        try:
            self.solution = self._solved(numbers, options | limits)
        except cp.error.SolverError as error:
            raise EngineError(str(error)) from error
        status = str(self.solution.status)
        if status not in cp.settings.SOLUTION_PRESENT:
            raise EngineError(status)
        values = self.solution.primal_vars
        dual_values = self.solution.dual_vars
        z = values[self.z.id]
        t = values[self.t.id]
        slack = sum(float(np.abs(values[s.id]).sum()) for s in (self.s, self.s_h) if s.size)
        # not the problem's value, which is at the numbers of the compilation
        bend = 0.5 * (numbers.c @ z**2)
        value = float(numbers.w @ t + bend + numbers.penalty[0] * slack)
        duals = -np.column_stack([dual_values[end.id] for end in self.ends])
        if not (np.isfinite(value) and np.isfinite(duals).all()):
            raise EngineError(f"{status}, with numbers that are not finite")
        return QpAnswer(z, t, duals, slack=slack, value=value, solved=status == cp.OPTIMAL)


def _values(array: Any) -> Any:
    """The floating-point numbers of an array, as a view.

    The array is dense or sparse, and the view is writable. None if it has no such numbers.
    """
    values = array
    if issparse(array):
        values = array.data
    if isinstance(values, np.ndarray) and values.dtype == np.float64 and values.size:
        return values
    return None


@lru_cache(maxsize=32)
def template(n: int, legs: int, final: bool, engine: str) -> QpTemplate:
    """The compiled QP, kept from call to call.

    Compiling takes as long as many solves.
    """
    return QpTemplate(n, legs, final, engine)
