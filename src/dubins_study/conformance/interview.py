"""Questions put to one solver, its judged answers, and what else was seen."""

from __future__ import annotations

from collections import Counter
from time import monotonic
from typing import Any, NamedTuple, Self

from dubins_study.conformance.observer import Observation
from dubins_study.conformance.worker import Source
from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.attempt import Answer, judged
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.protocol import Method, Question
from dubins_study.solvers.reply import Reply, no_answer
from dubins_study.study.words import Claim, Outcome, Verdict

# Questions in a row that may end in a timeout before no more are asked.
MAX_TIMEOUTS = 3


class UnfinishedError(DubinsStudyError):
    """No more questions are put to the solver; the message says why."""


class Seen(NamedTuple):
    """A judged answer, and what else was seen while the solver worked on it.

    Args:
        answer, question: the answer to the question.
        traceback, changes, loaded, output: as in `Observation`.
        files: new files in the folder of the worker.
        seconds: until the answer was here.
    """

    answer: Answer
    question: Question
    traceback: str
    changes: tuple[str, ...]
    loaded: bool
    output: str
    files: tuple[str, ...]
    seconds: float


class Interview:
    """Questions to one solver and its judged answers, each asked once unless `again` is given.

    Args:
        spec: the solver's, as the caller wrote it.
        source: where it is asked.
        profile: of the judgement's tolerances.
        limit: seconds for each question.
        total_limit: seconds for all of them.

    Attributes:
        seen: every answer so far, in the order of asking.
    """

    def __init__(self, spec: str, source: Source, profile: str, limit: float, total_limit: float):
        self.spec, self.declared, self.limit = spec, source.declared, limit
        self.method = Method(*self.declared["method"])
        self.seen: list[Seen] = []
        self._source, self._allowed = source, PROFILES[profile]
        self._total_limit, self._end = total_limit, monotonic() + total_limit
        self._timeouts = 0
        self._answers: dict[tuple[Any, ...], Seen] = {}
        self._files: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._source.close()

    @property
    def answered(self) -> bool:
        """Whether any question was answered, rightly or wrongly."""
        return any(seen.answer.outcome is Outcome.RETURNED for seen in self.seen)

    def counts(self) -> dict[str, int]:
        """How the questions ended, as `ConformanceReport.answers` has it."""
        ended = Counter(_ending(seen.answer) for seen in self.seen)
        return {name: ended[name] for name in ENDINGS}

    def answers(self, branch: str) -> bool:
        """Whether the solver says that it answers a branch."""
        return branch in self.declared["branches"]

    def ask(self, question: Question, *, again: bool = False, limit: float | None = None) -> Seen:
        """The judged answer to a question; the earlier one unless `again`.

        Raises:
            UnfinishedError: if the time for all questions is over, or too many were not answered.
        """
        key = (question.scenario, question.branch, question.repeat, limit)
        if question.initial_guess is None and not again and key in self._answers:
            return self._answers[key]
        if monotonic() > self._end:
            raise UnfinishedError(
                f"the {self._total_limit:g} s for all questions are over; "
                "raise --total-time-limit (in Python: total_time_limit)"
            )
        if self._timeouts >= MAX_TIMEOUTS:
            raise UnfinishedError(f"{MAX_TIMEOUTS} questions in a row were not answered in time")
        given = self.limit if limit is None else limit
        began = monotonic()
        observation = self._source.ask(question, given)
        seen = self._seen(question, observation, monotonic() - began)
        timed_out = observation.reply.outcome is Outcome.TIMEOUT
        self._timeouts = self._timeouts + 1 if timed_out else 0
        self.seen.append(seen)
        if question.initial_guess is None:
            self._answers.setdefault(key, seen)
        return seen

    def ask_frame(self, questions: list[Question]) -> list[Seen]:
        """The judged answers to questions that are put as one frame."""
        began = monotonic()
        observations = self._source.ask_frame(questions, self.limit)
        seconds = monotonic() - began
        pairs = zip(questions, observations, strict=True)
        return [self._seen(question, one, seconds) for question, one in pairs]

    def _seen(self, question: Question, observation: Observation, seconds: float) -> Seen:
        answer = self._judged(question, observation.reply)
        return Seen(answer, question, *observation[1:], self._new_files(), seconds)

    def restart(self) -> None:
        """Ask the next question in a new process."""
        self._source.restart()

    def _judged(self, question: Question, reply: Reply) -> Answer:
        try:
            return judged(self.spec, question, reply, self._allowed, self.method)
        except Exception as error:  # the check cannot drive the path
            broken = no_answer(Outcome.RAISED, f"the path cannot be driven: {error}")
            return judged(self.spec, question, broken, self._allowed, self.method)

    def _new_files(self) -> tuple[str, ...]:
        """Files that have appeared in the worker's folder since the last question."""
        folder = self._source.folder
        if folder is None:
            return ()
        now = {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}
        new, self._files = now - self._files, now
        return tuple(sorted(new))


# how a question ended, best first
ENDINGS = ("shortest", "right that there is none", "longer", "none", "missing", "unanswered")
_BY_VERDICT = {
    Verdict.OPTIMAL: "shortest",
    Verdict.NONE_EXISTS: "right that there is none",
    Verdict.LONGER: "longer",
    Verdict.MISSES: "missing",
}


def _ending(answer: Answer) -> str:
    if answer.outcome is not Outcome.RETURNED:
        return "unanswered"
    if answer.reference is None and answer.claim not in _SUCCESS:
        return "right that there is none"
    return _BY_VERDICT.get(answer.verdict, "none")


_SUCCESS = (Claim.OPTIMAL, Claim.LOCAL, Claim.FEASIBLE)
