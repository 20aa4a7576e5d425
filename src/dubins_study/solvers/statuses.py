"""Statuses of engines, and the claims that they make."""

from __future__ import annotations

from dubins_study.study.words import Claim

# By the names of engines: each claim, and the statuses that make it. The names `casadi`, `cvxpy`,
# `pyomo` and `ampl` are those of interfaces with statuses of their own.
#
# `optimal`, `local`: solved, to the tolerances that were asked for.
# `feasible`: a point, and no more.
# `infeasible`: no point exists.
# `locally infeasible`: no point exists near the one at which a local engine ended.
# `limit`: a limit ended the run, whatever the engine reports of its point.
# A status that is not listed is `failed`. So are a problem that is solved, or proved infeasible, to
# less than was asked ("almost", "close to"), and one that is called unbounded or dual infeasible:
# no problem here is either of the two.
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
        # the acceptable level is its makers' second accuracy, 1e-6, which is enough to arrive
        "local": ("Solve_Succeeded", "Solved_To_Acceptable_Level"),
        "feasible": ("Feasible_Point_Found",),
        "locally infeasible": ("Infeasible_Problem_Detected",),
        "limit": (
            "Maximum_Iterations_Exceeded",
            "Maximum_CpuTime_Exceeded",
            "Maximum_WallTime_Exceeded",
            "User_Requested_Stop",
        ),
    },
    # its status tells both how it stopped and the kind of point
    "uno": {
        "local": ("Converged with feasible KKT point",),
        "feasible": (
            "Converged with feasible FJ point",
            "Terminated with feasible small step",
        ),
        "locally infeasible": ("Converged with infeasible stationary point",),
    },
    "uno-filtersqp": {
        "local": ("FEASIBLE_KKT_POINT",),
        "feasible": ("FEASIBLE_FJ_POINT", "FEASIBLE_SMALL_STEP"),
        "locally infeasible": ("INFEASIBLE_STATIONARY_POINT",),
        "limit": ("ITERATION_LIMIT", "TIME_LIMIT"),
    },
    "fatrop": {"failed": ("1",)},  # failures of every kind; 0 is a success
    "alpaqa": {},
    # its node is Ipopt
    "bonmin": {"locally infeasible": ("INFEASIBLE",), "limit": ("LIMIT_EXCEEDED",)},
    # casadi calls every ending a success, the dead point (SLEQP_STATUS_ABORT_DEADPOINT) too
    "sleqp": {
        "local": ("optimal",),
        "feasible": ("feasible",),
        "locally infeasible": ("infeasible",),
        "limit": ("iteration limit", "time limit"),
        "failed": ("deadpoint", "unbounded"),
    },
    # the last line that it prints
    "apopt": {
        "local": ("Successful solution",),
        "locally infeasible": ("No feasible solution",),
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
        "infeasible": ("provenInfeasible", "infeasibleOrUnbounded"),
        "locally infeasible": ("locallyInfeasible",),
        "limit": ("maxTimeLimit", "iterationLimit"),
    },
    # solve_result_num by the hundred (Fourer, Gay and Kernighan, AMPL, 2nd ed., sec. 14.2):
    # solved, solved with a warning, infeasible, unbounded, limit, failure
    "ampl": {
        "local": ("0",),
        "feasible": ("1",),
        "locally infeasible": ("2",),  # as JuMP reads it: these files come from local engines
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
            "maximum iterations reached",
            "run time limit reached",
            "solved inaccurate",
            "primal infeasible inaccurate",
            "dual infeasible inaccurate",
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
    "glpk": {
        "optimal": ("GLP_OPT", "GLP_EMIPGAP"),
        "infeasible": ("GLP_NOFEAS", "GLP_ENOPFS"),
        "limit": ("GLP_ETMLIM", "GLP_FEAS", "GLP_UNDEF"),
    },
    # names of OR-tools: linear_solver.h, cp_model.proto, routing.h
    "cbc": {
        "optimal": ("OPTIMAL",),
        "infeasible": ("INFEASIBLE",),
        "limit": ("FEASIBLE", "NOT_SOLVED"),
    },
    "cp-sat": {
        "optimal": ("OPTIMAL",),
        "feasible": ("FEASIBLE",),
        "infeasible": ("INFEASIBLE",),
        "limit": ("UNKNOWN",),
    },
    # a success is a local optimum; the other one was ended by the limit
    "routing": {
        "optimal": ("ROUTING_OPTIMAL",),
        "local": ("ROUTING_SUCCESS",),
        "feasible": ("ROUTING_PARTIAL_SUCCESS_LOCAL_OPTIMUM_NOT_REACHED",),
        "infeasible": ("ROUTING_INFEASIBLE",),
        "limit": ("ROUTING_FAIL_TIMEOUT",),
    },
    # for a problem that it calls infeasible it may return the point that is nearest to feasible
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
    """The claim that an engine's status makes.

    `engine` is a name in `STATUSES`. A status that is not listed there makes the claim `unnamed`.
    """
    for claim, statuses in STATUSES[engine].items():
        if status in statuses:
            return Claim(claim)
    return unnamed
