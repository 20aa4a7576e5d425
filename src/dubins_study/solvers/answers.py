"""What engines' statuses claim; runs of engines, and the answer that several give together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from typing import Any, Generic, NamedTuple, TypeVar

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import FloatArray, Path
from dubins_study.study.rows.schema import Effort
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import Claim

Point = TypeVar("Point")
Guess = TypeVar("Guess")

_OF_IPOPT = {
    "Solve_Succeeded": Claim.LOCAL,
    # its makers' second accuracy, 1e-6: what arriving needs
    "Solved_To_Acceptable_Level": Claim.LOCAL,
    "Feasible_Point_Found": Claim.FEASIBLE,
    "Infeasible_Problem_Detected": Claim.INFEASIBLE,
    "Maximum_Iterations_Exceeded": Claim.LIMIT,
    "Maximum_CpuTime_Exceeded": Claim.LIMIT,
    "Maximum_WallTime_Exceeded": Claim.LIMIT,
    "User_Requested_Stop": Claim.LIMIT,
}
_LIMITS_OF_SCS = ("(inaccurate - reached max_iters)", "(inaccurate - reached time_limit_secs)")
# What the status of an engine claims, by the engine's name, in the status's own words; the names
# `casadi`, `cvxpy`, `pyomo` and `ampl` are those of interfaces with statuses of their own.
#
# `optimal`, `local`: solved, to the tolerances that were asked for. `feasible`: a point, and no
# more. `infeasible`: no point exists, of a local engine: near its guess. `limit`: a limit ended the
# run, whatever the engine says of its point by then. What is not named is `failed`: also a problem
# that is solved, or proved infeasible, to less than was asked ("almost", "close to"), and one that
# is called unbounded or dual infeasible, as no problem here is.
STATUSES: dict[str, dict[str, Claim]] = {
    # scipy/optimize, slsqp: 99 is a stop by the callback; 4, an infeasible linearisation, is no
    # claim about the problem
    "slsqp": {"mode 0": Claim.LOCAL, "mode 9": Claim.LIMIT, "mode 99": Claim.LIMIT},
    # scipy/_lib/cobyqa/settings.py: the least trust-region radius, a callback's stop, limits; -1
    # says that the bounds exclude each other, no more
    "cobyqa": {
        "status 0": Claim.LOCAL,
        "status 3": Claim.LIMIT,
        "status 5": Claim.LIMIT,
        "status 6": Claim.LIMIT,
    },
    # 3 is a stop by the callback; 4 a success that misses its constraints
    "trust-constr": {
        "status 0": Claim.LIMIT,
        "status 1": Claim.LOCAL,
        "status 2": Claim.LOCAL,
        "status 3": Claim.LIMIT,
    },
    # casadi's word of an ending, where the engine's own is not named
    "casadi": {"SOLVER_RET_SUCCESS": Claim.LOCAL, "SOLVER_RET_LIMITED": Claim.LIMIT},
    "ipopt": _OF_IPOPT,
    "sqpmethod": _OF_IPOPT,
    "qrsqp": _OF_IPOPT,
    # says both how it stopped and what the point is
    "uno": {
        "Converged with feasible KKT point": Claim.LOCAL,
        "Converged with feasible FJ point": Claim.FEASIBLE,
        "Terminated with feasible small step": Claim.FEASIBLE,
        "Converged with infeasible stationary point": Claim.INFEASIBLE,
        "Terminated with infeasible small step": Claim.FAILED,
    },
    "uno-filtersqp": {
        "FEASIBLE_KKT_POINT": Claim.LOCAL,
        "FEASIBLE_FJ_POINT": Claim.FEASIBLE,
        "FEASIBLE_SMALL_STEP": Claim.FEASIBLE,
        "INFEASIBLE_STATIONARY_POINT": Claim.INFEASIBLE,
        "ITERATION_LIMIT": Claim.LIMIT,
        "TIME_LIMIT": Claim.LIMIT,
    },
    "fatrop": {"1": Claim.FAILED},  # of every kind; 0 is a success
    "alpaqa": {},
    "bonmin": {"INFEASIBLE": Claim.INFEASIBLE, "LIMIT_EXCEEDED": Claim.LIMIT},
    # casadi calls every ending a success, the dead point (SLEQP_STATUS_ABORT_DEADPOINT) too
    "sleqp": {
        "optimal": Claim.LOCAL,
        "feasible": Claim.FEASIBLE,
        "infeasible": Claim.INFEASIBLE,
        "deadpoint": Claim.FAILED,
        "unbounded": Claim.FAILED,
        "iteration limit": Claim.LIMIT,
        "time limit": Claim.LIMIT,
    },
    # its last words
    "apopt": {
        "Successful solution": Claim.LOCAL,
        "No feasible solution": Claim.INFEASIBLE,
        "Maximum iterations": Claim.LIMIT,
        "Requested accuracy unachievable": Claim.FAILED,
        "time limit": Claim.LIMIT,
    },
    # of all of NLopt's algorithms; its manual calls positive codes a success, which says that steps
    # have become small, on the equations or off them
    "nlopt": {
        "SUCCESS": Claim.LOCAL,
        "FTOL_REACHED": Claim.LOCAL,
        "XTOL_REACHED": Claim.LOCAL,
        "MAXEVAL_REACHED": Claim.LIMIT,
        "MAXTIME_REACHED": Claim.LIMIT,
    },
    # termination conditions, pyomo.contrib.solver.common.results
    "pyomo": {
        "convergenceCriteriaSatisfied": Claim.LOCAL,
        "provenInfeasible": Claim.INFEASIBLE,
        "locallyInfeasible": Claim.INFEASIBLE,
        "infeasibleOrUnbounded": Claim.INFEASIBLE,
        "maxTimeLimit": Claim.LIMIT,
        "iterationLimit": Claim.LIMIT,
    },
    # solve_result_num by the hundred (Fourer, Gay and Kernighan, AMPL, 2nd ed., sec. 14.2):
    # solved, solved with a warning, infeasible, unbounded, limit, failure
    "ampl": {"0": Claim.LOCAL, "1": Claim.FEASIBLE, "2": Claim.INFEASIBLE, "4": Claim.LIMIT},
    "scip": {
        "optimal": Claim.OPTIMAL,
        "gaplimit": Claim.OPTIMAL,
        "infeasible": Claim.INFEASIBLE,
        "inforunbd": Claim.INFEASIBLE,
        "timelimit": Claim.LIMIT,
        "memlimit": Claim.LIMIT,
    },
    # status codes by name (Gurobi Optimizer reference manual, Optimization Status Codes)
    "gurobi": {
        "optimal": Claim.OPTIMAL,
        "infeasible": Claim.INFEASIBLE,
        "inf or unbd": Claim.INFEASIBLE,
        "time limit": Claim.LIMIT,
        "mem limit": Claim.LIMIT,
        "numeric": Claim.FAILED,
        "suboptimal": Claim.FEASIBLE,
    },
    # statuses of the solution
    "xpress": {
        "OPTIMAL": Claim.OPTIMAL,
        "INFEASIBLE": Claim.INFEASIBLE,
        "FEASIBLE": Claim.FEASIBLE,
    },
    "maingo": {
        "GLOBALLY_OPTIMAL": Claim.OPTIMAL,
        "BOUND_TARGETS": Claim.OPTIMAL,
        "INFEASIBLE": Claim.INFEASIBLE,
        "FEASIBLE_POINT": Claim.LIMIT,
        "NO_FEASIBLE_POINT_FOUND": Claim.LIMIT,
    },
    "cvxpy": {
        "optimal": Claim.OPTIMAL,
        "infeasible": Claim.INFEASIBLE,
        "infeasible_or_unbounded": Claim.INFEASIBLE,
        "user_limit": Claim.LIMIT,
    },
    "piqp": {
        "PIQP_SOLVED": Claim.OPTIMAL,
        "PIQP_PRIMAL_INFEASIBLE": Claim.INFEASIBLE,
        "PIQP_MAX_ITER_REACHED": Claim.LIMIT,
    },
    "clarabel": {
        "Solved": Claim.OPTIMAL,
        "PrimalInfeasible": Claim.INFEASIBLE,
        "MaxIterations": Claim.LIMIT,
        "MaxTime": Claim.LIMIT,
    },
    # "inaccurate": a limit was reached, and ten times the tolerance is kept (its `status_values`)
    "osqp": {
        "solved": Claim.OPTIMAL,
        "primal infeasible": Claim.INFEASIBLE,
        "maximum iterations reached": Claim.LIMIT,
        "run time limit reached": Claim.LIMIT,
        "solved inaccurate": Claim.LIMIT,
        "primal infeasible inaccurate": Claim.LIMIT,
        "dual infeasible inaccurate": Claim.LIMIT,
    },
    "scs": {
        "solved": Claim.OPTIMAL,
        "infeasible": Claim.INFEASIBLE,
        **{f"solved {reached}": Claim.LIMIT for reached in _LIMITS_OF_SCS},
        **{f"infeasible {reached}": Claim.LIMIT for reached in _LIMITS_OF_SCS},
        **{f"unbounded {reached}": Claim.LIMIT for reached in _LIMITS_OF_SCS},
    },
    "highs": {
        "kOptimal": Claim.OPTIMAL,
        "kInfeasible": Claim.INFEASIBLE,
        "kUnboundedOrInfeasible": Claim.INFEASIBLE,
        "kTimeLimit": Claim.LIMIT,
        "kIterationLimit": Claim.LIMIT,
        "kMemoryLimit": Claim.LIMIT,
    },
    # of a problem that it calls infeasible it may give the point that is nearest to feasible
    "proxqp": {
        "PROXQP_SOLVED": Claim.OPTIMAL,
        "PROXQP_PRIMAL_INFEASIBLE": Claim.INFEASIBLE,
        "PROXQP_SOLVED_CLOSEST_PRIMAL_FEASIBLE": Claim.INFEASIBLE,
        "PROXQP_MAX_ITER_REACHED": Claim.LIMIT,
    },
    "qpalm": {
        "solved": Claim.OPTIMAL,
        "primal infeasible": Claim.INFEASIBLE,
        "maximum iterations reached": Claim.LIMIT,
        "time limit exceeded": Claim.LIMIT,
    },
    "ecos": {
        "Optimal solution found": Claim.OPTIMAL,
        "Primal infeasible": Claim.INFEASIBLE,
        "Maximum number of iterations reached": Claim.LIMIT,
    },
    # -4 and -7 are limits of iterations and of time; 2 is an optimum with soft constraints, -6 a
    # first working set that depends on itself
    "daqp": {
        "1": Claim.OPTIMAL,
        "-1": Claim.INFEASIBLE,
        "-4": Claim.LIMIT,
        "-7": Claim.LIMIT,
    },
}


def claim_of(engine: str, status: str, unnamed: Claim = Claim.FAILED) -> Claim:
    """The claim of an engine's status, by the engine's name in `STATUSES`."""
    return STATUSES[engine].get(status, unnamed)


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
    """The path of no length where the target is within `tolerance` radii of the start, or None."""
    if not math.hypot(*question.scenario.local()) <= tolerance:
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
