"""Gurobi, by its Python interface, with the licence that it finds or the one in its wheel."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.answers import claim_of
from dubins_study.solvers.minlp_engines.program import (
    MinlpCall,
    MixedProgram,
    ProvenResult,
    Settings,
)
from dubins_study.study.words import Claim

# the smallest of FeasibilityTol, IntFeasTol and OptimalityTol that Gurobi takes
LEAST_TOLERANCE = 1e-9


def gurobi(settings: Settings) -> MinlpCall:
    """Gurobi with MIPGap and FeasibilityTol; `lean` changes nothing."""

    def run(program: MixedProgram, seconds: float) -> ProvenResult:
        import gurobipy

        try:
            with gurobipy.Model(env=_environment()) as model:
                return _run(model, program, settings, seconds)
        except gurobipy.GurobiError as error:  # a licence too small or expired among others
            message = f"Gurobi error {error.errno}: {error}"
            return ProvenResult(
                None, Claim.FAILED, -math.inf, None, None, str(error.errno), message
            )

    return run


def _run(model: Any, program: MixedProgram, settings: Settings, seconds: float) -> ProvenResult:
    import gurobipy
    from gurobipy import nlfunc

    kinds = np.where(program.binary, gurobipy.GRB.BINARY, gurobipy.GRB.CONTINUOUS)
    x = model.addMVar(program.lower.size, program.lower, program.upper, vtype=kinds).tolist()
    written = program.write(x, nlfunc)
    model.setObjective(written.objective)
    for row in written.rows:
        if isinstance(row.body, gurobipy.NLExpr):  # taken only as the value of a variable
            model.addConstr(model.addVar(row.lower, row.upper) == row.body)
        else:
            for relation in row.relations():
                model.addConstr(relation)
    model.Params.Threads = 1
    model.Params.MIPGap = settings.gap
    model.Params.MIPGapAbs = 0.0
    model.Params.FeasibilityTol = max(settings.feastol, LEAST_TOLERANCE)
    model.Params.TimeLimit = max(seconds, 0.0)
    model.optimize()
    if model.Status == gurobipy.GRB.INTERRUPTED:
        raise KeyboardInterrupt
    point = np.array([variable.X for variable in x]) if model.SolCount else None
    status = _status_names()[model.Status]
    unnamed = Claim.FAILED if point is None else Claim.FEASIBLE
    claim = claim_of("gurobi", status, unnamed)
    return ProvenResult(
        point,
        claim,
        math.inf if claim is Claim.INFEASIBLE else float(model.ObjBound),
        int(model.NodeCount),
        int(model.IterCount),
        status,
        status,
    )


@cache
def _status_names() -> dict[int, str]:
    """Names of Gurobi's status codes, in small letters, by code."""
    import gurobipy

    codes = gurobipy.GRB.Status
    names = [name for name in dir(codes) if name.isupper()]
    return {getattr(codes, name): name.lower().replace("_", " ") for name in names}


@cache
def _environment() -> Any:
    """One silent environment for the process: starting it reads the licence."""
    import gurobipy

    return gurobipy.Env(params={"OutputFlag": 0, "LogToConsole": 0})
