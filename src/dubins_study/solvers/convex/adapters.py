"""Engines of convex problems: adapters and a table.

Each engine is called by its own interface or through cvxpy, with the same options. The options are
those that the maker names for accuracy: the absolute tolerance asked for, and no relative one.
Everything else is the maker's default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import (
    block_array,
    coo_matrix,
    csc_matrix,
    diags_array,
    eye_array,
    triu,
    vstack,
)

from dubins_study.solvers.highs import highs_rows, highs_run
from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex.problem import Point, Problem, ProblemError
from dubins_study.study.words import Claim


class Ask(NamedTuple):
    """The request to an engine.

    It has an absolute tolerance, and the seconds after which the engine ends.
    """

    tolerance: float
    seconds: float
    tuned: bool = False  # whether with the options that its makers advise


class Reply(NamedTuple):
    """The reply of an engine.

    It has the engine's point, if there is one, its claim, its own status, and its iterations.
    """

    point: Point | None
    claim: Claim
    status: str
    iterations: int | None = None


class Ended(NamedTuple):
    """The result of a library's call.

    `result` is the library's own object, which holds the status. Point and iterations are read from
    it.
    """

    result: Any
    point: Point | None = None
    iterations: Any = None


class NotSolvedError(Exception):
    """The interface returned nothing from the engine.

    The message is the interface's own.
    """


# What each adapter below returns for a problem that it has translated: a function that takes the
# engine's options by their names, solves the problem and returns how the run ended.
Prepared = Callable[[OptionValues], Ended]


class Conic(NamedTuple):
    """A problem in the form of conic engines.

    A x + s = b. The first `zeros` of s are zero, the next `positive` are at least 0, and the rest
    lie in cones. P is the quadratic term.
    """

    P: Any
    A: Any
    b: FloatArray
    zeros: int
    positive: int
    back: Callable[[FloatArray, FloatArray], Point]  # from x and the multipliers of the rows


def conic(problem: Problem) -> Conic:
    """The problem in the form of conic engines.

    Each finite end of a range becomes a row. The rows are, in this order: equations, upper ends and
    lower ends of the other rows, upper bounds and lower bounds of the variables, cones.
    """
    equal = problem.equal
    m = problem.l.size
    n = problem.q.size
    upper = ~equal & np.isfinite(problem.u)
    lower = ~equal & np.isfinite(problem.l)
    unit = eye_array(n)
    A = [problem.A[equal], problem.A[upper], -problem.A[lower], unit, -unit, -problem.C]
    ends = (problem.u[equal], problem.u[upper], -problem.l[lower], problem.ub, -problem.lb)
    sizes = [each.shape[0] for each in A]

    def back(x: FloatArray, s: FloatArray) -> Point:
        # parts in the order of A; multipliers of lower ends and lower bounds count as negative
        parts = np.split(s, np.cumsum(sizes)[:-1])
        y = np.zeros(m)
        y[equal] = parts[0]
        y[upper] += parts[1]
        y[lower] -= parts[2]
        return Point(x, y, parts[3] - parts[4], parts[5])

    P = _quadratic(problem)
    b = np.concatenate((*ends, problem.d))
    return Conic(P, csc_matrix(vstack(A)), b, sizes[0], sum(sizes[1:5]), back)


def _set(settings: Any, options: OptionValues) -> Any:
    settings.verbose = False
    for name, value in options.items():
        setattr(settings, name, value)
    return settings


def _quadratic(problem: Problem) -> Any:
    return csc_matrix(diags_array(problem.p))


def _boxed(problem: Problem) -> tuple[Any, FloatArray, FloatArray]:
    """The problem with its bounds as further rows.

    The m rows come first, then the bounds of the n variables. Returns three values: the matrix
    (m + n, n), the lower ends and the upper ends (m + n,).
    """
    A = csc_matrix(vstack((problem.A, eye_array(problem.q.size))))
    return A, np.concatenate((problem.l, problem.lb)), np.concatenate((problem.u, problem.ub))


def _point(x: Any, y: Any, z: Any) -> Point:
    """A point of a problem without cones."""
    return Point(np.array(x), np.array(y), np.array(z), np.zeros(0))


def _of_box(problem: Problem, x: Any, multipliers: Any) -> Point:
    """A point from x and the multipliers of `_boxed`."""
    return _point(x, *np.split(np.array(multipliers), (problem.l.size,)))


def _rows(problem: Problem, equations: Any, others: Any) -> FloatArray:
    """The multipliers of all rows in order, shape (m,).

    `equations` are the multipliers of the equations, `others` those of the other rows.
    """
    y = np.zeros(problem.l.size)
    y[problem.equal] = equations
    y[~problem.equal] = others
    return y


def piqp(problem: Problem) -> Prepared:
    import piqp as library

    equal = problem.equal
    rows = ~problem.equal
    P = _quadratic(problem)
    A = csc_matrix(problem.A[equal])
    G = csc_matrix(problem.A[rows])

    def solve(options: OptionValues) -> Ended:
        solver = library.SparseSolver()
        _set(solver.settings, options)
        solver.setup(
            P,
            problem.q,
            A,
            problem.u[equal],
            G,
            problem.l[rows],
            problem.u[rows],
            problem.lb,
            problem.ub,
        )
        solver.solve()
        result = solver.result
        y = _rows(problem, result.y, result.z_u - result.z_l)
        return Ended(result, _point(result.x, y, result.z_bu - result.z_bl), result.info.iter)

    return solve


def clarabel(problem: Problem) -> Prepared:
    import clarabel as library

    form = conic(problem)
    P = triu(form.P, format="csc")
    cones = [library.ZeroConeT(form.zeros), library.NonnegativeConeT(form.positive)]
    cones += [library.SecondOrderConeT(size) for size in problem.cones.tolist()]

    def solve(options: OptionValues) -> Ended:
        settings = _set(library.DefaultSettings(), options)
        result = library.DefaultSolver(P, problem.q, form.A, form.b, cones, settings).solve()
        return Ended(result, form.back(np.array(result.x), np.array(result.z)), result.iterations)

    return solve


def osqp(problem: Problem) -> Prepared:
    import osqp as library

    P = _quadratic(problem)
    box = _boxed(problem)

    def solve(options: OptionValues) -> Ended:
        solver = library.OSQP()
        solver.setup(P, problem.q, *box, verbose=False, **options)
        result = solver.solve(raise_error=False)
        return Ended(result, _of_box(problem, result.x, result.y), result.info.iter)

    return solve


def scs(problem: Problem) -> Prepared:
    import scs as library

    form = conic(problem)
    cone = {"z": form.zeros, "l": form.positive, "q": problem.cones.tolist()}
    data = {"P": triu(form.P, format="csc"), "A": form.A, "b": form.b, "c": problem.q}

    def solve(options: OptionValues) -> Ended:
        result = library.SCS(data, cone, verbose=False, **options).solve()
        return Ended(result, form.back(result["x"], result["y"]), result["info"]["iter"])

    return solve


def highs(problem: Problem) -> Prepared:
    import highspy as library

    model = library.HighsModel()
    model.lp_ = highs_rows(problem.q, problem.A, problem.l, problem.u, problem.lb, problem.ub)
    hessian = model.hessian_
    P = _quadratic(problem)
    hessian.dim_ = problem.q.size
    hessian.format_ = library.HessianFormat.kTriangular
    hessian.start_ = P.indptr
    hessian.index_ = P.indices
    hessian.value_ = P.data

    def solve(options: OptionValues) -> Ended:
        solver = highs_run(model, options)
        native_result = {"model_status": solver.getModelStatus().name}
        result = solver.getSolution()
        info = solver.getInfo()
        if not (result.value_valid and result.dual_valid):
            return Ended(native_result)
        # HiGHS's duals have the opposite sign
        y = -np.array(result.row_dual)
        z = -np.array(result.col_dual)
        return Ended(native_result, _point(result.col_value, y, z), max(0, info.qp_iteration_count))

    return solve


def proxqp(problem: Problem) -> Prepared:
    from proxsuite import proxqp as library

    equal = problem.equal
    n = problem.q.size
    P = _quadratic(problem)
    A = csc_matrix(problem.A[equal])
    C = csc_matrix(vstack((problem.A[~equal], eye_array(n))))
    low = np.concatenate((problem.l[~equal], problem.lb))
    high = np.concatenate((problem.u[~equal], problem.ub))

    def solve(options: OptionValues) -> Ended:
        solver = library.sparse.QP(n, A.shape[0], C.shape[0])
        _set(solver.settings, options)
        solver.init(P, problem.q, A, problem.u[equal], C, low, high)
        solver.solve()
        result = solver.results
        y = _rows(problem, result.y, result.z[:-n])
        return Ended(result, _point(result.x, y, result.z[-n:]), result.info.iter)

    return solve


def qpalm(problem: Problem) -> Prepared:
    import qpalm as library

    A, low, high = _boxed(problem)
    data = library.Data(problem.q.size, low.size)
    data.Q = triu(diags_array(problem.p), format="csc")
    data.q = problem.q
    data.A = A
    data.bmin = low
    data.bmax = high

    def solve(options: OptionValues) -> Ended:
        solver = library.Solver(data, _set(library.Settings(), options))
        solver.solve()
        point = _of_box(problem, solver.solution.x, solver.solution.y)
        return Ended(solver, point, solver.info.iter)

    return solve


def ecos(problem: Problem) -> Prepared:
    """Translate a problem for ECOS.

    ECOS takes no quadratic term. A further variable v replaces this term in the objective. A
    further cone says that sum p x^2 <= 2 v.
    """
    import ecos as library

    form = conic(problem)
    zeros = form.zeros
    squared = np.flatnonzero(problem.p)  # the variables in the quadratic term
    terms = squared.size
    scaled = coo_matrix(
        (-2 * np.sqrt(problem.p[squared]), (np.arange(terms), squared)),
        shape=(terms, problem.q.size),
    )
    # the further cone: |(2 v - 1, 2 sqrt(p) x)| <= 2 v + 1
    of_v = np.full((2, 1), -2.0)
    rows = csc_matrix(block_array([[form.A, None], [None, of_v], [scaled, None]]))
    ends = np.concatenate((form.b, [1.0, -1.0], np.zeros(terms)))
    sizes = [*problem.cones.tolist(), 2 + terms]
    dims = {"l": form.positive, "q": sizes, "e": 0}
    equations: tuple[Any, ...] = ()
    if zeros:
        equations = (csc_matrix(rows[:zeros]), ends[:zeros])
    G = csc_matrix(rows[zeros:])
    h = ends[zeros:]
    cost = np.append(problem.q, 1.0)

    def solve(options: OptionValues) -> Ended:
        result = library.solve(cost, G, h, dims, *equations, verbose=False, **options)
        y = np.zeros(0)
        if zeros:
            y = result["y"]
        # without those of the further cone
        multipliers = np.concatenate((y, result["z"][: h.size - 2 - terms]))
        point = form.back(result["x"][:-1], multipliers)
        return Ended(result, point, result["info"]["iter"])

    return solve


def daqp(problem: Problem) -> Prepared:
    """Translate a problem for DAQP: dense, bounds before rows."""
    import daqp as library

    n = problem.q.size
    P = np.diag(problem.p)
    A = problem.A.toarray()
    high = np.concatenate((problem.ub, problem.u))
    low = np.concatenate((problem.lb, problem.l))
    sense = np.where(high == low, 5, 0).astype(np.int32)  # 5: an equation

    def solve(options: OptionValues) -> Ended:
        result = library.solve(P, problem.q, A, high, low, sense, **options)
        x, _, _, info = result  # between them the objective and the status
        z, y = np.split(np.array(info["lam"]), (n,))
        return Ended(result, _point(x, y, z), info["iterations"])

    return solve


def through_cvxpy(engine: str, problem: Problem) -> Prepared:
    """State a problem in cvxpy.

    Returns a function that compiles the problem and solves it by the engine.
    """
    import cvxpy as cp

    form = conic(problem)
    x = cp.Variable(problem.q.size)
    flat = form.zeros + form.positive
    rows = [
        form.A[: form.zeros] @ x == form.b[: form.zeros],
        form.A[form.zeros : flat] @ x <= form.b[form.zeros : flat],
    ]
    inside = problem.C @ x + problem.d
    cones = []
    first = 0
    for size in problem.cones.tolist():
        cones.append(cp.SOC(inside[first], inside[first + 1 : first + size]))
        first += size
    length = cp.quad_form(x, cp.psd_wrap(form.P)) / 2 + problem.q @ x
    stated = cp.Problem(cp.Minimize(length), [*rows, *cones])

    def solve(options: OptionValues) -> Ended:
        """Solve as `stated.solve` does.

        That method does not return the engine's own status.
        """
        data, chain, inverse = stated.get_problem_data(engine.upper(), solver_opts=options)
        try:
            result = chain.solve_via_data(stated, data, solver_opts=options)
        except cp.error.SolverError as error:
            raise NotSolvedError(str(error)) from None
        try:
            stated.unpack_results(result, chain, inverse)
        except cp.error.SolverError:
            return Ended(result)
        if x.value is None or any(row.dual_value is None for row in (*rows, *cones)):
            return Ended(result)
        duals = [row.dual_value for row in rows]
        for cone in cones:
            duals.extend(cone.dual_value)
        point = form.back(x.value, np.concatenate([np.ravel(part) for part in duals]))
        return Ended(result, point, stated.solver_stats.num_iters)

    return solve


class Engine(NamedTuple):
    """A library of convex optimisation.

    cvxpy takes its options under the same names.
    """

    label: str  # its name as its makers write it
    package: str
    adapter: Callable[[Problem], Prepared]  # by its own interface
    # reads the status of its result, whether returned by its own interface or to cvxpy
    status: Callable[[Any], Any]
    tolerances: tuple[str, ...]  # names of the absolute tolerances
    zeros: tuple[str, ...] = ()  # names of the relative tolerances, which are set to 0
    seconds: str = ""  # name of the time limit; empty where there is none
    others: Mapping[str, Any] = MappingProxyType({})  # further options and their values
    cones: bool = False  # whether it takes second-order cones
    least: float = 0.0  # smallest tolerance that it takes
    tuned: Mapping[str, Any] = MappingProxyType({})  # its makers' advice, beside the rest

    def options(self, ask: Ask) -> OptionValues:
        """The options of a run: their names and values."""
        values = dict.fromkeys(self.tolerances, max(ask.tolerance, self.least))
        values |= dict.fromkeys(self.zeros, 0.0) | dict(self.others)
        if ask.tuned:
            values |= self.tuned
        if self.seconds:
            values[self.seconds] = ask.seconds
        return values


_MANY = 10**7  # iterations: the time limit ends first
_INFO_STATUS = attrgetter("info.status")
_INFO_STATUS_NAME = attrgetter("info.status.name")

# Where cvxpy has other defaults than the maker, the maker's are used. The values without names are,
# in this order: label, package, adapter, status.
ENGINES = {
    "piqp": Engine(
        "PIQP",
        "piqp",
        piqp,
        _INFO_STATUS_NAME,
        tolerances=("eps_abs", "eps_duality_gap_abs"),
        zeros=("eps_rel", "eps_duality_gap_rel"),
    ),
    "clarabel": Engine(
        "Clarabel",
        "clarabel",
        clarabel,
        attrgetter("status"),
        tolerances=("tol_feas", "tol_gap_abs"),
        zeros=("tol_gap_rel",),
        seconds="time_limit",
        cones=True,
    ),
    "osqp": Engine(
        "OSQP",
        "osqp",
        osqp,
        _INFO_STATUS,
        tolerances=("eps_abs",),
        zeros=("eps_rel",),
        seconds="time_limit",
        others={"max_iter": _MANY, "polishing": False},
        tuned={"polishing": True},
    ),
    "scs": Engine(
        "SCS",
        "scs",
        scs,
        lambda result: result["info"]["status"],
        tolerances=("eps_abs",),
        zeros=("eps_rel",),
        seconds="time_limit_secs",
        others={"max_iters": _MANY},
        cones=True,
    ),
    "highs": Engine(
        "HiGHS",
        "highspy",
        highs,
        lambda result: result["model_status"],
        tolerances=("primal_feasibility_tolerance", "dual_feasibility_tolerance"),
        seconds="time_limit",
        others={"threads": 1},
        least=1e-10,
    ),
    "proxqp": Engine(
        "ProxQP",
        "proxsuite",
        proxqp,
        _INFO_STATUS_NAME,
        tolerances=("eps_abs", "eps_duality_gap_abs"),
        zeros=("eps_rel", "eps_duality_gap_rel"),
        # The tolerances on infeasibility are smaller than those on solutions: with the default,
        # 1e-4, it calls some feasible problems infeasible. The gap is checked on request only.
        tuned={"eps_primal_inf": 1e-12, "eps_dual_inf": 1e-12, "check_duality_gap": True},
    ),
    "qpalm": Engine(
        "QPALM",
        "qpalm",
        qpalm,
        _INFO_STATUS,
        tolerances=("eps_abs",),
        zeros=("eps_rel",),
        seconds="time_limit",
        others={"max_iter": _MANY, "eps_prim_inf": 1e-5, "eps_dual_inf": 1e-5},
    ),
    "ecos": Engine(
        "ECOS",
        "ecos",
        ecos,
        lambda result: result["info"]["infostring"],
        tolerances=("feastol", "abstol"),
        others={"reltol": 1e-300},
        cones=True,
    ),
    "daqp": Engine(
        "DAQP",
        "daqp",
        daqp,
        lambda result: result[2],
        tolerances=("primal_tol", "dual_tol"),
        seconds="time_limit",  # which cvxpy does not hand over
        others={"eps_prox": -1.0},
    ),
}


def prepare(engine: str, interface: str, problem: Problem) -> Callable[[Ask], Reply]:
    """Translate a problem for an engine.

    Returns the function that solves the problem. `interface` is `own` or `cvxpy`. An engine that
    takes no cones raises a ProblemError for a problem with cones.
    """
    table = ENGINES[engine]
    if problem.cones.size and not table.cones:
        raise ProblemError(f"{table.label} takes no cones; expected a QP")
    prepared = through_cvxpy(engine, problem) if interface == "cvxpy" else table.adapter(problem)

    def solve(ask: Ask) -> Reply:
        try:
            end = prepared(table.options(ask))
        except NotSolvedError as error:
            return Reply(None, Claim.FAILED, str(error))
        status = str(table.status(end.result))
        return Reply(end.point, claim_of(engine, status), status, end.iterations)

    return solve
