"""SCIP on the disjunctive model: Pyomo's `scip_direct` translates it, SCIP's Python solves it.

`scip_direct` itself would capture what SCIP prints in a pipe of this process, and wait for ever
where that is more than the pipe holds; here SCIP prints nothing.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import lru_cache
from pathlib import Path as FilePath
from threading import Lock, current_thread, main_thread
from typing import Any, NamedTuple

import numpy as np

from dubins_study.study.path import FloatArray

# what the message of every error of SCIP's own begins with: they have no type of their own
BROKEN = "SCIP:"


class ScipSettings(NamedTuple):
    """Relative gap to stop at, tolerance on constraints, bare branch and bound or not, seconds."""

    gap: float
    feastol: float
    lean: bool
    limit: float


class Native(NamedTuple):
    """The result of one SCIP run, in radii.

    `word` and z (left, right, straight) are None without a point. `status` is SCIP's own, or the
    message of the error that it ended with; `feastol` is the tolerance of the run.
    """

    status: str
    bound: float
    word: str | None
    z: FloatArray | None
    nodes: int
    feastol: float


def run_scip(program: Any, words: tuple[str, ...], settings: ScipSettings) -> Native:
    """Minimise the transformed model `program` of the disjuncts `words`.

    An error of SCIP itself is a result whose status begins with `BROKEN`.

    Raises:
        KeyboardInterrupt: if Ctrl-C has ended SCIP, which catches it.
    """
    scip, solutions = _translated(program)
    options = dict(_lean() if settings.lean else ())
    options |= {"numerics/feastol": settings.feastol, "limits/gap": settings.gap}
    options |= {"limits/time": max(settings.limit, 0.0)}
    # in the main thread Ctrl-C must end SCIP, since Python sees it only afterwards
    options |= {"misc/catchctrlc": current_thread() is main_thread()}
    for name, setting in options.items():
        scip.setParam(name, setting)
    scip.hideOutput()
    try:
        with _no_warnings():
            scip.optimize()
    except Exception as error:
        if not str(error).startswith(BROKEN):
            raise
        return Native(str(error), 0.0, None, None, 0, settings.feastol)
    status = scip.getStatus()
    if status == "userinterrupt":
        raise KeyboardInterrupt
    word = z = None
    if solutions.get_number_of_solutions():
        lengths = list(program.z.values())
        chosen = [program.word[w].binary_indicator_var for w in words]
        values = solutions.get_vars([*lengths, *chosen])
        word = max(zip(words, chosen, strict=True), key=lambda pair: values[pair[1]])[0]
        z = np.array([values[length] for length in lengths])
    bound = float(scip.getDualbound())
    bound = math.copysign(math.inf, bound) if abs(bound) >= scip.infinity() else bound
    return Native(status, bound, word, z, int(scip.getNNodes()), settings.feastol)


@contextmanager
def _no_warnings() -> Iterator[None]:
    """Send the descriptor 2 to nowhere inside the `with` block.

    In about a third of all questions SoPlex, SCIP's own linear solver, writes to that descriptor
    that it takes no tolerance below 1e-10, up to thousands of times; no parameter of SCIP's turns
    that off. SCIP holds the interpreter's lock, so no thread writes at that time in Python.
    """
    with _descriptor, ExitStack() as restored:
        with suppress(OSError):  # it may be closed
            saved = os.dup(2)
            restored.callback(os.close, saved)
            restored.callback(os.dup2, saved, 2)
            with FilePath(os.devnull).open("wb") as nowhere:
                os.dup2(nowhere.fileno(), 2)
        yield


_descriptor = Lock()  # of two threads, each would save what the other has set


def _translated(program: Any) -> tuple[Any, Any]:
    """The model as a `pyscipopt.Model`, and Pyomo's way from its solutions back to variables.

    Pyomo offers the translation alone only as a private method of `scip_direct`; the versions of
    both packages are pinned.
    """
    from pyomo.common.timing import HierarchicalTimer
    from pyomo.contrib.solver.solvers.scip.scip_direct import ScipDirect

    interface = ScipDirect()
    config = interface.config(value={"timer": HierarchicalTimer()})
    scip, solutions, _ = interface._create_solver_model(program, config)
    return scip, solutions


@lru_cache(maxsize=1)
def _lean() -> tuple[tuple[str, Any], ...]:
    """SCIP's parameters for branch and bound without heuristics, cutting planes, presolving and
    propagation."""
    from pyscipopt import Model as Scip
    from pyscipopt.scip import PY_SCIP_PARAMSETTING as SCIP_PARAMSETTING

    scip = Scip()
    before = scip.getParams()
    scip.setHeuristics(SCIP_PARAMSETTING.OFF)
    scip.setSeparating(SCIP_PARAMSETTING.OFF)
    scip.setParam("presolving/maxrounds", 0)
    scip.setParam("propagating/maxrounds", 0)
    scip.setParam("propagating/maxroundsroot", 0)
    after = scip.getParams()
    return tuple((name, value) for name, value in after.items() if value != before[name])
