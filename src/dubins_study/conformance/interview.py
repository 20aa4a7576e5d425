"""Ask a solver questions in a worker process that is replaced when a question ends it."""

from __future__ import annotations

import os
import select
import shutil
from contextlib import suppress
from pathlib import Path as FilePath
from tempfile import mkdtemp
from time import monotonic
from typing import Any, NamedTuple, Protocol, Self

from dubins_study.conformance.observer import Observation, Observer, declaration
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.isolation.fork_server import ForkedProcess, exit_status, fork
from dubins_study.experiments.isolation.messages import (
    MessageError,
    decode_reply,
    encode_question,
)
from dubins_study.solvers.attempt import Answer, judged
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.protocol import Method, Outcome, Question
from dubins_study.solvers.registry import SolverError
from dubins_study.solvers.reply import Reply, Times, no_answer

_SERVE = "dubins_study.conformance.observer:serve"
# Seconds that a plug-in may take to load, and its first question beyond the limit: it loads the
# libraries that later questions find loaded.
LOAD_LIMIT_S, WARM_UP_S = 60.0, 10.0
# Seconds beyond the limit after which a question is ended: more than the second in which a solver
# that keeps its limit returns.
GRACE_S = 1.5
# Questions in a row that may end in a timeout before no more are asked.
MAX_TIMEOUTS = 3
_MEMORY_BYTES = 4 * 2**30
_OUTPUT_CHARS = 400
_READ_BYTES = 2**16


class UnfinishedError(DubinsStudyError):
    """No more questions are put to the solver; the message says why."""


class LoadError(DubinsStudyError):
    """The solver cannot be loaded: its own code raised, crashed or hung.

    Args:
        message: what happened.
        frames: the solver's own frames of the exception; may be empty.
    """

    def __init__(self, message: str, frames: str = ""):
        super().__init__(message)
        self.frames = frames


class Seen(NamedTuple):
    """A judged answer, and what else was seen while the solver worked on it."""

    answer: Answer
    question: Question
    traceback: str
    changes: tuple[str, ...]
    output: str
    files: tuple[str, ...]
    seconds: float
    first: bool


class Source(Protocol):
    """Where observations come from: a worker process, or this process."""

    declared: dict[str, Any]

    def ask(self, question: Question, limit: float) -> Observation: ...

    def restart(self) -> None: ...

    def close(self) -> None: ...


class InProcess:
    """The solver in the caller's process: for a debugger, and for solvers that are known."""

    def __init__(self, spec: str, profile: str):
        self._observer = Observer(spec, profile, _MEMORY_BYTES)
        self.declared = declaration(self._observer.solver, spec)

    def ask(self, question: Question, limit: float) -> Observation:
        return self._observer.ask(question, limit)

    def restart(self) -> None:
        """There is only one process to ask in."""

    def close(self) -> None:
        """Nothing to end."""


