"""One worker as its pool sees it: the jobs that it has been given, and what comes back."""

from __future__ import annotations

import os
import select
import signal
from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.fork_server import exit_status, fork
from dubins_study.experiments.isolation.job_clock import JobClock, Phase, shared_memory
from dubins_study.experiments.isolation.job_queue import Job
from dubins_study.experiments.isolation.messages import (
    MessageError,
    WorkerReply,
    decode_reply,
    encode_question,
)
from dubins_study.experiments.isolation.worker import PROBE
from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.reply import Reply, no_answer

_SERVE = "dubins_study.experiments.isolation.worker:serve"
_OUTPUT_BYTES, _OUTPUT_CHARS = 400, 200
_READ_BYTES = 2**20
# what a process that has ended may have left in the pipe
_MAX_READS = 4
# never the same number twice, so that no late reply of a worker passes for another job's
_numbers = count(PROBE + 1)


class PendingJob(NamedTuple):
    """A job that a worker was given, and whether it asks an easy question before a new solver."""

    job: Job
    warm_up: bool


class Answer(NamedTuple):
    """A worker's answer to the job of a number; after a change of its process it gives no more."""

    number: int
    value: WorkerReply | float  # seconds, where the calibration's piece of work was timed
    changed: bool


class WorkerProcess:
    """A worker process, started by this.

    Attributes:
        group: of the jobs that it may be given.
        pending: jobs that it has been given and has not answered, by their numbers, in order.
        quick: whether its last job took so little time that more are put to it in advance.
    """

    def __init__(self, memory_limit: int, group: str):
        self.group = group
        memory = shared_memory()
        try:
            self.process = fork(_SERVE, [memory_limit], (memory,))
        finally:
            self.clock = JobClock(memory)
        self.pending: dict[int, PendingJob] = {}
        self.quick = False
        self._output = b""
        self._open = {self.process.channel.line.fileno(), self.process.output}

    def put(self, job: Job, time_limit: float, warm_up: bool) -> None:
        """Give the worker a job, which `register` sends."""
        number = next(_numbers)
        self.pending[number] = PendingJob(job, warm_up)
        question = encode_question(job.question)
        self.process.channel.put([number, *job.solver_key, question, time_limit, warm_up])

    def put_probe(self) -> None:
        """Have the worker time the calibration's piece of work after its jobs."""
        self.process.channel.put([PROBE])

    def withdraw(self) -> list[Job]:
        """Take back the jobs that the worker has not begun.

        A job that it begins at this very moment is solved twice; the second reply counts.
        """
        current = self.current_number()
        unbegun = [number for number in self.pending if number != current]
        if unbegun:
            self.clock.withdrawn = unbegun[-1] + 1
        return [self.pending.pop(number).job for number in unbegun]

    def register(self, poll: select.poll) -> None:
        """Send what can be sent, and have a poll wait for the worker."""
        sent = True
        with suppress(OSError):  # the worker has ended, which its status tells
            sent = self.process.channel.flush()
        poll.register(self.process.status, select.POLLIN)
        for source in self._open:
            poll.register(source, select.POLLIN)
        if not sent:  # the rest of a long message is sent as the worker reads it
            poll.register(self.process.channel.line, select.POLLIN | select.POLLOUT)

    def answers(self, ready: set[int]) -> Iterator[Answer]:
        """The answers that have arrived, once some of the worker's descriptors are ready.

        Raises:
            MessageError: if what the worker sent is no answer.
        """
        channel, line = self.process.channel, self.process.channel.line.fileno()
        if self.process.output in ready:
            self._read_output()
        if line not in ready:
            return
        try:
            for message in channel.received():
                yield _answer(message)
        except (EOFError, OSError):  # what becomes of the worker is told by its end or the monitor
            self._open.discard(line)

    def _read_output(self) -> None:
        """Read what the worker printed, and keep the end of it."""
        with suppress(BlockingIOError):
            data = os.read(self.process.output, _READ_BYTES)
            self._output = (self._output + data)[-_OUTPUT_BYTES:]
            if not data:
                self._open.discard(self.process.output)

    def crash_reply(self) -> Reply:
        """The reply to the job of a worker that has ended: how, and what it printed last."""
        code = self.process.exit_code()
        status, message = exit_status(-signal.SIGKILL if code is None else code)
        for _ in range(_MAX_READS):
            self._read_output()
        output = " ".join(self._output.decode("utf-8", "replace").split())[-_OUTPUT_CHARS:]
        if output:
            message = f"{message}; its last output: {output}"
        # C++ ends a process so that may have no more memory
        starved = code == -signal.SIGABRT and "bad_alloc" in output
        outcome = Outcome.OUT_OF_MEMORY if starved else Outcome.CRASHED
        return no_answer(outcome, message, status=status)

    def current_number(self) -> int | None:
        """The number of the job that the worker is at, or was at when it ended."""
        reading = self.clock.read()
        if reading.phase is Phase.LOST:  # it takes them up in turn
            return next(iter(self.pending), None)
        # the reply of an idle worker may be still on its way
        return reading.job if reading.job in self.pending else None


def _answer(message: Any) -> Answer:
    try:
        number, value, changed = message
        if number == PROBE:
            return Answer(PROBE, float(value), False)
        return Answer(int(number), decode_reply(value), bool(changed))
    except Exception as error:  # a worker may send anything
        raise MessageError(f"an answer that cannot be read: {error}") from None
