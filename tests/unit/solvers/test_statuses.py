"""Claim of each status of each engine.

A status has its own meaning, whichever interface tells it.
"""

import importlib
from dataclasses import replace

import numpy as np
import pytest

from dubins_study.solvers.convex.adapters import ENGINES as CONVEX
from dubins_study.solvers.convex.adapters import Ask, prepare
from dubins_study.solvers.convex.solver import INTERFACES
from dubins_study.solvers.engines import MINLP_ENGINES, NLP_ENGINES
from dubins_study.solvers.nlp_engines import casadi_nlpsol
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.solvers.statuses import STATUSES, claim_of
from dubins_study.study.convex.problem import read
from dubins_study.study.words import Claim

# engine -> claim -> its statuses
MEANS: dict[str, dict[str, tuple[str, ...]]] = {
    "slsqp": {
        "local": ("mode 0",),
        "limit": ("mode 9", "mode 99"),
        "failed": ("mode -1", "mode 2", "mode 3", "mode 4", "mode 5", "mode 6", "mode 7", "mode 8"),
    },
    "cobyqa": {
        "local": ("status 0",),
        "limit": ("status 3", "status 5", "status 6"),
        "failed": ("status 1", "status 2", "status 4", "status -1", "status -2"),
    },
    "trust-constr": {
        "local": ("status 1", "status 2"),
        "limit": ("status 0", "status 3"),
        "failed": ("status 4",),
    },
    "casadi": {
        "local": ("SOLVER_RET_SUCCESS",),
        "limit": ("SOLVER_RET_LIMITED",),
        "failed": (
            *("SOLVER_RET_UNKNOWN", "SOLVER_RET_NAN", "SOLVER_RET_INFEASIBLE"),
            "SOLVER_RET_EXCEPTION",
        ),
    },
    "ipopt": {
        "local": ("Solve_Succeeded", "Solved_To_Acceptable_Level"),
        "feasible": ("Feasible_Point_Found",),
        "locally infeasible": ("Infeasible_Problem_Detected",),
        "limit": (
            *("Maximum_Iterations_Exceeded", "Maximum_CpuTime_Exceeded"),
            *("Maximum_WallTime_Exceeded", "User_Requested_Stop"),
        ),
        "failed": (
            *("Search_Direction_Becomes_Too_Small", "Diverging_Iterates", "Restoration_Failed"),
            *("Error_In_Step_Computation", "Not_Enough_Degrees_Of_Freedom"),
            *("Invalid_Problem_Definition", "Invalid_Option", "Invalid_Number_Detected"),
            *("Unrecoverable_Exception", "NonIpopt_Exception_Thrown", "Insufficient_Memory"),
            "Internal_Error",
        ),
    },
    "uno": {
        "local": ("Converged with feasible KKT point",),
        "feasible": ("Converged with feasible FJ point", "Terminated with feasible small step"),
        "locally infeasible": ("Converged with infeasible stationary point",),
        "failed": (
            *("Terminated with infeasible small step", "Terminated with unbounded problem"),
            "Terminated with an unknown status",
        ),
    },
    "uno-filtersqp": {
        "local": ("FEASIBLE_KKT_POINT",),
        "feasible": ("FEASIBLE_FJ_POINT", "FEASIBLE_SMALL_STEP"),
        "locally infeasible": ("INFEASIBLE_STATIONARY_POINT",),
        "limit": ("ITERATION_LIMIT", "TIME_LIMIT"),
        "failed": (
            *("NOT_OPTIMAL", "INFEASIBLE_SMALL_STEP", "DIVERGING_ITERATE", "UNBOUNDED_OBJECTIVE"),
            *("EVALUATION_ERROR", "ALGORITHMIC_ERROR", "USER_TERMINATION", "USER_INTERRUPTION"),
        ),
    },
    "fatrop": {"failed": ("1",)},
    "alpaqa": {},
    "bonmin": {
        "locally infeasible": ("INFEASIBLE",),
        "limit": ("LIMIT_EXCEEDED",),
        "failed": ("CONTINUOUS_UNBOUNDED", "USER_INTERRUPT", "MINLP_ERROR"),
    },
    "sleqp": {
        "local": ("optimal",),
        "feasible": ("feasible",),
        "locally infeasible": ("infeasible",),
        "limit": ("iteration limit", "time limit"),
        "failed": ("deadpoint", "unbounded"),
    },
    "apopt": {
        "local": ("Successful solution",),
        "locally infeasible": ("No feasible solution",),
        "limit": ("Maximum iterations", "time limit"),
        "failed": ("Requested accuracy unachievable",),
    },
    "nlopt": {
        "local": ("SUCCESS", "FTOL_REACHED", "XTOL_REACHED"),
        "limit": ("MAXEVAL_REACHED", "MAXTIME_REACHED"),
        "failed": (
            *("STOPVAL_REACHED", "FAILURE", "INVALID_ARGS", "OUT_OF_MEMORY", "ROUNDOFF_LIMITED"),
            "FORCED_STOP",
        ),
    },
    "pyomo": {
        "local": ("convergenceCriteriaSatisfied",),
        "infeasible": ("provenInfeasible", "infeasibleOrUnbounded"),
        "locally infeasible": ("locallyInfeasible",),
        "limit": ("maxTimeLimit", "iterationLimit"),
        "failed": (
            *("objectiveLimit", "minStepLength", "unbounded", "error", "interrupted"),
            *("licensingProblems", "emptyModel", "unknown"),
        ),
    },
    "ampl": {
        "local": ("0",),
        "feasible": ("1",),
        "locally infeasible": ("2",),
        "limit": ("4",),
        "failed": ("3", "5", "6", "-1"),
    },
    "scip": {
        "optimal": ("optimal", "gaplimit"),
        "infeasible": ("infeasible", "inforunbd"),
        "limit": ("timelimit", "memlimit"),
        # with a point, `feasible`
        "failed": (
            *("unbounded", "unknown", "userinterrupt", "nodelimit", "totalnodelimit"),
            *("stallnodelimit", "sollimit", "bestsollimit", "restartlimit"),
            *("primallimit", "duallimit"),
        ),
    },
    "maingo": {
        "optimal": ("GLOBALLY_OPTIMAL", "BOUND_TARGETS"),
        "infeasible": ("INFEASIBLE",),
        "limit": ("FEASIBLE_POINT", "NO_FEASIBLE_POINT_FOUND"),
        "failed": ("NOT_SOLVED_YET", "JUST_A_WORKER_DONT_ASK_ME"),
    },
    "cvxpy": {
        "optimal": ("optimal",),
        "infeasible": ("infeasible", "infeasible_or_unbounded"),
        "limit": ("user_limit",),
        "failed": (
            *("unbounded", "optimal_inaccurate", "infeasible_inaccurate", "unbounded_inaccurate"),
            *("solver_error", "unknown"),
        ),
    },
    "piqp": {
        "optimal": ("PIQP_SOLVED",),
        "infeasible": ("PIQP_PRIMAL_INFEASIBLE",),
        "limit": ("PIQP_MAX_ITER_REACHED",),
        "failed": (
            *("PIQP_DUAL_INFEASIBLE", "PIQP_NUMERICS", "PIQP_UNSOLVED", "PIQP_INVALID_SETTINGS"),
        ),
    },
    "clarabel": {
        "optimal": ("Solved",),
        "infeasible": ("PrimalInfeasible",),
        "limit": ("MaxIterations", "MaxTime"),
        "failed": (
            *("AlmostSolved", "AlmostPrimalInfeasible", "AlmostDualInfeasible", "DualInfeasible"),
            *("NumericalError", "InsufficientProgress", "CallbackTerminated", "Unsolved"),
        ),
    },
    "osqp": {
        "optimal": ("solved",),
        "infeasible": ("primal infeasible",),
        "limit": (
            *("maximum iterations reached", "run time limit reached", "solved inaccurate"),
            *("primal infeasible inaccurate", "dual infeasible inaccurate"),
        ),
        "failed": ("dual infeasible", "problem non convex", "interrupted", "unsolved"),
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
        "failed": ("unbounded", "infeasible (inaccurate)", "interrupted", "indeterminate"),
    },
    "glpk": {
        "optimal": ("GLP_OPT", "GLP_EMIPGAP"),
        "infeasible": ("GLP_NOFEAS", "GLP_ENOPFS"),
        "limit": ("GLP_ETMLIM", "GLP_FEAS", "GLP_UNDEF"),
        "failed": ("GLP_ENODFS", "2"),
    },
    "cbc": {
        "optimal": ("OPTIMAL",),
        "infeasible": ("INFEASIBLE",),
        "limit": ("FEASIBLE", "NOT_SOLVED"),
        "failed": ("UNBOUNDED", "ABNORMAL", "MODEL_INVALID"),
    },
    "cp-sat": {
        "optimal": ("OPTIMAL",),
        "feasible": ("FEASIBLE",),
        "infeasible": ("INFEASIBLE",),
        "limit": ("UNKNOWN",),
        "failed": ("MODEL_INVALID",),
    },
    "routing": {
        "optimal": ("ROUTING_OPTIMAL",),
        "local": ("ROUTING_SUCCESS",),
        "feasible": ("ROUTING_PARTIAL_SUCCESS_LOCAL_OPTIMUM_NOT_REACHED",),
        "infeasible": ("ROUTING_INFEASIBLE",),
        "limit": ("ROUTING_FAIL_TIMEOUT",),
        "failed": ("ROUTING_NOT_SOLVED", "ROUTING_FAIL", "ROUTING_INVALID"),
    },
    "highs": {
        "optimal": ("kOptimal",),
        "infeasible": ("kInfeasible", "kUnboundedOrInfeasible"),
        "limit": ("kTimeLimit", "kIterationLimit", "kMemoryLimit"),
        "failed": (
            *("kNotset", "kLoadError", "kModelError", "kPresolveError", "kSolveError"),
            *("kPostsolveError", "kModelEmpty", "kUnbounded", "kObjectiveBound", "kUnknown"),
            *("kObjectiveTarget", "kSolutionLimit", "kInterrupt", "kHighsInterrupt"),
        ),
    },
    "proxqp": {
        "optimal": ("PROXQP_SOLVED",),
        "infeasible": ("PROXQP_PRIMAL_INFEASIBLE", "PROXQP_SOLVED_CLOSEST_PRIMAL_FEASIBLE"),
        "limit": ("PROXQP_MAX_ITER_REACHED",),
        "failed": ("PROXQP_DUAL_INFEASIBLE", "PROXQP_NOT_RUN"),
    },
    "qpalm": {
        "optimal": ("solved",),
        "infeasible": ("primal infeasible",),
        "limit": ("maximum iterations reached", "time limit exceeded"),
        "failed": ("dual infeasible", "dual terminated", "cancelled by user", "unsolved"),
    },
    "ecos": {
        "optimal": ("Optimal solution found",),
        "infeasible": ("Primal infeasible",),
        "limit": ("Maximum number of iterations reached",),
        "failed": (
            *("Close to optimal solution found", "Close to primal infeasible", "Dual infeasible"),
            *("Close to dual infeasible", "Run into numerical problems", "INTERRUPTED"),
        ),
    },
    "daqp": {
        "optimal": ("1",),
        "infeasible": ("-1",),
        "limit": ("-4", "-7"),
        "failed": ("2", "-2", "-3", "-5", "-6"),
    },
}
# casadi's own methods end with Ipopt's words
MEANS |= dict.fromkeys(("sqpmethod", "qrsqp"), MEANS["ipopt"])
NAMED = [
    (engine, status, claim)
    for engine, claims in MEANS.items()
    for claim, statuses in claims.items()
    for status in statuses
]
# engine -> where its library lists its statuses
ENUMERATED = {
    "piqp": ("piqp", "Status"),
    "maingo": ("maingopy", "RETCODE"),
    "highs": ("highspy", "HighsModelStatus"),
    "pyomo": ("pyomo.contrib.solver.common.results", "TerminationCondition"),
}


