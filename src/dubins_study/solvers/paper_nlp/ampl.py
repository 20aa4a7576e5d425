"""Solvers run as AMPL runs them: `solver stub -AMPL` reads stub.nl and writes stub.sol.

The program gets a folder of its own, nothing on its input, and a time limit that ends it and
whatever it started. Nothing but the file that it leaves is read.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.gams import exit_code
from dubins_study.solvers.nlp_engines.program import EngineResult, no_point
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.solvers.paper_nlp.program import posed
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

_STUB = "model"

# AMPL's solve_result_num by the hundred (Fourer, Gay and Kernighan, AMPL, 2nd ed., sec. 14.2):
# solved, solved with a warning, infeasible, unbounded, limit, failure
_CLAIMS = (Claim.LOCAL, Claim.FEASIBLE, Claim.INFEASIBLE, Claim.FAILED, Claim.LIMIT, Claim.FAILED)


def solve(case: Case, guess: FloatArray, seconds: float, executable: str) -> EngineResult:
    """The point that an executable on PATH reaches from `guess`, shape (3,)."""
    from pyomo.common.errors import PyomoException
    from pyomo.contrib.solver.solvers.asl_sol_reader import parse_asl_sol_file
    from pyomo.repn.plugins.nl_writer import NLWriter

    model = posed(case, guess)
    with tempfile.TemporaryDirectory() as name:
        folder = FilePath(name)
        with (folder / f"{_STUB}.nl").open("w") as stream:
            info = NLWriter().write(model, stream, linear_presolve=False)
        code = _run(executable, folder, seconds)
        file = folder / f"{_STUB}.sol"
        if code is None:
            return no_point(3, Claim.LIMIT, "time limit", f"{executable} was stopped")
        status = f"exit code {code}"
        if not file.is_file():
            lacking = f"{executable} wrote no .sol file; expected a solver that AMPL can call"
            return no_point(3, Claim.FAILED, status, lacking)
        try:
            with file.open(errors="replace") as stream:
                solution = parse_asl_sol_file(stream)
        except (PyomoException, ValueError, LookupError, AssertionError) as error:
            message = f"{executable}'s .sol file: {type(error).__name__}: {error}"
            return no_point(3, Claim.FAILED, status, message)
    return _point(model, info, solution)


def _point(model: Any, info: Any, solution: Any) -> EngineResult:
    code, message = solution.solve_code, " ".join(solution.message.split())
    claim = _CLAIMS[code // 100] if 0 <= code < 600 else Claim.FAILED
    status = f"solve_result_num {code}"
    if len(solution.primals) != len(info.variables):
        if claim is not Claim.INFEASIBLE:  # which needs no point
            claim = Claim.FAILED
        return no_point(3, claim, status, message)
    values = {id(v): x for v, x in zip(info.variables, solution.primals, strict=True)}
    z = np.array([values.get(id(v), 0.0) for v in model.z.values()])
    duals = None
    if len(solution.duals) == len(info.constraints):
        of_row = {id(c): y for c, y in zip(info.constraints, solution.duals, strict=True)}
        # AMPL's dual is the objective's change per unit of right-hand side, the paper's minus that
        duals = -np.array([of_row[id(model.x_end)], of_row[id(model.y_end)]])
    return EngineResult(z, claim, duals, None, None, status, message)


def _run(executable: str, folder: FilePath, seconds: float) -> int | None:
    """The exit code of `executable model -AMPL`, or None if it did not end in time."""
    path = shutil.which(executable)
    if path is None:
        return 127  # as a shell says of a command that has gone
    return exit_code([FilePath(path).absolute(), _STUB, "-AMPL"], folder, seconds)
