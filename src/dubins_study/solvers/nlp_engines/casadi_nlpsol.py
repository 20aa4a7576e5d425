"""The engines that casadi's wheel carries, all through its `nlpsol`."""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from functools import lru_cache, partial
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.nlp_engines.program import (
    EngineResult,
    Expressions,
    NlpCall,
    Program,
    needs_watch,
    no_point,
)
from dubins_study.solvers.nlp_engines.pyomo_ipopt import CLAIMS, PLAIN, Deadline
from dubins_study.solvers.option_sets import nested
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

# casadi's word of an engine's ending, where the engine's own is in no table
_UNIFIED = {"SOLVER_RET_SUCCESS": Claim.LOCAL, "SOLVER_RET_LIMITED": Claim.LIMIT}


class _Plugin(NamedTuple):
    """A plug-in of `nlpsol`: its claims, and how it behaves."""

    claims: dict[str, Claim]  # by the engine's status; other statuses have casadi's word
    watched: bool = False  # calls casadi's `iteration_callback`, and so can be stopped
    raises: bool = False  # where it fails
    remembers: bool = False  # an answer depends on what the same object solved before


_PLUGINS = {
    "ipopt": _Plugin(CLAIMS, watched=True),
    # its statuses say both how it stopped and what the point is
    "uno": _Plugin(
        {
            "Converged with feasible KKT point": Claim.LOCAL,
            "Converged with feasible FJ point": Claim.FEASIBLE,
            "Terminated with feasible small step": Claim.FEASIBLE,
            "Converged with infeasible stationary point": Claim.INFEASIBLE,
            "Terminated with infeasible small step": Claim.FAILED,
        },
        watched=True,
    ),
    "fatrop": _Plugin({"1": Claim.FAILED}),  # of every kind; 0 is a success
    "alpaqa": _Plugin({}),
    # without integers a branch and bound of one node: its Ipopt, and a presolve around it
    "bonmin": _Plugin({"INFEASIBLE": Claim.INFEASIBLE, "LIMIT_EXCEEDED": Claim.LIMIT}),
    # casadi calls every ending a success, the dead point (SLEQP_STATUS_ABORT_DEADPOINT) too
    "sleqp": _Plugin(
        {
            "optimal": Claim.LOCAL,
            "feasible": Claim.FEASIBLE,
            "infeasible": Claim.INFEASIBLE,
            "deadpoint": Claim.FAILED,
            "unbounded": Claim.FAILED,
            "iteration limit": Claim.LIMIT,
            "time limit": Claim.LIMIT,
        },
    ),
    # both raise where a quadratic program has no solution
    # qpOASES starts where it ended last
    "sqpmethod": _Plugin(CLAIMS, watched=True, raises=True, remembers=True),
    "qrsqp": _Plugin(CLAIMS, watched=True, raises=True),
}


class _Silence(io.TextIOBase):
    """What casadi prints, plug-ins included, goes through Python's own streams, here nowhere."""

    def write(self, text: str) -> int:
        return len(text)


@lru_cache(maxsize=256)
def _compiled(
    expressions: Expressions, plugin: str, chosen: tuple[tuple[str, Any], ...], watched: bool
) -> tuple[Callable[[], Any], Deadline | None]:
    """What gives the object that solves a program once, and what stops it, if anything does."""
    import casadi

    problem = {name: getattr(expressions, name) for name in ("x", "p", "f", "g")}
    options = PLAIN | nested(dict(chosen))
    n, m = expressions.x.numel(), expressions.g.numel()
    if plugin == "fatrop" and expressions.stages is not None:
        sizes = expressions.stages._asdict().items()
        options |= {name: list(size) for name, size in sizes} | {"equality": [True] * m}
        options |= {"structure_detection": "manual", "N": len(expressions.stages.nx) - 1}
    deadline = None
    if watched:
        deadline = Deadline()
        options["iteration_callback"] = deadline.watch(n, m)
    solver = casadi.nlpsol("engine", plugin, problem, options)
    if not _PLUGINS[plugin].remembers:
        return lambda: solver, deadline
    # the derivatives, which take ten times as long to make as all else, are kept
    derivatives = {
        "jac_fg": solver.get_function("nlp_jac_fg"),
        "hess_lag": solver.get_function("nlp_hess_l"),
    }
    again = partial(casadi.nlpsol, "engine", plugin, solver.oracle(), options | derivatives)
    return again, deadline


def nlpsol(options: dict[str, Any], plugin: str) -> NlpCall:
    """A plug-in of `nlpsol` by its name."""
    chosen = tuple(options.items())
    max_iter = next((value for name, value in chosen if name.endswith("max_iter")), None)

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        with ExitStack() as streams:
            if plugin != "ipopt":  # whose options silence it
                streams.enter_context(redirect_stdout(_Silence()))
                streams.enter_context(redirect_stderr(_Silence()))
            watched = _PLUGINS[plugin].watched and needs_watch(max_iter, guess.size)
            solver, deadline = _compiled(program.expressions, plugin, chosen, watched)
            solve = solver()
            if deadline is not None:
                deadline.at = perf_counter() + seconds
            bounds = {"lbx": program.lower, "ubx": program.upper, "lbg": 0, "ubg": 0}
            try:
                end = solve(x0=guess, p=program.p, **bounds)
            except RuntimeError as error:
                if not _PLUGINS[plugin].raises:
                    raise
                reason = str(error).splitlines()[-1]
                return no_point(guess.size, Claim.FAILED, "raised", reason)
        return _result(plugin, end, solve.stats())

    return run


def claim_of(plugin: str, stats: dict[str, Any]) -> Claim:
    """The claim in the statistics of a run."""
    claims, unified = _PLUGINS[plugin].claims, str(stats["unified_return_status"])
    return claims.get(str(stats.get("return_status"))) or _UNIFIED.get(unified, Claim.FAILED)


def _result(plugin: str, end: dict[str, Any], stats: dict[str, Any]) -> EngineResult:
    status = str(stats.get("return_status", stats["unified_return_status"]))
    duals = end["lam_g"].full().ravel()
    iterations = stats.get("iter_count")
    return EngineResult(
        end["x"].full().ravel(),
        claim_of(plugin, stats),
        duals if np.isfinite(duals).all() else None,  # Bonmin returns none
        None if iterations is None else int(iterations),
        _evaluations(stats),
        status,
        status.replace("_", " ").lower(),
    )


def _evaluations(stats: dict[str, Any]) -> int:
    """Evaluations of objective or equations, whichever are more; alpaqa's psi evaluates both."""
    of_both = stats.get("n_call_nlp_fg", 0) + stats.get("n_call_nlp_psi", 0)
    return int(of_both + max(stats.get("n_call_nlp_f", 0), stats.get("n_call_nlp_g", 0)))
