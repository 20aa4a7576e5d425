"""Why a worker ended, in words, and what follows for the other jobs of its solver."""

from __future__ import annotations

import signal

from dubins_study.experiments.isolation.job_queue import SolverKey
from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.reply import Reply, no_answer


def exit_status(code: int) -> tuple[str, str]:
    """The end of a process in a word and in a sentence.

    Args:
        code: its exit code, or minus the number of the signal that ended it.
    """
    if code >= 0:
        return f"exit {code}", f"its process ended itself with code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return name, f"its process was ended by {name}"


def crashed(code: int, output: str) -> Reply:
    """The reply of a worker that ended by itself, with the last that it printed."""
    status, message = exit_status(code)
    if output:
        message = f"{message}; its last output: {output}"
    # C++ ends a process so that may have no more memory
    starved = code == -signal.SIGABRT and "bad_alloc" in output
    outcome = Outcome.OUT_OF_MEMORY if starved else Outcome.CRASHED
    return no_answer(outcome, message, status=status)


class LoadFailures:
    """Which solvers are loaded without a warm-up, and which are not loaded again.

    Args:
        warm_up: whether solvers are asked an easy question before their first job.
    """

    def __init__(self, warm_up: bool):
        self._warm_up = warm_up
        self._without_warm_up: set[SolverKey] = set()  # their warm-up ended a worker
        # solvers that ended a worker as it loaded them, with the reply that stands for all jobs
        self._given_up: dict[SolverKey, Reply] = {}
        self._answered: set[SolverKey] = set()

    def warms_up(self, solver: SolverKey) -> bool:
        """Whether a worker that loads a solver asks it an easy question first."""
        return self._warm_up and solver not in self._without_warm_up

    def reply(self, solver: SolverKey) -> Reply | None:
        """The reply to a job of a solver that is not loaded again."""
        first = self._given_up.get(solver)
        if first is None:
            return None
        return _with_message(first, f"{first.solution.message} for another cell; not tried again")

    def note_answer(self, solver: SolverKey) -> None:
        """A solver has been loaded, and has answered."""
        self._answered.add(solver)

    def note_failure(self, solver: SolverKey, warmed_up: bool, reply: Reply) -> Reply | None:
        """The reply to a job whose solver ended the worker while it was loaded.

        None if the job is to be put once more: the warm-up may have been to blame.
        """
        if warmed_up:
            self._without_warm_up.add(solver)
            return None
        reply = _with_message(reply, f"{reply.solution.message}, while it was loaded")
        if solver not in self._answered:
            self._given_up[solver] = reply
        return reply


def _with_message(reply: Reply, message: str) -> Reply:
    return no_answer(reply.outcome, message, status=reply.solution.native_status)
