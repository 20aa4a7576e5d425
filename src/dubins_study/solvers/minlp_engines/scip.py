"""SCIP, spatial branch and bound, by its Python interface."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from threading import Lock, current_thread, main_thread
from typing import Any

import numpy as np

from dubins_study.solvers.minlp_engines.mixed_program import (
    MinlpCall,
    MixedProgram,
    ProvenResult,
    Settings,
)
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.words import Claim

_redirection = Lock()  # else each of two threads would save the descriptor that the other has set


@contextmanager
def _silent_errors() -> Iterator[None]:
    """Silence the descriptor 2 inside the `with` block.

    This concerns all threads.
    """
    with _redirection, ExitStack() as restored:
        with suppress(OSError):  # it may be closed
            saved = os.dup(2)
            restored.callback(os.close, saved)
            restored.callback(os.dup2, saved, 2)
            with Path(os.devnull).open("wb") as nowhere:
                os.dup2(nowhere.fileno(), 2)
        yield


# the message of every error of SCIP begins like this; these errors have no type of their own
BROKEN = "SCIP:"

# beside heuristics and cuts: without presolving and propagation
_LEAN = dict.fromkeys(
    ("presolving/maxrounds", "propagating/maxrounds", "propagating/maxroundsroot"), 0
)


def scip(settings: Settings) -> MinlpCall:
    """A call of SCIP with the given settings.

    The settings become numerics/feastol and limits/gap; `lean` leaves bare branch and bound. An
    error of SCIP's own is a result. Ctrl-C, which SCIP catches, is raised again.
    """

    def run(program: MixedProgram, seconds: float) -> ProvenResult:
        from pyscipopt.scip import PY_SCIP_PARAMSETTING as SCIP_PARAMSETTING

        model, x = translated(program)
        if settings.lean:
            model.setHeuristics(SCIP_PARAMSETTING.OFF)
            model.setSeparating(SCIP_PARAMSETTING.OFF)
            model.setParams(_LEAN)
        parameters = {
            "numerics/feastol": settings.feastol,
            "limits/gap": settings.gap,
            "limits/time": max(seconds, 0.0),
            "randomization/randomseedshift": settings.seed,
            # in the main thread Ctrl-C must end SCIP, since Python sees it only afterwards
            "misc/catchctrlc": current_thread() is main_thread(),
        }
        model.setParams(parameters)
        model.hideOutput()
        try:
            # In about a third of all questions SoPlex, SCIP's own linear solver, writes to the
            # descriptor 2 that it takes no tolerance below 1e-10, up to thousands of times; no
            # parameter of SCIP's turns that off. SCIP holds the interpreter's lock, so no thread
            # writes at that time in Python.
            with _silent_errors():
                model.optimize()
        except Exception as error:
            if not str(error).startswith(BROKEN):
                raise
            return ProvenResult(
                None,
                Claim.FAILED,
                bound=-math.inf,
                nodes=0,
                iterations=None,
                status=str(error),
                message=str(error),
            )
        return _result(model, x)

    return run


def _result(model: Any, x: list[Any]) -> ProvenResult:
    """The result of a model that SCIP has optimised."""
    status = str(model.getStatus())
    if status == "userinterrupt":
        raise KeyboardInterrupt
    point = None
    unnamed = Claim.FAILED  # the claim of a status that is not listed
    if model.getNSols():
        best = model.getBestSol()
        point = np.array([model.getSolVal(best, variable) for variable in x])
        unnamed = Claim.FEASIBLE
    claim = claim_of("scip", status, unnamed)
    bound = float(model.getDualbound())
    if abs(bound) >= model.infinity():
        # SCIP's infinity is a finite number
        bound = math.copysign(math.inf, bound)
    return ProvenResult(
        point,
        claim,
        bound,
        nodes=int(model.getNNodes()),
        iterations=int(model.getNLPIterations()),
        status=status,
        message=f"status {status}",
    )


def translated(program: MixedProgram) -> tuple[Any, list[Any]]:
    """The program as a `pyscipopt.Model`, and its variables."""
    import pyscipopt

    model = pyscipopt.Model()
    x = []
    for lower, upper, binary in program.variables:
        low = None
        if math.isfinite(lower):
            low = lower
        high = None
        if math.isfinite(upper):
            high = upper
        kind = "C"
        if binary:
            kind = "B"
        x.append(model.addVar(lb=low, ub=high, vtype=kind))
    written = program.write(x, pyscipopt)
    for row in written.rows:
        for relation in row.relations():
            model.addCons(relation)
    # SCIP takes linear objectives only; one variable above the objective serves for all
    objective = model.addVar(lb=None, obj=1.0)
    model.addCons(objective >= written.objective)
    return model, x
