"""Questions put to one solver, and its judged answers.

The solver runs in a process of its own or in this one.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path as FilePath
from tempfile import mkdtemp
from time import monotonic
from typing import Any, NamedTuple

from dubins_study.asking.attempt import Answer, judged
from dubins_study.conformance.observer import MEMORY_BYTES, TEMPORARY, Observation, Observer
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.isolation.messages import decode_reply, encode_question
from dubins_study.experiments.isolation.worker_process import Allowance, Ended, WorkerProcess
from dubins_study.solvers.protocol import Method, Question
from dubins_study.solvers.registry import SolverError
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import PROFILES
from dubins_study.study.words import Claim, Outcome, Verdict

# Seconds that a plug-in may take to load, and its first question beyond the limit: it loads the
# libraries that later questions find loaded.
LOAD_LIMIT_S = 60.0
WARM_UP_S = 10.0
# Seconds beyond the limit after which a question is ended: more than the second in which a solver
# that keeps its limit returns.
GRACE_S = 1.5
# Questions in a row that may end in a timeout before no more are asked.
MAX_TIMEOUTS = 3
UNANSWERED = "unanswered"


class LoadError(DubinsStudyError):
    """The solver cannot be loaded.

    The solver's code raised, crashed or hung. `frames` is the traceback as text, without the frames
    of this package; it is empty if nothing was raised.
    """

    def __init__(self, message: str, frames: str = ""):
        super().__init__(message)
        self.frames = frames


class UnfinishedError(DubinsStudyError):
    """No more questions are asked; the message says why."""


class NotApplicableError(DubinsStudyError):
    """A check does not apply; the message says why."""


class Worker:
    """The solver in a process of its own.

    The process runs in an empty folder.
    """

    def __init__(self, spec: str, profile: str):
        self.folder = FilePath(mkdtemp(prefix="check-solver-"))
        (self.folder / TEMPORARY).mkdir()
        self._arguments = [spec, profile, str(self.folder)]
        self._process: WorkerProcess | None = None
        self._extra_s = WARM_UP_S
        try:
            self._load()
        except BaseException:
            self.close()
            raise

    def ask(self, question: Question, limit: float) -> Observation:
        """Ask in the worker's process.

        The result is like that of `Observer.ask`, with what was printed. If the process ends
        meanwhile, the reply says so, and the next question starts a new process.
        """
        process = self._load()
        task = ["ask", encode_question(question), limit]
        event = process.request(task, Allowance(limit, margin_s=GRACE_S + self._extra_s))
        self._extra_s = 0.0  # only the first question of a process has more time
        output = process.last_output()
        if isinstance(event, Ended):
            return Observation(event.reply, output=output)
        reply, text, changes, loaded = event.value
        return Observation(decode_reply(reply), text, tuple(changes), loaded, output)

    def _load(self) -> WorkerProcess:
        """The process, which has loaded the solver.

        If there is none, a new one is started, and `declared` is set to its declaration.
        """
        if self._process is not None and not self._process.closed:
            return self._process
        self._process = WorkerProcess(
            "dubins_study.conformance.observer:serve", self._arguments, MEMORY_BYTES
        )
        allowance = Allowance(LOAD_LIMIT_S, activity="loading the solver")
        event = self._process.request(["load"], allowance)
        if isinstance(event, Ended):
            raise LoadError(f"while it was loaded, {event.reply.solution.message}")
        kind, value, *frames = event.value  # an answer to "load", as in `observer.serve`
        if kind == "loaded":
            self.declared = value
            return self._process
        self.restart()
        if kind == "refused":
            raise SolverError(value)
        raise LoadError(value, *frames)

    def restart(self) -> None:
        """End the process; the next question starts another."""
        if self._process is not None:
            self._process.close()
            self._extra_s = WARM_UP_S

    def close(self) -> None:
        """End the process and remove its folder."""
        self.restart()
        shutil.rmtree(self.folder, ignore_errors=True)


class Seen(NamedTuple):
    """A judged answer, with what the solver did meanwhile.

    `files` are new in the folder of the worker; `seconds` passed until the answer was here, and
    `limit` (s) was the question's.
    """

    answer: Answer
    question: Question
    observed: Observation
    files: tuple[str, ...]
    seconds: float
    limit: float


class Interview:
    """Questions to one solver and its judged answers.

    Checks share the answers: a question that was asked before is not asked again unless a check
    wants that.

    `limit` and `total_limit` are seconds for each question and for all; `seen` has every answer so
    far, in the order of asking.
    """

    def __init__(
        self, spec: str, source: Observer | Worker, profile: str, limit: float, total_limit: float
    ):
        self.spec = spec
        self.declared = source.declared
        self.limit = limit
        self.source = source
        self.profile = profile
        self.tolerances = PROFILES[profile]
        self.seen: list[Seen] = []
        self._method = Method(*self.declared["method"])
        self._total_limit = total_limit
        self._end = monotonic() + total_limit
        self._timeouts = 0
        self._answers: dict[tuple[Any, ...], Seen] = {}
        self._files: set[str] = set()

    def counts(self) -> dict[str, int]:
        """Number of answers with each verdict.

        Answers without a verdict count as `unanswered`.
        """
        answers = [seen.answer for seen in self.seen]
        verdicts = [answer.verdict for answer in answers if answer.outcome is Outcome.RETURNED]
        counts = {str(verdict): verdicts.count(verdict) for verdict in Verdict}
        return counts | {UNANSWERED: len(answers) - len(verdicts)}

    def worst_gap(self) -> float | None:
        """The largest gap of paths that are judged longer.

        None if no path is longer than the shortest.
        """
        answers = [seen.answer for seen in self.seen if seen.answer.path is not None]
        gaps = [answer.gap or 0.0 for answer in answers if answer.verdict is Verdict.LONGER]
        return max(gaps, default=None)

    def claimed(self) -> int:
        """Number of answers that claim something.

        Such an answer claims a path, or that there is none.
        """
        nothing = (Claim.FAILED, Claim.NONE, Claim.LIMIT)
        return sum(seen.answer.claim not in nothing for seen in self.seen)

    def answers(self, branch: str) -> bool:
        """Whether the solver declares a branch."""
        return branch in self.declared["branches"]

    def taken(self, scenarios: Mapping[str, Scenario]) -> dict[str, Scenario]:
        """Those of the scenarios that the solver takes.

        A scenario is left out if it needs what the solver does not declare in `takes`.
        """
        takes = set(self.declared["takes"])
        return {
            name: scenario
            for name, scenario in scenarios.items()
            if takes.issuperset(scenario.needs)
        }

    def ask(self, question: Question, *, again: bool = False, limit: float | None = None) -> Seen:
        """The judged answer to a question.

        An earlier answer to the same question is returned, unless `again` is set or the question
        has an initial guess. `limit` (s) replaces the usual one. UnfinishedError is raised if the
        time for all questions is over, or too many in a row had no answer in time.
        """
        key = (question.scenario, question.branch, question.repeat, limit)
        cold = question.initial_guess is None  # a guess is no part of the key
        if cold and not again and key in self._answers:
            return self._answers[key]
        if monotonic() > self._end:
            raise UnfinishedError(
                f"the {self._total_limit:g} s for all questions are over; "
                "raise --total-time-limit (in Python: total_time_limit)"
            )
        if self._timeouts >= MAX_TIMEOUTS:
            raise UnfinishedError(f"{MAX_TIMEOUTS} questions in a row were not answered in time")
        if limit is None:
            limit = self.limit
        began = monotonic()
        observed = self.source.ask(question, limit)
        answer = judged(self.spec, question, observed.reply, self.tolerances, self._method)
        files = self._new_files()
        seconds = monotonic() - began
        seen = Seen(answer, question, observed, files, seconds=seconds, limit=limit)
        self._timeouts += 1
        if answer.outcome is not Outcome.TIMEOUT:
            self._timeouts = 0
        self.seen.append(seen)
        if cold:
            self._answers.setdefault(key, seen)
        return seen

    def _new_files(self) -> tuple[str, ...]:
        """New files in the worker's folder.

        They are new since the question before. Files in the folder `TEMPORARY` are left out: it is
        removed with the worker's folder.
        """
        folder = self.source.folder
        if folder is None:
            return ()
        now = {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}
        new = [file for file in sorted(now - self._files) if not file.startswith(TEMPORARY)]
        self._files = now
        return tuple(new)
