"""Engines of convex problems: by their own interface, and through cvxpy, with the same options.

Options are those that the maker names for accuracy, with the absolute tolerance asked for and no
relative one; everything else is the maker's default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, diags_array, eye_array, hstack, triu, vstack

from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex.problem import Point, Problem, ProblemError
from dubins_study.study.words import Claim


class Ask(NamedTuple):
    """What is asked of an engine: an absolute tolerance, and an end after some seconds."""

    tolerance: float
    seconds: float


class Reply(NamedTuple):
    """An engine's point, if it gives one, what it claims, its own status, and its iterations."""

    point: Point | None
    claim: Claim
    status: str
    iterations: int | None = None


Solve = Callable[[Ask], Reply]


class Engine(NamedTuple):
    """A library; cvxpy takes its options under the same names."""

    label: str  # its name as its makers write it
    package: str
    tolerances: tuple[str, ...]
    zeros: tuple[str, ...] = ()  # relative tolerances
    seconds: str = ""  # the limit of time, where there is one
    others: Mapping[str, Any] = MappingProxyType({})
    cones: bool = False
    least: float = 0.0  # tolerance that it takes

    def options(self, ask: Ask) -> dict[str, Any]:
        """Its options by their names."""
        values = dict.fromkeys(self.tolerances, max(ask.tolerance, self.least))
        values |= dict.fromkeys(self.zeros, 0.0) | dict(self.others)
        return values | ({self.seconds: ask.seconds} if self.seconds else {})


_MANY = 10**7  # iterations: the time limit ends first
_EPS = ("eps_abs",), ("eps_rel",)
_GAPS = "eps_duality_gap_abs", "eps_duality_gap_rel"
_FEASIBILITY = "primal_feasibility_tolerance", "dual_feasibility_tolerance"
_TOLS = "tol_feas", "tol_gap_abs"


# Where cvxpy has defaults of its own, the maker's stand here.
ENGINES = {
    "piqp": Engine("PIQP", "piqp", ("eps_abs", _GAPS[0]), ("eps_rel", _GAPS[1])),
    "clarabel": Engine("Clarabel", "clarabel", _TOLS, ("tol_gap_rel",), "time_limit", cones=True),
    "osqp": Engine(*("OSQP", "osqp", *_EPS, "time_limit"), {"max_iter": _MANY, "polishing": False}),
    "scs": Engine("SCS", "scs", *_EPS, "time_limit_secs", {"max_iters": _MANY}, cones=True),
    "highs": Engine(
        *("HiGHS", "highspy", _FEASIBILITY, (), "time_limit"), {"threads": 1}, least=1e-10
    ),
    "proxqp": Engine("ProxQP", "proxsuite", *_EPS),
    "qpalm": Engine(
        *("QPALM", "qpalm", *_EPS, "time_limit"),
        {"max_iter": _MANY, "eps_prim_inf": 1e-5, "eps_dual_inf": 1e-5},
    ),
    "ecos": Engine("ECOS", "ecos", ("feastol", "abstol"), others={"reltol": 1e-300}, cones=True),
    # cvxpy does not hand its time limit over
    "daqp": Engine(
        *("DAQP", "daqp", ("primal_tol", "dual_tol"), (), "time_limit"), {"eps_prox": -1.0}
    ),
}

# the status of what an engine returns, by its own interface or to cvxpy
_STATUS: dict[str, Callable[[Any], Any]] = {
    "piqp": lambda result: result.info.status.name,
    "clarabel": lambda result: result.status,
    "osqp": lambda result: result.info.status,
    "scs": lambda result: result["info"]["status"],
    "highs": lambda result: result["model_status"],
    "proxqp": lambda result: result.info.status.name,
    "qpalm": lambda result: result.info.status,
    "ecos": lambda result: result["info"]["infostring"],
    "daqp": lambda result: result[2],
}


def _reply(engine: str, result: Any, point: Point | None, iterations: int | None) -> Reply:
    """An engine's reply, with the status of what it returned."""
    status = str(_STATUS[engine](result))
    return Reply(point, claim_of(engine, status), status, iterations)


class Conic(NamedTuple):
    """A x + s = b with s in zeros, then numbers of at least 0, then cones; P its quadratic term."""

    P: Any
    A: Any
    b: FloatArray
    zeros: int
    positive: int
    back: Callable[[FloatArray, FloatArray], Point]  # from x and the multipliers of the rows


