"""The engines that casadi's wheel carries, all through its `nlpsol`."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import Engine, EngineResult, Expressions, Program
from dubins_study.study.claim import Claim
from dubins_study.study.path import FloatArray

_CLAIMS = {"Solve_Succeeded": Claim.LOCAL, "Infeasible_Problem_Detected": Claim.INFEASIBLE}


@lru_cache(maxsize=256)
def _compiled(expressions: Expressions, plugin: str, options: tuple[tuple[str, Any], ...]) -> Any:
    import casadi

    problem = {name: getattr(expressions, name) for name in ("x", "p", "f", "g")}
    silent = {"print_time": False, "expand": True}
    return casadi.nlpsol("engine", plugin, problem, silent | {plugin: dict(options)})


def ipopt(tol: float, max_iter: int) -> Engine:
    """Ipopt, an interior-point method."""
    options = (("print_level", 0), ("sb", "yes"), ("tol", tol), ("max_iter", max_iter))

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        compiled = _compiled(program.expressions, "ipopt", options)
        end = compiled(x0=guess, p=program.p, lbx=program.lower, ubx=program.upper, lbg=0, ubg=0)
        stats = compiled.stats()
        status = str(stats["return_status"])
        return EngineResult(
            np.asarray(end["x"].full()).ravel(),
            _CLAIMS.get(status, Claim.FAILED),
            np.asarray(end["lam_g"].full()).ravel(),
            int(stats["iter_count"]),
            int(stats["n_call_nlp_g"]),
            status,
            status.replace("_", " ").lower(),
        )

    return run
