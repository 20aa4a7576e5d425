"""What engines' statuses claim; runs of engines, and the answer that several give together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from typing import Any, Generic, NamedTuple, TypeVar

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Effort
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import Claim

Point = TypeVar("Point")
Guess = TypeVar("Guess")

# By the names of engines: each claim, and the statuses that make it. The names `casadi`, `cvxpy`,
# `pyomo` and `ampl` are those of interfaces with statuses of their own.
#
# `optimal`, `local`: solved, to the tolerances that were asked for. `feasible`: a point, and no
# more. `infeasible`: no point exists, of a local engine: near its guess. `limit`: a limit ended the
# run, whatever the engine says of its point by then. What is not named is `failed`: also a problem
# that is solved, or proved infeasible, to less than was asked ("almost", "close to"), and one that
# is called unbounded or dual infeasible, as no problem here is.
STATUSES: dict[str, dict[str, tuple[str, ...]]] = {
    # scipy/optimize, slsqp: 99 is a stop by the callback; 4, an infeasible linearisation, is no
    # claim about the problem
    "slsqp": {"local": ("mode 0",), "limit": ("mode 9", "mode 99")},
    # scipy/_lib/cobyqa/settings.py: the least trust-region radius, a callback's stop, limits; -1
    # says that the bounds exclude each other, no more
    "cobyqa": {"local": ("status 0",), "limit": ("status 3", "status 5", "status 6")},
    # 3 is a stop by the callback; 4 a success that misses its constraints
    "trust-constr": {
        "local": ("status 1", "status 2"),
        "limit": ("status 0", "status 3"),
    },
    # casadi's word of an ending, where the engine's own is not named
    "casadi": {"local": ("SOLVER_RET_SUCCESS",), "limit": ("SOLVER_RET_LIMITED",)},
    "ipopt": {
        # the acceptable level is its makers' second accuracy, 1e-6: what arriving needs
        "local": ("Solve_Succeeded", "Solved_To_Acceptable_Level"),
        "feasible": ("Feasible_Point_Found",),
        "infeasible": ("Infeasible_Problem_Detected",),
        "limit": (
            *("Maximum_Iterations_Exceeded", "Maximum_CpuTime_Exceeded"),
            *("Maximum_WallTime_Exceeded", "User_Requested_Stop"),
        ),
    },
    # says both how it stopped and what the point is
    "uno": {
        "local": ("Converged with feasible KKT point",),
        "feasible": (
            "Converged with feasible FJ point",
            "Terminated with feasible small step",
        ),
        "infeasible": ("Converged with infeasible stationary point",),
    },
    "uno-filtersqp": {
        "local": ("FEASIBLE_KKT_POINT",),
        "feasible": ("FEASIBLE_FJ_POINT", "FEASIBLE_SMALL_STEP"),
        "infeasible": ("INFEASIBLE_STATIONARY_POINT",),
        "limit": ("ITERATION_LIMIT", "TIME_LIMIT"),
    },
    "fatrop": {"failed": ("1",)},  # of every kind; 0 is a success
    "alpaqa": {},
    "bonmin": {"infeasible": ("INFEASIBLE",), "limit": ("LIMIT_EXCEEDED",)},
    # casadi calls every ending a success, the dead point (SLEQP_STATUS_ABORT_DEADPOINT) too
    "sleqp": {
        "local": ("optimal",),
        "feasible": ("feasible",),
        "infeasible": ("infeasible",),
        "limit": ("iteration limit", "time limit"),
        "failed": ("deadpoint", "unbounded"),
    },
    # its last words
    "apopt": {
        "local": ("Successful solution",),
        "infeasible": ("No feasible solution",),
        "limit": ("Maximum iterations", "time limit"),
        "failed": ("Requested accuracy unachievable",),
    },
    # of all of NLopt's algorithms; its manual calls positive codes a success, which says that steps
    # have become small, on the equations or off them
    "nlopt": {
        "local": ("SUCCESS", "FTOL_REACHED", "XTOL_REACHED"),
        "limit": ("MAXEVAL_REACHED", "MAXTIME_REACHED"),
    },
    # termination conditions, pyomo.contrib.solver.common.results
    "pyomo": {
        "local": ("convergenceCriteriaSatisfied",),
        "infeasible": ("provenInfeasible", "locallyInfeasible", "infeasibleOrUnbounded"),
        "limit": ("maxTimeLimit", "iterationLimit"),
    },
    # solve_result_num by the hundred (Fourer, Gay and Kernighan, AMPL, 2nd ed., sec. 14.2):
    # solved, solved with a warning, infeasible, unbounded, limit, failure
    "ampl": {
        "local": ("0",),
        "feasible": ("1",),
        "infeasible": ("2",),
        "limit": ("4",),
    },
    "scip": {
        "optimal": ("optimal", "gaplimit"),
        "infeasible": ("infeasible", "inforunbd"),
        "limit": ("timelimit", "memlimit"),
    },
    "maingo": {
        "optimal": ("GLOBALLY_OPTIMAL", "BOUND_TARGETS"),
        "infeasible": ("INFEASIBLE",),
        "limit": ("FEASIBLE_POINT", "NO_FEASIBLE_POINT_FOUND"),
    },
    "cvxpy": {
        "optimal": ("optimal",),
        "infeasible": ("infeasible", "infeasible_or_unbounded"),
        "limit": ("user_limit",),
    },
    "piqp": {
        "optimal": ("PIQP_SOLVED",),
        "infeasible": ("PIQP_PRIMAL_INFEASIBLE",),
        "limit": ("PIQP_MAX_ITER_REACHED",),
    },
    "clarabel": {
        "optimal": ("Solved",),
        "infeasible": ("PrimalInfeasible",),
        "limit": ("MaxIterations", "MaxTime"),
    },
    # "inaccurate": a limit was reached, and ten times the tolerance is kept (its `status_values`)
    "osqp": {
        "optimal": ("solved",),
        "infeasible": ("primal infeasible",),
        "limit": (
            *("maximum iterations reached", "run time limit reached", "solved inaccurate"),
            *("primal infeasible inaccurate", "dual infeasible inaccurate"),
        ),
    },
    "scs": {
        "optimal": ("solved",),
        "infeasible": ("infeasible",),
        "limit": (
            "solved (inaccurate - reached max_iters)",
            "solved (inaccurate - reached time_limit_secs)",
            "infeasible (inaccurate - reached max_iters)",
            "infeasible (inaccurate - reached time_limit_secs)",
            "unbounded (inaccurate - reached max_iters)",
            "unbounded (inaccurate - reached time_limit_secs)",
        ),
    },
    "highs": {
        "optimal": ("kOptimal",),
        "infeasible": ("kInfeasible", "kUnboundedOrInfeasible"),
        "limit": ("kTimeLimit", "kIterationLimit", "kMemoryLimit"),
    },
    # of a problem that it calls infeasible it may give the point that is nearest to feasible
    "proxqp": {
        "optimal": ("PROXQP_SOLVED",),
        "infeasible": ("PROXQP_PRIMAL_INFEASIBLE", "PROXQP_SOLVED_CLOSEST_PRIMAL_FEASIBLE"),
        "limit": ("PROXQP_MAX_ITER_REACHED",),
    },
    "qpalm": {
        "optimal": ("solved",),
        "infeasible": ("primal infeasible",),
        "limit": ("maximum iterations reached", "time limit exceeded"),
    },
    "ecos": {
        "optimal": ("Optimal solution found",),
        "infeasible": ("Primal infeasible",),
        "limit": ("Maximum number of iterations reached",),
    },
    # -4 and -7 are limits of iterations and of time; 2 is an optimum with soft constraints, -6 a
    # first working set that depends on itself
    "daqp": {"optimal": ("1",), "infeasible": ("-1",), "limit": ("-4", "-7")},
}
# casadi's own methods end with Ipopt's words
STATUSES |= dict.fromkeys(("sqpmethod", "qrsqp"), STATUSES["ipopt"])


def claim_of(engine: str, status: str, unnamed: Claim = Claim.FAILED) -> Claim:
    """The claim of an engine's status, by the engine's name in `STATUSES`."""
    for claim, statuses in STATUSES[engine].items():
        if status in statuses:
            return Claim(claim)
    return unnamed


class Run(NamedTuple, Generic[Point]):
    """One run of an engine on a subproblem: what it says, what it cost, where its path leads."""

    subproblem: str
    seconds: float
    point: Point  # from which the formulation makes the path
    claim: Claim
    duals: FloatArray | None  # (2,) or more, of the end point in body coordinates
    iterations: int | None
    evaluations: int | None
    status: str
    message: str
    length: float = math.inf  # radii; infinite without a path
    miss: float = math.inf  # radii
    bound: float = -math.inf  # radii: what the engine proves of the length

    @property
    def effort(self) -> Effort:
        return Effort(self.subproblem, 1, self.evaluations, self.seconds)


class Attempts(NamedTuple, Generic[Guess, Point]):
    """One subproblem, and the initial guesses to solve it from in turn, computed one by one."""

    guesses: Iterable[Guess]
    solve: Callable[[Guess, float], Run[Point]]  # until a time (s, on `perf_counter`)
    enough: Callable[[Run[Point]], bool]  # whether a solution leaves no reason to try another guess


def tried(attempts: Iterable[Attempts[Guess, Point]], until: float) -> list[Run[Point]]:
    """The runs on all subproblems; none begins when the time is up.

    Each subproblem has an equal share of the time that is left: some engines never end on a word
    that has no path, and would leave nothing for the others.
    """
    runs: list[Run[Point]] = []
    every = list(attempts)
    for left, (guesses, solve, enough) in zip(range(len(every), 0, -1), every, strict=True):
        began = perf_counter()
        end = began + (until - began) / left
        for guess in guesses:
            if perf_counter() > end:
                break
            runs.append(solve(guess, end))
            if runs[-1].claim is Claim.LOCAL and enough(runs[-1]):
                break
    return runs


def best_of(arrived: Sequence[Run[Point]], others: Iterable[Run[Point]]) -> Run[Point]:
    """The shortest run that arrived; if none did, the one that ends nearest to the target."""
    if arrived:
        return min(arrived, key=lambda run: run.length)
    return min(others, key=lambda run: run.miss)


def settled(
    runs: Sequence[Run[Point]], miss: Callable[[Run[Point]], float]
) -> tuple[Run[Point], Claim]:
    """The shortest run that is a solution to its engine, and that claim.

    If there is none: the run that misses least, and the claim that all share, or `failed`. What is
    feasible to the engine's tolerance but passes the points by is no path, and has failed too.
    """
    solved = [run for run in runs if run.claim is Claim.LOCAL]
    if solved:
        return best_of(solved, ()), Claim.LOCAL
    missed = (miss(run) for run in runs)
    known = zip(runs, (each if math.isfinite(each) else math.inf for each in missed), strict=True)
    best = best_of((), (run._replace(miss=each) for run, each in known))
    claims = {run.claim for run in runs}
    claim = claims.pop() if len(claims) == 1 else Claim.FAILED
    off = claim is Claim.FEASIBLE and not best.miss <= ARRIVES
    return best, Claim.FAILED if off else claim


def costs(runs: Sequence[Run[Any]]) -> dict[str, Any]:
    """The fields of a solution that say what all runs of a question cost."""
    return {
        "iterations": total(run.iterations for run in runs),
        "evaluations": total(run.evaluations for run in runs),
        "efforts": summed(run.effort for run in runs),
    }


def at_start(question: Question, tolerance: float = 0.0) -> Solution | None:
    """The path of no length where the target is within `tolerance` radii of the start, or None.

    Only one leg with a free final heading has it.
    """
    scenario = question.scenario
    if not scenario.one_free_leg or not math.hypot(*scenario.local()) <= tolerance:
        return None
    path = Path(question.scenario.start, [], [])
    return Solution(Claim.LOCAL, path=path, claimed_length=0.0, message="the target is the start")


def coordinate_rounding(scenario: Scenario) -> float:
    """The distance (radii) between start and target that the coordinates' rounding may fake."""
    return 2 * EPS * scenario.extent / scenario.radius


def in_world(scenario: Scenario, duals: FloatArray) -> tuple[float, float]:
    """The duals (2,) of the end point, turned from body coordinates."""
    along, left = float(duals[0]), float(duals[1])
    cos, sin = math.cos(scenario.heading), math.sin(scenario.heading)
    return along * cos - left * sin, along * sin + left * cos


def total(counts: Iterable[int | None]) -> int | None:
    """The sum, or None if an engine does not count."""
    known = list(counts)
    return None if None in known else sum(count for count in known if count is not None)


def summed(efforts: Iterable[Effort]) -> tuple[Effort, ...]:
    """Efforts by subproblem, in the order in which these were begun."""
    by_name: dict[str, list[Effort]] = {}
    for effort in efforts:
        by_name.setdefault(effort.subproblem, []).append(effort)
    return tuple(
        Effort(
            name,
            sum(effort.runs for effort in group),
            total(effort.evaluations for effort in group),
            sum(effort.seconds for effort in group),
        )
        for name, group in by_name.items()
    )
