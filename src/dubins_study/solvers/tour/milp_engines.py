"""Engines of mixed-integer linear programs, each by its own interface: HiGHS, SCIP and CBC.

HiGHS is the package's own. OR-tools' modelling layer would reach it too, but its copy is of another
version under the same name, so that a process that has loaded one of them cannot load the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.minlp_engines.mixed_program import (
    MixedProgram,
    ProvenResult,
    Row,
    Written,
)
from dubins_study.solvers.statuses import claim_of
from dubins_study.solvers.tour.linear_program import LinearProgram
from dubins_study.study.arrays import FloatArray

FEASIBILITY = 1e-9  # of rows and whole numbers, where the engine takes it


class Asked(NamedTuple):
    """What every engine is asked for, beside one thread."""

    seconds: float
    gap: float
    seed: int


def highs(program: LinearProgram, asked: Asked) -> ProvenResult:
    """HiGHS, by highspy."""
    import highspy

    solver = highspy.Highs()
    options = {
        "output_flag": False,
        "threads": 1,
        "random_seed": asked.seed,
        "time_limit": asked.seconds,
        "mip_rel_gap": asked.gap,
        "mip_feasibility_tolerance": FEASIBILITY,
        "primal_feasibility_tolerance": FEASIBILITY,
    }
    for name, value in options.items():
        solver.setOptionValue(name, value)
    kind = highspy.HighsVarType
    model = highspy.HighsLp()
    model.num_col_ = program.cost.size
    model.num_row_ = program.least.size
    model.col_cost_ = program.cost
    model.col_lower_ = program.low
    model.col_upper_ = program.high
    model.row_lower_ = program.least
    model.row_upper_ = program.most
    model.integrality_ = [kind.kInteger if one else kind.kContinuous for one in program.whole]
    matrix = model.a_matrix_
    matrix.format_ = highspy.MatrixFormat.kRowwise
    matrix.start_ = program.rows.indptr
    matrix.index_ = program.rows.indices
    matrix.value_ = program.rows.data
    solver.passModel(model)
    solver.run()
    info = solver.getInfo()
    status = solver.getModelStatus().name
    found = info.primal_solution_status == highspy.SolutionStatus.kSolutionStatusFeasible
    return ProvenResult(
        np.array(solver.getSolution().col_value) if found else None,
        claim_of("highs", status),
        bound=float(info.mip_dual_bound),
        nodes=max(int(info.mip_node_count), 0),
        iterations=max(int(info.simplex_iteration_count), 0),
        status=status,
        message="",
    )


def scip(program: LinearProgram, asked: Asked) -> ProvenResult:
    """SCIP, by pyscipopt."""
    from dubins_study.solvers.minlp_engines.scip import optimized, translated

    model, z = translated(mixed(program))
    model.setParams(
        {
            "limits/time": max(asked.seconds, 0.0),
            "limits/gap": asked.gap,
            "numerics/feastol": FEASIBILITY,
            "randomization/randomseedshift": asked.seed,
        }
    )
    return optimized(model, z)


def cbc(program: LinearProgram, asked: Asked) -> ProvenResult:
    """CBC, by OR-tools' linear solver, which says nothing of seeds; CBC takes none by itself."""
    from ortools.linear_solver import pywraplp

    solver = pywraplp.Solver.CreateSolver("CBC")
    z = [
        solver.IntVar(low, high, "") if whole else solver.NumVar(low, high, "")
        for low, high, whole in zip(program.low, program.high, program.whole, strict=True)
    ]
    for body, least, most in _rows(program):
        row = solver.Constraint(least, most)
        for i, value in body:
            row.SetCoefficient(z[i], value)
    objective = solver.Objective()
    for variable, cost in zip(z, program.cost.tolist(), strict=True):
        objective.SetCoefficient(variable, cost)
    objective.SetMinimization()
    parameters = pywraplp.MPSolverParameters()
    parameters.SetDoubleParam(parameters.RELATIVE_MIP_GAP, asked.gap)
    solver.SetTimeLimit(max(int(1000 * asked.seconds), 1))
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
        message="",
    )


# `operations_research::MPSolver::ResultStatus`
_CBC_STATUSES = (
    *("OPTIMAL", "FEASIBLE", "INFEASIBLE", "UNBOUNDED", "ABNORMAL", "MODEL_INVALID", "NOT_SOLVED"),
)


def _rows(program: LinearProgram) -> Iterator[tuple[list[tuple[int, float]], float, float]]:
    """The columns and values of each row, and between what its sum lies."""
    begins = program.rows.indptr
    entries = list(zip(program.rows.indices.tolist(), program.rows.data.tolist(), strict=True))
    bounds = zip(program.least.tolist(), program.most.tolist(), strict=True)
    for begin, end, (least, most) in zip(begins, begins[1:], bounds, strict=False):
        yield entries[begin:end], least, most


def mixed(program: LinearProgram) -> MixedProgram:
    """The same program for the engines of `minlp_engines`."""

    def write(x: Any, functions: Any) -> Written:
        rows = [
            Row(_sum([value * x[i] for i, value in body]), least, most)
            for body, least, most in _rows(program)
        ]
        return Written(_sum([cost * x[i] for i, cost in enumerate(program.cost.tolist())]), rows)

    return MixedProgram(program.low, program.high, program.whole, write)


def _sum(terms: list[Any]) -> Any:
    """The sum by halves: term by term some interfaces copy all that went before."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return _sum(terms[:half]) + _sum(terms[half:])


ENGINE_CALLS: dict[str, Callable[[LinearProgram, Asked], ProvenResult]] = {
    "highs": highs,
    "scip": scip,
    "cbc": cbc,
}
