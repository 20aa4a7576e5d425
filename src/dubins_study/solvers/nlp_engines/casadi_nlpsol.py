"""The engines in casadi's wheel, called through its `nlpsol`."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from functools import lru_cache, partial
from io import StringIO
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.nlp_engines.program import Expressions, NlpCall, Program, needs_watch
from dubins_study.solvers.runs import EngineResult, no_point
from dubins_study.solvers.setting_checks import OptionValues, nested
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import Claim


class _Plugin(NamedTuple):
    """The behaviour of a plug-in of `nlpsol`."""

    watched: bool = False  # calls casadi's `iteration_callback`, and so can be stopped
    raises: bool = False  # a failure is a RuntimeError
    by_arrays: bool = False  # called by `_by_arrays`, which handles no exceptions
    remembers: bool = False  # an answer depends on what the same object solved before


_PLUGINS = {
    "ipopt": _Plugin(watched=True, by_arrays=True),
    "uno": _Plugin(watched=True),
    "fatrop": _Plugin(),
    "alpaqa": _Plugin(),
    # without integers a branch and bound of one node: its Ipopt, and a presolve around it
    "bonmin": _Plugin(),
    "sleqp": _Plugin(),
    # both raise where a quadratic program has no solution
    # qpOASES starts where it ended last
    "sqpmethod": _Plugin(watched=True, raises=True, remembers=True),
    "qrsqp": _Plugin(watched=True, raises=True),
}


# Options of every engine of casadi. Scalar expressions evaluate faster than matrix ones. casadi
# would warn of every NaN that Ipopt tries on a word without a path. The sensitivities to the
# parameters are not used.
_PLAIN = {"print_time": False, "expand": True, "show_eval_warnings": False, "calc_lam_p": False}


def _watch(variables: int, rows: int) -> Any:
    """A callback that casadi runs after every iteration.

    The callback stops a run at its time `at`, which the caller sets before each run. A call costs
    some 0.01 ms. Ipopt's own time limits are fixed once the solver is compiled.
    """
    import casadi

    sizes = {"x": variables, "lam_x": variables, "g": rows, "lam_g": rows, "f": 1}

    class Watch(casadi.Callback):
        """A callback that decides whether a run stops."""

        at = math.inf  # s, on `perf_counter`

        def __init__(self) -> None:
            casadi.Callback.__init__(self)
            self.construct("watch", {})

        def get_n_in(self) -> int:
            return int(casadi.nlpsol_n_out())

        def get_n_out(self) -> int:
            return 1

        def get_name_in(self, i: int) -> str:
            return str(casadi.nlpsol_out(i))

        def get_sparsity_in(self, i: int) -> Any:
            return casadi.Sparsity.dense(sizes.get(casadi.nlpsol_out(i), 0), 1)

        def has_eval_buffer(self) -> bool:
            return True

        def eval_buffer(self, _: Any, results: Any) -> int:
            """Write 1 into `results[0]` to stop, else 0.

            `eval` would convert every argument to a matrix first.
            """
            np.frombuffer(results[0])[0] = perf_counter() > self.at
            return 0

    return Watch()


@lru_cache(maxsize=256)
def _compiled(
    expressions: Expressions, plugin: str, chosen: tuple[tuple[str, Any], ...], watched: bool
) -> tuple[Callable[[], Any], Any]:
    """A function that returns a solver, and its watch.

    The solver is a `_Call`. If the plug-in remembers earlier runs, each call of the function makes
    a new solver. The watch is None unless `watched`. The caller must hold the watch during a run,
    since casadi does not.
    """
    import casadi

    problem = {name: getattr(expressions, name) for name in ("x", "p", "f", "g")}
    options = _PLAIN | nested(dict(chosen))
    n = expressions.x.numel()
    m = expressions.g.numel()
    if plugin == "fatrop" and expressions.stages is not None:
        sizes = expressions.stages._asdict().items()
        options |= {name: list(size) for name, size in sizes} | {"equality": [True] * m}
        options |= {"structure_detection": "manual", "N": len(expressions.stages.nx) - 1}
    watch = None
    if watched:
        options["iteration_callback"] = watch = _watch(n, m)
    solver = casadi.nlpsol("engine", plugin, problem, options)
    if not _PLUGINS[plugin].remembers:
        call = _plain(solver)
        if _PLUGINS[plugin].by_arrays:
            call = _by_arrays(solver)
        return lambda: call, watch
    # the derivatives, which take ten times as long to make as all else, are kept
    derivatives = {
        "jac_fg": solver.get_function("nlp_jac_fg"),
        "hess_lag": solver.get_function("nlp_hess_l"),
    }
    again = partial(casadi.nlpsol, "engine", plugin, solver.oracle(), options | derivatives)
    return lambda: _plain(again()), watch


# takes x0, p, lbx, ubx, lbg and ubg; returns the point, the duals of g and casadi's statistics
_Call = Callable[..., tuple[FloatArray, FloatArray, dict[str, Any]]]


def _plain(solver: Any) -> _Call:
    """A function that calls casadi's solver as usual."""

    def run(*values: Any) -> tuple[FloatArray, FloatArray, dict[str, Any]]:
        end = solver(**dict(zip(("x0", "p", "lbx", "ubx", "lbg", "ubg"), values, strict=True)))
        return end["x"].full().ravel(), end["lam_g"].full().ravel(), solver.stats()

    return run