def conic(problem: Problem) -> Conic:
    """The problem in the form of conic engines; each finite end is a row."""
    equal, m, n = problem.equal, problem.l.size, problem.q.size
    upper, lower = ~equal & np.isfinite(problem.u), ~equal & np.isfinite(problem.l)
    unit = eye_array(n)
    A = [problem.A[equal], problem.A[upper], -problem.A[lower], unit, -unit, -problem.C]
    ends = (problem.u[equal], problem.u[upper], -problem.l[lower], problem.ub, -problem.lb)
    sizes = [each.shape[0] for each in A]

    def back(x: FloatArray, s: FloatArray) -> Point:
        parts = np.split(s, np.cumsum(sizes)[:-1])
        y = np.zeros(m)
        y[equal] = parts[0]
        y[upper] += parts[1]
        y[lower] -= parts[2]
        return Point(x, y, parts[3] - parts[4], parts[5])

    P = csc_matrix(diags_array(problem.p))
    b = np.concatenate((*ends, problem.d))
    return Conic(P, csc_matrix(vstack(A)), b, sizes[0], sum(sizes[1:5]), back)


def _set(settings: Any, options: dict[str, Any]) -> Any:
    settings.verbose = False
    for name, value in options.items():
        setattr(settings, name, value)
    return settings


def _boxed(problem: Problem) -> tuple[Any, FloatArray, FloatArray]:
    """All rows and, behind them, the variables: matrix, lower and upper ends."""
    A = csc_matrix(vstack((problem.A, eye_array(problem.q.size))))
    return A, np.concatenate((problem.l, problem.lb)), np.concatenate((problem.u, problem.ub))


def _point(problem: Problem, x: Any, multipliers: Any) -> Point:
    """A point from the multipliers of `_boxed`."""
    y, z = np.split(np.array(multipliers), (problem.l.size,))
    return Point(np.array(x), y, z, np.zeros(0))


def piqp(problem: Problem) -> Solve:
    import piqp as library

    equal, rows = problem.equal, ~problem.equal
    matrices = diags_array(problem.p), problem.A[equal], problem.A[rows]
    P, A, G = (csc_matrix(each) for each in matrices)

    def solve(ask: Ask) -> Reply:
        solver = library.SparseSolver()
        _set(solver.settings, ENGINES["piqp"].options(ask))
        ends = problem.l[rows], problem.u[rows], problem.lb, problem.ub
        solver.setup(P, problem.q, A, problem.u[equal], G, *ends)
        solver.solve()
        result = solver.result
        y = np.zeros(problem.l.size)
        y[equal], y[rows] = result.y, result.z_u - result.z_l
        point = Point(np.array(result.x), y, result.z_bu - result.z_bl, np.zeros(0))
        return _reply("piqp", result, point, int(result.info.iter))

    return solve


def clarabel(problem: Problem) -> Solve:
    import clarabel as library

    form = conic(problem)
    P = triu(form.P, format="csc")
    cones = [library.ZeroConeT(form.zeros), library.NonnegativeConeT(form.positive)]
    cones += [library.SecondOrderConeT(size) for size in problem.cones.tolist()]

    def solve(ask: Ask) -> Reply:
        settings = _set(library.DefaultSettings(), ENGINES["clarabel"].options(ask))
        result = library.DefaultSolver(P, problem.q, form.A, form.b, cones, settings).solve()
        point = form.back(np.array(result.x), np.array(result.z))
        return _reply("clarabel", result, point, int(result.iterations))

    return solve


def osqp(problem: Problem) -> Solve:
    import osqp as library

    P, (A, low, high) = csc_matrix(diags_array(problem.p)), _boxed(problem)

    def solve(ask: Ask) -> Reply:
        solver = library.OSQP()
        solver.setup(P, problem.q, A, low, high, verbose=False, **ENGINES["osqp"].options(ask))
        result = solver.solve(raise_error=False)
        point = _point(problem, result.x, result.y)
        return _reply("osqp", result, point, int(result.info.iter))

    return solve


