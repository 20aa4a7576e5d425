"""One question, solved in a separate worker process."""

from __future__ import annotations

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.job_queue import Job
from dubins_study.experiments.isolation.monitor import Limits
from dubins_study.experiments.isolation.pool import WorkerPool
from dubins_study.experiments.isolation.sandbox import pinned_threads
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.experiments.run_settings import BYTES_PER_GIB
from dubins_study.solvers.attempt import Answer, check_request, judged
from dubins_study.solvers.profiles import tolerances
from dubins_study.solvers.protocol import Outcome, Question
from dubins_study.solvers.reply import DEFAULT_LIMIT, exception_text, no_answer
from dubins_study.study.scenario import Scenario

MEMORY = 4.0  # GiB that the worker and its children may hold


def solve_isolated(
    scenario: Scenario,
    solver: str,
    branch: str = "best",
    *,
    profile: str = "default",
    limit: float = DEFAULT_LIMIT,
    memory: float = MEMORY,
) -> Answer:
    """Solve one scenario as a run does: if the solver ends its process, that is an answer too.

    Args and Raises as `solvers.solve`, which solves in the caller's process; `memory` is in GiB.
    After a first interruption it waits for the answer; a second one ends it at once.
    """
    check_request(branch, limit)
    allowed = tolerances(profile)
    describe_solver(solver, profile)
    question = Question(scenario, branch)
    limits = Limits(limit, round(memory * BYTES_PER_GIB))
    with Interruption() as stop, pinned_threads(), WorkerPool(1, limits, warm_up=False) as pool:
        results = [
            one for some in pool.solve([Job(solver, profile, question)], stop) for one in some
        ]
        stop.check()
    reply = results[0][1].reply
    try:
        return judged(solver, question, reply, allowed)
    except Exception as error:  # the check cannot drive the path: an answer too, as in a run
        return judged(solver, question, no_answer(Outcome.RAISED, exception_text(error)), allowed)