@pytest.mark.parametrize(("engine", "status", "claim"), NAMED)
def test_a_status_claims_what_its_engine_means(engine, status, claim):
    assert claim_of(engine, status) == claim


def test_every_engine_and_every_status_of_the_table_is_named():
    named = {(engine, status) for engine, status, _ in NAMED}

    assert MEANS.keys() == STATUSES.keys()
    for engine, claims in STATUSES.items():
        assert {(engine, status) for statuses in claims.values() for status in statuses} <= named
    plain = {name for name in NLP_ENGINES if not name.startswith("nlopt")}
    assert plain | {*MINLP_ENGINES, *CONVEX} <= STATUSES.keys()


@pytest.mark.parametrize("engine", ENUMERATED)
def test_no_status_of_a_library_is_forgotten(engine):
    """A new version may add one."""
    package, name = ENUMERATED[engine]
    if reason := missing_package(package.partition(".")[0]):
        pytest.skip(reason)
    listed = getattr(importlib.import_module(package), name).__members__

    assert {*listed} == {status for named, status, _ in NAMED if named == engine}


def test_no_status_of_uno_and_clarabel_is_forgotten():
    if reason := missing_package("unopy", "clarabel"):
        pytest.skip(reason)
    unopy, clarabel = map(importlib.import_module, ("unopy", "clarabel"))
    of_uno = {*unopy.OptimizationStatus.__members__, *unopy.SolutionStatus.__members__}
    listed = {
        "uno-filtersqp": of_uno - {"SUCCESS"},
        "clarabel": {name for name in dir(clarabel.SolverStatus) if not name.startswith("_")},
    }

    for engine, statuses in listed.items():
        assert statuses == {status for named, status, _ in NAMED if named == engine}