def scs(problem: Problem) -> Solve:
    import scs as library

    form = conic(problem)
    cone = {"z": form.zeros, "l": form.positive, "q": problem.cones.tolist()}
    data = {"P": triu(form.P, format="csc"), "A": form.A, "b": form.b, "c": problem.q}

    def solve(ask: Ask) -> Reply:
        result = library.SCS(data, cone, verbose=False, **ENGINES["scs"].options(ask)).solve()
        point = form.back(result["x"], result["y"])
        return _reply("scs", result, point, int(result["info"]["iter"]))

    return solve


def highs(problem: Problem) -> Solve:
    import highspy as library

    model, A = library.HighsModel(), csc_matrix(problem.A)
    lp, hessian = model.lp_, model.hessian_
    lp.num_col_, lp.num_row_ = problem.q.size, problem.l.size
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = problem.q, problem.lb, problem.ub
    lp.row_lower_, lp.row_upper_ = problem.l, problem.u
    lp.a_matrix_.format_ = library.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = A.indptr, A.indices, A.data
    P = csc_matrix(diags_array(problem.p))
    hessian.dim_, hessian.format_ = problem.q.size, library.HessianFormat.kTriangular
    hessian.start_, hessian.index_, hessian.value_ = P.indptr, P.indices, P.data

    def solve(ask: Ask) -> Reply:
        solver = library.Highs()
        solver.silent()
        for name, value in ENGINES["highs"].options(ask).items():
            solver.setOptionValue(name, value)
        solver.passModel(model)
        solver.run()
        ended = {"model_status": solver.getModelStatus().name}
        result, info = solver.getSolution(), solver.getInfo()
        if not (result.value_valid and result.dual_valid):
            return _reply("highs", ended, None, None)
        y, z = -np.array(result.row_dual), -np.array(result.col_dual)
        point = Point(np.array(result.col_value), y, z, np.zeros(0))
        return _reply("highs", ended, point, max(0, int(info.qp_iteration_count)))

    return solve


def proxqp(problem: Problem) -> Solve:
    from proxsuite import proxqp as library

    equal, n = problem.equal, problem.q.size
    P, A = csc_matrix(diags_array(problem.p)), csc_matrix(problem.A[equal])
    C = csc_matrix(vstack((problem.A[~equal], eye_array(n))))
    low = np.concatenate((problem.l[~equal], problem.lb))
    high = np.concatenate((problem.u[~equal], problem.ub))

    def solve(ask: Ask) -> Reply:
        solver = library.sparse.QP(n, A.shape[0], C.shape[0])
        _set(solver.settings, ENGINES["proxqp"].options(ask))
        solver.init(P, problem.q, A, problem.u[equal], C, low, high)
        solver.solve()
        result = solver.results
        y = np.zeros(problem.l.size)
        y[equal], y[~equal] = result.y, result.z[:-n]
        point = Point(np.array(result.x), y, np.array(result.z[-n:]), np.zeros(0))
        return _reply("proxqp", result, point, int(result.info.iter))

    return solve


def qpalm(problem: Problem) -> Solve:
    import qpalm as library

    A, low, high = _boxed(problem)
    data = library.Data(problem.q.size, low.size)
    data.Q, data.q = triu(diags_array(problem.p), format="csc"), problem.q
    data.A, data.bmin, data.bmax = A, low, high

    def solve(ask: Ask) -> Reply:
        solver = library.Solver(data, _set(library.Settings(), ENGINES["qpalm"].options(ask)))
        solver.solve()
        point = _point(problem, solver.solution.x, solver.solution.y)
        return _reply("qpalm", solver, point, int(solver.info.iter))

    return solve


def ecos(problem: Problem) -> Solve:
    """The quadratic term becomes a cone: sum p x^2 <= 2 v, with v in its place in the objective."""
    import ecos as library

    form, n, some = conic(problem), problem.q.size, np.flatnonzero(problem.p)
    scaled = coo_matrix(
        (-2 * np.sqrt(problem.p[some]), (np.arange(some.size), some)), shape=(some.size, n)
    )
    v = coo_matrix(([-2.0, -2.0], ([0, 1], [0, 0])), shape=(2 + some.size, 1))
    quadratic = hstack((vstack((coo_matrix((2, n)), scaled)), v))
    column = coo_matrix((form.A.shape[0], 1))
    rows = csc_matrix(vstack((hstack((form.A, column)), quadratic)))
    ends = np.concatenate((form.b, [1.0, -1.0], np.zeros(some.size)))
    sizes = [*problem.cones.tolist(), 2 + some.size]
    dims, zeros = {"l": form.positive, "q": sizes, "e": 0}, form.zeros
    equations = (csc_matrix(rows[:zeros]), ends[:zeros]) if zeros else (None, None)
    G, h, cost = csc_matrix(rows[zeros:]), ends[zeros:], np.append(problem.q, 1.0)

    def solve(ask: Ask) -> Reply:
        result = library.solve(
            cost, G, h, dims, *equations, verbose=False, **ENGINES["ecos"].options(ask)
        )
        y = result["y"] if zeros else np.zeros(0)
        multipliers = np.concatenate((y, result["z"][: h.size - 2 - some.size]))
        point = form.back(result["x"][:-1], multipliers)
        return _reply("ecos", result, point, int(result["info"]["iter"]))

    return solve


