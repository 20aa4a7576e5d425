"""Engines of mixed-integer linear programs.

They are HiGHS, CBC and GLPK, and those of `minlp_engines`. HiGHS is that of the package highspy.
OR-tools' modelling layer would reach it too, but its copy is of another version under the same
name: a process that has loaded one of them cannot load the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from dubins_study.solvers.engines import EngineSolver
from dubins_study.solvers.highs import highs_rows, highs_run
from dubins_study.solvers.minlp_engines.mixed_program import (
    MixedProgram,
    ProvenResult,
    Row,
    Settings,
    Written,
)
from dubins_study.solvers.statuses import claim_of
from dubins_study.solvers.tour.linear_program import LinearProgram
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import Claim

FEASIBILITY = 1e-9  # of rows and whole numbers, where the engine takes it


def solved(
    solver: EngineSolver, program: LinearProgram, settings: Settings, seconds: float
) -> ProvenResult:
    """Run a solver's engine with one thread."""
    if call := _OWN_CALLS.get(solver.engine):
        return call(program, settings, seconds)
    result: ProvenResult = solver.library.load()(settings)(_mixed(program), seconds)
    return result


def _highs(program: LinearProgram, settings: Settings, seconds: float) -> ProvenResult:
    """Run HiGHS, by highspy."""
    import highspy

    options = {
        "threads": 1,
        "random_seed": settings.seed,
        "time_limit": seconds,
        "mip_rel_gap": settings.gap,
        "mip_feasibility_tolerance": settings.feastol,
        "primal_feasibility_tolerance": settings.feastol,
    }
    # the fields of `LinearProgram` are the parameters of `highs_rows`, in their order
    solver = highs_run(highs_rows(*program), options)
    info = solver.getInfo()
    status = solver.getModelStatus().name
    point = None
    if info.primal_solution_status == highspy.SolutionStatus.kSolutionStatusFeasible:
        point = np.array(solver.getSolution().col_value)
    return ProvenResult(
        point,
        claim_of("highs", status),
        bound=float(info.mip_dual_bound),
        nodes=max(int(info.mip_node_count), 0),
        iterations=max(int(info.simplex_iteration_count), 0),
        status=status,
    )


def _cbc(program: LinearProgram, settings: Settings, seconds: float) -> ProvenResult:
    """Run CBC, by OR-tools' linear solver.

    That interface passes on no seed; CBC takes none by itself.
    """
    from ortools.linear_solver import pywraplp

    solver = pywraplp.Solver.CreateSolver("CBC")
    z = []
    for low, high, whole in zip(program.low, program.high, program.whole, strict=True):
        new_variable = solver.NumVar
        if whole:
            new_variable = solver.IntVar
        z.append(new_variable(low, high, ""))
    for body, least, most in _rows(program):
        row = solver.Constraint(least, most)
        for i, value in body:
            row.SetCoefficient(z[i], value)
    objective = solver.Objective()
    for variable, cost in zip(z, program.cost.tolist(), strict=True):
        objective.SetCoefficient(variable, cost)
    objective.SetMinimization()
    parameters = pywraplp.MPSolverParameters()
    parameters.SetDoubleParam(parameters.RELATIVE_MIP_GAP, settings.gap)
    solver.SetTimeLimit(max(int(1000 * seconds), 1))
    status = _CBC_STATUSES[solver.Solve(parameters)]
    point: FloatArray | None = None
    if status in ("OPTIMAL", "FEASIBLE"):
        point = np.array([variable.solution_value() for variable in z])
    return ProvenResult(
        point,
        claim_of("cbc", status),
        bound=float(objective.BestBound()),
        nodes=max(int(solver.nodes()), 0),
        iterations=max(int(solver.iterations()), 0),
        status=status,
    )


# `operations_research::MPSolver::ResultStatus`
_CBC_STATUSES = (
    "OPTIMAL",
    "FEASIBLE",
    "INFEASIBLE",
    "UNBOUNDED",
    "ABNORMAL",
    "MODEL_INVALID",
    "NOT_SOLVED",
)


