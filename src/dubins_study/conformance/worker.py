"""Where a solver is asked: in a process that is replaced when it ends, or in this one."""

from __future__ import annotations

import os
import select
import shutil
from contextlib import suppress
from pathlib import Path as FilePath
from tempfile import mkdtemp
from time import monotonic
from typing import Any, Protocol

from dubins_study.conformance.loading import declaration
from dubins_study.conformance.observer import TEMPORARY, Observation, Observer
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.isolation.fork_server import ForkedProcess, exit_status, fork
from dubins_study.experiments.isolation.messages import (
    MessageError,
    decode_reply,
    encode_question,
)
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError
from dubins_study.solvers.reply import Reply, no_answer
from dubins_study.study.rows.schema import Times
from dubins_study.study.words import Outcome

_SERVE = "dubins_study.conformance.observer:serve"
# Seconds that a plug-in may take to load, and its first question beyond the limit: it loads the
# libraries that later questions find loaded.
LOAD_LIMIT_S, WARM_UP_S = 60.0, 10.0
# Seconds beyond the limit after which a question is ended: more than the second in which a solver
# that keeps its limit returns.
GRACE_S = 1.5
_MEMORY_BYTES = 4 * 2**30
_OUTPUT_CHARS = 400
_READ_BYTES = 2**16


class LoadError(DubinsStudyError):
    """The solver cannot be loaded: its own code raised, crashed or hung.

    Args:
        message: what happened.
        frames: the solver's own frames of the exception; may be empty.
    """

    def __init__(self, message: str, frames: str = ""):
        super().__init__(message)
        self.frames = frames


class Source(Protocol):
    """Where observations come from: a worker process, or this process."""

    @property
    def declared(self) -> dict[str, Any]: ...

    @property
    def folder(self) -> FilePath | None: ...

    def ask(self, question: Question, limit: float) -> Observation: ...

    def ask_frame(self, questions: list[Question], limit: float) -> list[Observation]: ...

    def restart(self) -> None: ...

    def close(self) -> None: ...


class InProcess:
    """The solver in the caller's process: for a debugger, and for solvers that are known."""

    folder = None

    def __init__(self, spec: str, profile: str):
        self._observer = Observer(spec, profile, _MEMORY_BYTES, interruptible=True)
        self.declared = declaration(self._observer.solver, spec)

    def ask(self, question: Question, limit: float) -> Observation:
        return self._observer.ask(question, limit)

    def ask_frame(self, questions: list[Question], limit: float) -> list[Observation]:
        return self._observer.ask_frame(questions)

    def restart(self) -> None:
        """There is only one process to ask in."""

    def close(self) -> None:
        """Nothing to end."""


class Worker:
    """The solver in a process of its own, in an empty folder.

    Raises:
        SolverError: if the spec is not a valid one.
        LoadError: if the solver's own code raises, crashes or hangs while it is loaded.
        ForkServerError: if no process starts.
    """

    def __init__(self, spec: str, profile: str):
        self._arguments = [spec, profile]
        self.folder = FilePath(mkdtemp(prefix="check-solver-"))
        self._process: ForkedProcess | None = None
        (self.folder / TEMPORARY).mkdir()
        self._cold = self._may_be_cold = True
        try:
            self.declared = self._start()
        except BaseException:
            self.close()
            raise

    def ask(self, question: Question, limit: float) -> Observation:
        """The reply, or what happened instead; a process that was ended is replaced later."""
        return self._request([question], limit, as_frame=False)[0]

    def ask_frame(self, questions: list[Question], limit: float) -> list[Observation]:
        """The replies to questions that are put as one frame."""
        return self._request(questions, limit, as_frame=True)

    def _request(
        self, questions: list[Question], limit: float, *, as_frame: bool
    ) -> list[Observation]:
        if self._process is None:
            try:
                self._start()
            except (LoadError, SolverError) as error:  # it did load before
                crash = no_answer(Outcome.CRASHED, f"loaded once more, it fails: {error}")
                return [Observation(crash)] * len(questions)
        assert self._process is not None
        began = monotonic()
        # what answers whole frames may be compiled for them first
        warm_up = LOAD_LIMIT_S if as_frame else WARM_UP_S if self._cold else 0.0
        allowed = limit + GRACE_S + warm_up
        self._read_output(self._process)
        encoded = [encode_question(question) for question in questions]
        self._process.channel.put([encoded, limit, as_frame])
        with suppress(OSError):  # it has ended; what it sends shows that
            self._process.channel.flush()
        message, output = self._receive(self._process, allowed)
        if message is None:
            self._may_be_cold = False  # what did not answer once is not waited for longer again
            ended = self._ended(monotonic() - began, limit, warm_up, output)
            return [Observation(ended, output=output)] * len(questions)
        self._cold, self._may_be_cold = False, True
        try:
            return [
                Observation(decode_reply(reply).reply, text, tuple(changes), loaded, output)
                for reply, text, changes, loaded in message[1]
            ]
        except Exception as error:  # a solver may write to every descriptor of its process
            self.restart()
            crash = no_answer(Outcome.CRASHED, f"its worker sent an unreadable reply: {error}")
            return [Observation(crash, output=output)] * len(questions)

    def restart(self) -> None:
        """End the process; the next question starts another."""
        if self._process is not None:
            self._process.close()
        self._process, self._cold = None, self._may_be_cold

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

    def _ended(self, seconds: float, limit: float, warm_up: float, output: str) -> Reply:
        """The reply for a process that has ended, or that is ended now."""
        assert self._process is not None
        code = self._process.exit_code(0.0)
        self.restart()
        if code is None:
            message = f"ended after {seconds:.1f} s; the limit is {limit:g} s"
            if warm_up:
                message += f", and {warm_up:g} s more for libraries to load"
            return no_answer(Outcome.TIMEOUT, message, Times(wall_s=seconds))
        status, message = exit_status(code)
        said = f"; its last output: {output}" if output else ""
        return no_answer(Outcome.CRASHED, message + said, Times(wall_s=seconds), status)

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