def daqp(problem: Problem) -> Solve:
    """The matrices are dense."""
    import daqp as library

    n, P, A = problem.q.size, np.diag(problem.p), problem.A.toarray()
    high = np.concatenate((problem.ub, problem.u))
    low = np.concatenate((problem.lb, problem.l))
    sense = np.where(high == low, 5, 0).astype(np.int32)  # 5: an equation

    def solve(ask: Ask) -> Reply:
        options = ENGINES["daqp"].options(ask)
        result = library.solve(P, problem.q, A, high, low, sense, **options)
        x, _, _, info = result
        z, y = np.split(np.array(info["lam"]), (n,))
        point = Point(np.array(x), y, z, np.zeros(0))
        return _reply("daqp", result, point, info["iterations"])

    return solve


def through_cvxpy(engine: str, problem: Problem) -> Solve:
    """The problem stated in cvxpy, as a function that compiles and solves it."""
    import cvxpy as cp

    x, equal = cp.Variable(problem.q.size), problem.equal
    upper, lower = ~equal & np.isfinite(problem.u), ~equal & np.isfinite(problem.l)
    A, inside = problem.A, problem.C @ x + problem.d
    rows = [
        A[equal] @ x == problem.u[equal],
        A[upper] @ x <= problem.u[upper],
        A[lower] @ x >= problem.l[lower],
        x <= problem.ub,
        x >= problem.lb,
    ]
    firsts = (np.cumsum(problem.cones) - problem.cones).tolist()
    cones = [
        cp.SOC(inside[first], inside[first + 1 : first + size])
        for first, size in zip(firsts, problem.cones.tolist(), strict=True)
    ]
    P = cp.psd_wrap(csc_matrix(diags_array(problem.p)))
    stated = cp.Problem(cp.Minimize(cp.quad_form(x, P) / 2 + problem.q @ x), [*rows, *cones])
    back = conic(problem).back  # its rows are those of cvxpy's

    def solve(ask: Ask) -> Reply:
        """As `stated.solve`, which does not tell the engine's own status."""
        options = ENGINES[engine].options(ask)
        data, chain, inverse = stated.get_problem_data(engine.upper(), solver_opts=options)
        try:
            result = chain.solve_via_data(stated, data, solver_opts=options)
        except cp.error.SolverError as error:
            return Reply(None, Claim.FAILED, str(error))
        try:
            stated.unpack_results(result, chain, inverse)
        except cp.error.SolverError:
            return _reply(engine, result, None, None)
        if x.value is None or any(row.dual_value is None for row in (*rows, *cones)):
            return _reply(engine, result, None, None)
        duals = [row.dual_value for row in rows]
        duals += [part for cone in cones for part in cone.dual_value]
        point = back(x.value, np.concatenate([np.ravel(part) for part in duals]))
        return _reply(engine, result, point, stated.solver_stats.num_iters)

    return solve


# by their own interfaces
NATIVE: dict[str, Callable[[Problem], Solve]] = {
    **{"piqp": piqp, "clarabel": clarabel, "osqp": osqp, "scs": scs, "highs": highs},
    **{"proxqp": proxqp, "qpalm": qpalm, "ecos": ecos, "daqp": daqp},
}


def prepare(engine: str, interface: str, problem: Problem) -> Solve:
    """The problem in an interface's form, as a function that solves it."""
    if problem.cones.size and not ENGINES[engine].cones:
        raise ProblemError(f"{ENGINES[engine].label} takes no cones; expected a QP")
    return through_cvxpy(engine, problem) if interface == "cvxpy" else NATIVE[engine](problem)