def _glpk(program: LinearProgram, settings: Settings, seconds: float) -> ProvenResult:
    """Run GLPK, by swiglpk.

    GLPK takes no seed. It reports bounds and nodes only while it runs, so the bound of an optimum
    is taken to be its cost less the gap. GLPK numbers rows and columns from 1.
    """
    import swiglpk as glpk

    glpk.glp_term_out(glpk.GLP_OFF)
    problem = glpk.glp_create_prob()
    columns = list(zip(program.cost, program.low, program.high, program.whole, strict=True))
    glpk.glp_add_cols(problem, len(columns))
    for j, (cost, low, high, whole) in enumerate(columns, start=1):
        glpk.glp_set_obj_coef(problem, j, float(cost))
        glpk.glp_set_col_bnds(problem, j, *_between(glpk, float(low), float(high)))
        if whole:
            glpk.glp_set_col_kind(problem, j, glpk.GLP_IV)
    glpk.glp_add_rows(problem, program.least.size)
    for i, (body, least, most) in enumerate(_rows(program), start=1):
        glpk.glp_set_row_bnds(problem, i, *_between(glpk, least, most))
        places = glpk.intArray(len(body) + 1)
        values = glpk.doubleArray(len(body) + 1)
        for k, (j, value) in enumerate(body, start=1):
            places[k] = j + 1
            values[k] = value
        glpk.glp_set_mat_row(problem, i, len(body), places, values)
    parameters = glpk.glp_iocp()
    glpk.glp_init_iocp(parameters)
    parameters.presolve = glpk.GLP_ON  # without it the relaxation must have been solved before
    parameters.tol_int = settings.feastol
    parameters.mip_gap = settings.gap
    parameters.tm_lim = min(max(int(1000 * seconds), 1), _MOST_MS)
    return_code = glpk.glp_intopt(problem, parameters)
    status = _GLPK_ENDS.get(return_code, str(return_code))
    if return_code == 0:
        status = _GLPK_STATUSES[glpk.glp_mip_status(problem)]
    point: FloatArray | None = None
    if glpk.glp_mip_status(problem) in (glpk.GLP_FEAS, glpk.GLP_OPT):
        point = np.array([glpk.glp_mip_col_val(problem, j + 1) for j in range(len(columns))])
    cost = float(glpk.glp_mip_obj_val(problem))
    glpk.glp_delete_prob(problem)
    claim = claim_of("glpk", status)
    bound = -math.inf
    if claim is Claim.OPTIMAL:
        bound = cost * (1.0 - settings.gap)
    return ProvenResult(
        point,
        claim,
        bound=bound,
        nodes=None,
        iterations=None,
        status=status,
    )


def _between(glpk: Any, low: float, high: float) -> tuple[int, float, float]:
    """Bounds as GLPK takes them.

    Returns three values for a row or column: the kind of its bounds, the lower and the upper bound.
    A bound that the kind does not have is 0.
    """
    if low == high:
        return glpk.GLP_FX, low, high
    if low == -math.inf:
        return glpk.GLP_UP, 0.0, high
    if high == math.inf:
        return glpk.GLP_LO, low, 0.0
    return glpk.GLP_DB, low, high


_MOST_MS = 2**31 - 1  # which GLPK takes for no limit
# `glpk.h`: what `glp_intopt` returns, and where that is 0, `glp_mip_status`
_GLPK_ENDS = {
    0x09: "GLP_ETMLIM",
    0x0A: "GLP_ENOPFS",
    0x0B: "GLP_ENODFS",
    0x0E: "GLP_EMIPGAP",
}
_GLPK_STATUSES = ("", "GLP_UNDEF", "GLP_FEAS", "", "GLP_NOFEAS", "GLP_OPT")


def _rows(program: LinearProgram) -> Iterator[tuple[list[tuple[int, float]], float, float]]:
    """The rows of a program, one by one.

    Yields three values: pairs of a column and its coefficient, the lower end, the upper end.
    """
    begins = program.rows.indptr
    entries = list(zip(program.rows.indices.tolist(), program.rows.data.tolist(), strict=True))
    bounds = zip(program.least.tolist(), program.most.tolist(), strict=True)
    for begin, end, (least, most) in zip(begins, begins[1:], bounds, strict=False):
        yield entries[begin:end], least, most


def _mixed(program: LinearProgram) -> MixedProgram:
    """The same program for the engines of `minlp_engines`."""

    def write(x: Any, functions: Any) -> Written:
        rows = [
            Row(_sum([value * x[i] for i, value in body]), least, most)
            for body, least, most in _rows(program)
        ]
        return Written(_sum([cost * x[i] for i, cost in enumerate(program.cost.tolist())]), rows)

    return MixedProgram(program.low, program.high, program.whole, write)


def _sum(terms: list[Any]) -> Any:
    """The sum of terms, added up by halves.

    Added up term by term, some interfaces would copy the sum so far each time.
    """
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return _sum(terms[:half]) + _sum(terms[half:])


_OWN_CALLS = {"highs": _highs, "cbc": _cbc, "glpk": _glpk}