@pytest.mark.parametrize(
    ("plugin", "status", "unified", "claim"),
    [
        # casadi's word counts where the engine's is not known
        ("uno", "Terminated with not optimal point", "LIMITED", Claim.LIMIT),
        ("uno", "Terminated with infeasible small step", "INFEASIBLE", Claim.FAILED),
        ("fatrop", "0", "SUCCESS", Claim.LOCAL),
        ("alpaqa", None, "LIMITED", Claim.LIMIT),
        ("bonmin", "SUCCESS", "SUCCESS", Claim.LOCAL),
        ("ipopt", "Restoration_Failed", "UNKNOWN", Claim.FAILED),
        ("qrsqp", "Search_Direction_Becomes_Too_Small", "UNKNOWN", Claim.FAILED),
        # casadi calls it a success; SLEQP itself calls it an abort
        ("sleqp", "deadpoint", "SUCCESS", Claim.FAILED),
        ("sleqp", "iteration limit", "SUCCESS", Claim.LIMIT),
    ],
)
def test_casadis_word_counts_where_the_engine_has_none(plugin, status, unified, claim):
    stats = {"return_status": status, "unified_return_status": f"SOLVER_RET_{unified}"}

    assert casadi_nlpsol.claim(plugin, stats) is claim


@pytest.mark.parametrize("engine", CONVEX)
@pytest.mark.parametrize("interface", INTERFACES)
def test_no_point_is_infeasible_by_either_interface(engine, interface):
    """No point is infeasible by either interface.

    One of the rows asks for what the variables' bounds exclude.
    """
    if reason := missing_package(CONVEX[engine].package, "cvxpy"):
        pytest.skip(reason)
    problem = read("qp-50-random-6-0")
    first = np.arange(problem.u.size) == 0
    lower, upper = (np.where(first, -1e3, ends) for ends in (problem.l, problem.u))

    reply = prepare(engine, interface, replace(problem, l=lower, u=upper))(Ask(1e-6, 5.0))

    assert reply.claim is Claim.INFEASIBLE, reply.status
    assert claim_of(engine, reply.status) is reply.claim


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
@pytest.mark.parametrize("engine", [name for name, engine in CONVEX.items() if engine.seconds])
@pytest.mark.parametrize("interface", INTERFACES)
def test_the_time_limit_is_a_limit_by_either_interface(engine, interface):
    """The time limit is one by either interface.

    SCS says "solved (inaccurate ...)", of which cvxpy leaves "inaccurate" alone.
    """
    if reason := missing_package(CONVEX[engine].package, "cvxpy"):
        pytest.skip(reason)
    if (engine, interface) == ("daqp", "cvxpy"):
        pytest.skip("cvxpy hands over no time limit")

    reply = prepare(engine, interface, read("qp-500-cluster-9-38"))(Ask(1e-9, 1e-3))

    assert reply.claim is Claim.LIMIT, reply.status