def _by_arrays(solver: Any) -> _Call:
    """A function that calls casadi's solver on fixed arrays.

    casadi reads its inputs from these arrays and writes its results into them. A usual call takes
    0.2 ms to convert arrays, as long as an iteration of Ipopt.
    """
    buffer, evaluate = solver.buffer()
    inputs = [np.zeros(solver.numel_in(i)) for i in range(solver.n_in())]
    for i, array in enumerate(inputs):
        buffer.set_arg(i, memoryview(array.data))
    x = np.zeros(solver.numel_out("x"))
    duals = np.zeros(solver.numel_out("lam_g"))
    for array, name in ((x, "x"), (duals, "lam_g")):
        buffer.set_res(solver.index_out(name), memoryview(array.data))

    before: dict[str, Any] = {}  # calls in all runs so far: casadi counts them over all runs

    def run(*values: Any) -> tuple[FloatArray, FloatArray, dict[str, Any]]:
        # the last inputs, guesses of the duals, have no values and stay 0
        for array, value in zip(inputs, values, strict=False):
            array[:] = value
        evaluate()
        stats = buffer.stats()
        counts = {name: stats[name] for name in ("n_call_nlp_f", "n_call_nlp_g")}
        calls = {name: count - before.get(name, 0) for name, count in counts.items()}
        before.update(counts)
        return x.copy(), duals.copy(), stats | calls

    return run


def nlpsol(options: OptionValues, plugin: str) -> NlpCall:
    """A call of a plug-in of `nlpsol`."""
    chosen = tuple(options.items())
    max_iter = next((value for name, value in chosen if name.endswith("max_iter")), None)

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        with ExitStack() as streams:
            if plugin != "ipopt":  # its options silence it; the others print to Python's output
                streams.enter_context(redirect_stdout(StringIO()))
                streams.enter_context(redirect_stderr(StringIO()))
            watched = _PLUGINS[plugin].watched and needs_watch(max_iter, guess.size)
            new_solver, watch = _compiled(program.expressions, plugin, chosen, watched)
            solve = new_solver()
            if watch is not None:
                watch.at = perf_counter() + seconds
            low, high = program.bounds or (0, 0)  # of the equations
            try:
                x, duals, stats = solve(guess, program.p, program.lower, program.upper, low, high)
            except RuntimeError as error:
                if not _PLUGINS[plugin].raises:
                    raise
                reason = str(error).splitlines()[-1]
                return no_point(guess.size, Claim.FAILED, "raised", reason)
        return _result(plugin, x, duals, stats)

    return run


def claim(plugin: str, stats: dict[str, Any]) -> Claim:
    """The claim that a run's statistics make.

    If the plug-in's status is not listed, the claim is that of casadi's own status.
    """
    unnamed = claim_of("casadi", str(stats["unified_return_status"]))
    return claim_of(plugin, str(stats.get("return_status")), unnamed)


def _result(plugin: str, x: FloatArray, duals: FloatArray, stats: dict[str, Any]) -> EngineResult:
    status = str(stats.get("return_status", stats["unified_return_status"]))
    iterations = stats.get("iter_count")
    # evaluations of objective or equations, whichever are more; alpaqa's psi evaluates both
    of_both = stats.get("n_call_nlp_fg", 0) + stats.get("n_call_nlp_psi", 0)
    of_one = max(stats.get("n_call_nlp_f", 0), stats.get("n_call_nlp_g", 0))
    if iterations is not None:
        iterations = int(iterations)
    finite_duals = None  # Bonmin returns none
    if np.isfinite(duals).all():
        finite_duals = duals
    return EngineResult(
        x,
        claim(plugin, stats),
        finite_duals,
        iterations=iterations,
        evaluations=int(of_both + of_one),
        status=status,
        message=status.replace("_", " ").lower(),
    )
