"""FICO Xpress, by its Python interface, with the licence that it finds or the one in its wheel."""

from __future__ import annotations

import math
import warnings
from functools import cache
from importlib import import_module
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


def xpress(settings: Settings) -> MinlpCall:
    """Xpress' global solver with MIPRELSTOP and FEASTOL; `lean` changes nothing."""

    def run(program: MixedProgram, seconds: float) -> ProvenResult:
        library = _library()
        try:
            _start()
            return _run(library, program, settings, seconds)
        except (library.SolverError, library.ModelError, library.InterfaceError) as error:
            # a licence too small or expired among others
            status = type(error).__name__
            return ProvenResult(None, Claim.FAILED, -math.inf, None, None, status, str(error))

    return run


def _run(library: Any, program: MixedProgram, settings: Settings, seconds: float) -> ProvenResult:
    problem = library.problem()
    problem.controls.outputlog = 0
    x = [
        problem.addVariable(
            lb=lower, ub=upper, vartype=library.binary if binary else library.continuous
        )
        for lower, upper, binary in program.variables
    ]
    written = program.write(x, library)
    problem.setObjective(written.objective)
    problem.addConstraint([relation for row in written.rows for relation in row.relations()])
    controls = {
        "threads": 1,
        "miprelstop": settings.gap,
        "mipabsstop": 0.0,
        # by default no node is looked at that may gain less than 1e-5, or 1e-4 of the objective:
        # then bounds stay that far below, whatever gap is asked for
        "mipaddcutoff": 0.0,
        "miprelcutoff": 0.0,
        "feastol": settings.feastol,
        "timelimit": max(seconds, 1e-3),  # 0 stands for no limit
    }
    problem.setControl(controls)
    solve_status, solution_status = problem.optimize()
    return _result(problem, solve_status.name, solution_status.name)


def _result(problem: Any, solve_status: str, solution_status: str) -> ProvenResult:
    claim = claim_of("xpress", solution_status)
    if solve_status == "STOPPED":
        if problem.attributes.stopstatus == _CTRL_C:
            raise KeyboardInterrupt
        claim = Claim.LIMIT
    elif solve_status != "COMPLETED" and claim is not Claim.FEASIBLE:
        claim = Claim.FAILED
    point = None
    if solution_status in ("OPTIMAL", "FEASIBLE"):
        point = np.array(problem.getSolution(), dtype=np.float64)
    bound = float(problem.attributes.bestbound)
    infeasible = claim is Claim.INFEASIBLE
    return ProvenResult(
        point,
        claim,
        math.inf if infeasible else -math.inf if abs(bound) >= 1e20 else bound,
        int(problem.attributes.nodes),
        int(problem.attributes.simplexiter),
        f"{solve_status} {solution_status}",
        f"{solve_status} {solution_status}".lower(),
    )


_CTRL_C = 2  # XPRS_STOP_CTRLC


@cache
def _library() -> Any:
    """The module. Where Pyomo is loaded, it then asks Xpress for its version in an outdated way."""
    # recorded, since Xpress changes the filters of warnings while it is imported
    with warnings.catch_warnings(record=True):
        return import_module("xpress")


@cache
def _start() -> None:
    """Read the licence, once a process and without the warning that it is the one in the wheel."""
    library = _library()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", library.LicenseWarning)
        library.init()
