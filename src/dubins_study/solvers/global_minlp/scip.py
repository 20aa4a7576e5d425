"""SCIP on the disjunctive model, through Pyomo's interface `scip_direct`."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from dubins_study.study.path import FloatArray

BROKEN = "error"  # the condition of a run that SCIP ended with an error
_STATUS = re.compile(r"^SCIP Status\s*:\s*(.*?)\s*$", re.MULTILINE)


class ScipSettings(NamedTuple):
    """Relative gap to stop at, tolerance on constraints, bare branch and bound or not, seconds."""

    gap: float
    feastol: float
    lean: bool
    limit: float


class Native(NamedTuple):
    """The result of one SCIP run, in radii.

    `word` and z (left, right, straight) are None without a point. `status` is SCIP's, `condition`
    is Pyomo's name of it, `feastol` is the tolerance of the run.
    """

    condition: str
    status: str
    bound: float
    word: str | None
    z: FloatArray | None
    nodes: int
    feastol: float


def run_scip(program: Any, words: tuple[str, ...], settings: ScipSettings) -> Native:
    """Minimise the transformed model `program` of the disjuncts `words`.

    An error of SCIP itself is a result with the condition `BROKEN`.
    """
    from pyomo.contrib.solver.common.factory import SolverFactory
    from pyomo.environ import value

    options = dict(_lean() if settings.lean else ())
    options |= {"numerics/feastol": settings.feastol, "limits/gap": settings.gap}
    try:
        results = SolverFactory("scip_direct").solve(
            program,
            time_limit=settings.limit,
            load_solutions=False,
            raise_exception_on_nonoptimal_result=False,
            solver_options=options,
        )
    except Exception as error:
        # SCIP's own errors (of its linear programs, mostly) have no type of their own
        if not str(error).startswith("SCIP:"):
            raise
        return Native(BROKEN, str(error), 0.0, None, None, 0, settings.feastol)
    word = z = None
    if results.incumbent_objective is not None:
        results.solution_loader.load_vars()
        chosen = {w: value(program.word[w].binary_indicator_var) for w in words}
        word = max(chosen, key=chosen.__getitem__)
        z = np.array([value(z) for z in program.z.values()])
    status = _STATUS.search(results.solver_log)
    return Native(
        results.termination_condition.name,
        status.group(1) if status else "",
        float(results.objective_bound),
        word,
        z,
        int(results.extra_info["NNodes"]),
        settings.feastol,
    )


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