class Worker:
    """The solver in a process of its own, in an empty folder."""

    def __init__(self, spec: str, profile: str):
        self._arguments = [spec, profile]
        self.folder = FilePath(mkdtemp(prefix="check-solver-"))
        self._process: ForkedProcess | None = None
        self._first = True
        try:
            self.declared = self._start()
        except BaseException:
            self.close()
            raise

    def ask(self, question: Question, limit: float) -> Observation:
        """The reply, or what happened instead; a process that was ended is replaced later."""
        if self._process is None:
            self._start()
        assert self._process is not None
        began = monotonic()
        allowed = limit + GRACE_S + (WARM_UP_S if self._first else 0.0)
        self._first = False
        self._read_output(self._process)
        self._process.channel.put([encode_question(question), limit])
        with suppress(OSError):  # it has ended; what it sends shows that
            self._process.channel.flush()
        message, output = self._receive(self._process, allowed)
        if message is None:
            return Observation(self._ended(monotonic() - began, limit, output), output=output)
        try:
            _, reply, traceback, changes = message
            decoded = decode_reply(reply).reply
        except Exception as error:  # a solver may write to every descriptor of its process
            self.restart()
            crash = no_answer(Outcome.CRASHED, f"its worker sent an unreadable reply: {error}")
            return Observation(crash, output=output)
        return Observation(decoded, str(traceback), tuple(map(str, changes)), output)

    def restart(self) -> None:
        """End the process; the next question starts another."""
        if self._process is not None:
            self._process.close()
        self._process, self._first = None, True

    def close(self) -> None:
        self.restart()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _start(self) -> dict[str, Any]:
        self._process = fork(_SERVE, [*self._arguments, str(self.folder), _MEMORY_BYTES])
        message, output = self._receive(self._process, LOAD_LIMIT_S)
        if message is None:
            code = self._process.exit_code(0.0)
            self.restart()
            if code is None:
                raise LoadError(f"loading it takes longer than {LOAD_LIMIT_S:g} s")
            said = f"; its last output: {output}" if output else ""
            raise LoadError(f"while it was loaded, {exit_status(code)[1]}{said}")
        if message[0] == "refused":
            raise SolverError(message[1])
        if message[0] == "broken":
            raise LoadError(message[1], message[2])
        declared: dict[str, Any] = message[1]
        return declared

    def _ended(self, seconds: float, limit: float, output: str) -> Reply:
        """The reply for a process that has ended, or that is ended now."""
        assert self._process is not None
        code = self._process.exit_code(0.0)
        self.restart()
        if code is None:
            message = f"ended after {seconds:.1f} s; the limit is {limit:g} s"
            return no_answer(Outcome.TIMEOUT, message, Times(wall=seconds))
        status, message = exit_status(code)
        said = f"; its last output: {output}" if output else ""
        return no_answer(Outcome.CRASHED, message + said, Times(wall=seconds), status)

    def _receive(self, process: ForkedProcess, timeout_s: float) -> tuple[Any, str]:
        """The next message, or None if none comes in time; and what was printed meanwhile."""
        output, message, end = "", None, monotonic() + timeout_s
        line = process.channel.line.fileno()
        poll = select.poll()
        for descriptor in (line, process.output, process.exit_pipe):
            poll.register(descriptor, select.POLLIN)
        while message is None and (left := end - monotonic()) > 0:
            ready = {descriptor for descriptor, _ in poll.poll(1000 * left)}
            if process.output in ready:
                text = self._read_output(process)
                if not text:
                    poll.unregister(process.output)
                output = (output + text)[-_OUTPUT_CHARS:]
            if line in ready:
                try:
                    message = next(process.channel.received(), None)
                except (EOFError, OSError, MessageError):
                    poll.unregister(line)
            elif process.exit_pipe in ready:
                break
        output += self._read_output(process)
        return message, output[-_OUTPUT_CHARS:].strip()

    @staticmethod
    def _read_output(process: ForkedProcess) -> str:
        with suppress(BlockingIOError):
            return os.read(process.output, _READ_BYTES).decode("utf-8", "replace")
        return ""


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
        self._timeouts, self._fresh = 0, True
        self._answers: dict[tuple[Any, ...], Seen] = {}
        self._files: set[str] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._source.close()

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
                "give more with --total-time-limit"
            )
        if self._timeouts >= MAX_TIMEOUTS:
            raise UnfinishedError(f"{MAX_TIMEOUTS} questions in a row were not answered in time")
        began = monotonic()
        given = self.limit if limit is None else limit
        observation = self._source.ask(question, given)
        seconds = monotonic() - began
        timed_out = observation.reply.outcome is Outcome.TIMEOUT
        self._timeouts = self._timeouts + 1 if timed_out else 0
        answer = self._judged(question, observation.reply)
        seen = Seen(
            answer,
            question,
            *observation[1:],
            files=self._new_files(),
            seconds=seconds,
            first=self._fresh,
        )
        self._fresh = observation.reply.outcome in (Outcome.TIMEOUT, Outcome.CRASHED)
        self.seen.append(seen)
        if question.initial_guess is None:
            self._answers.setdefault(key, seen)
        return seen

    def restart(self) -> None:
        """Ask the next question in a new process."""
        self._source.restart()
        self._fresh = True

    def _judged(self, question: Question, reply: Reply) -> Answer:
        try:
            return judged(self.spec, question, reply, self._allowed, self.method)
        except Exception as error:  # the check cannot drive the path
            broken = no_answer(Outcome.RAISED, f"the path cannot be driven: {error}")
            return judged(self.spec, question, broken, self._allowed, self.method)

    def _new_files(self) -> tuple[str, ...]:
        """Files that have appeared in the worker's folder since the last question."""
        folder = getattr(self._source, "folder", None)
        if folder is None:
            return ()
        now = {str(file.relative_to(folder)) for file in folder.rglob("*")}
        new, self._files = now - self._files, now
        return tuple(sorted(new))
