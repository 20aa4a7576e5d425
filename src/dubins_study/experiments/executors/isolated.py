"""Questions put to one solver in a worker process of their own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import Job, Limits, WorkerPool
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.experiments.run_settings import BYTES_PER_GIB
from dubins_study.solvers.attempt import Answer, judged
from dubins_study.solvers.profiles import tolerances
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import ours
from dubins_study.solvers.reply import Reply, exception_text, no_answer
from dubins_study.study.words import Outcome

_MEMORY_GIB = 4.0  # that the worker and its children may hold


def ask_isolated(
    solver: str, profile: str, questions: Iterable[Question], limit: float
) -> Iterator[Answer]:
    """Yield the judged answers to questions, in their order, as a run would have them.

    If a solve ends the worker, that is an answer, and the next question goes to a new worker.

    Args:
        solver: a valid spec.
        profile: its name.
        questions: the questions.
        limit: seconds for each.

    Raises:
        RunError: if no worker process can be started.
        KeyboardInterrupt: at once; the worker is then killed.
    """
    jobs = (Job(solver, profile, question, place) for place, question in enumerate(questions))
    waiting: dict[int, Answer] = {}
    limits = Limits(limit, round(_MEMORY_GIB * BYTES_PER_GIB))
    # A warm-up loads the libraries, which are no part of the limit; a plug-in may hang in one.
    with WorkerPool(1, limits, warm_up=ours(solver)) as pool:
        place = 0
        for results in pool.solve(jobs, Interruption()):
            for job, worker_reply in results:
                waiting[job.tag] = _judged(solver, profile, job.question, worker_reply.reply)
            while place in waiting:
                yield waiting.pop(place)
                place += 1


def _judged(solver: str, profile: str, question: Question, reply: Reply) -> Answer:
    known = tolerances(profile), describe_solver(solver, profile).method
    try:
        return judged(solver, question, reply, *known)
    except Exception as error:  # the check cannot drive the path: an answer too, as in a run
        return judged(solver, question, no_answer(Outcome.RAISED, exception_text(error)), *known)
