"""A worker process from the pool's side: send jobs to it, receive its answers."""

from __future__ import annotations

import os
import select
import signal
from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.fork_server import exit_status, fork
from dubins_study.experiments.isolation.job_queue import Job
from dubins_study.experiments.isolation.messages import (
    MessageError,
    WorkerReply,
    decode_reply,
    encode_question,
)
from dubins_study.experiments.isolation.worker import PROBE
from dubins_study.experiments.isolation.worker_status import Phase, WorkerStatus, shared_memory
from dubins_study.solvers.reply import Reply, no_answer
from dubins_study.study.words import Outcome

_SERVE = "dubins_study.experiments.isolation.worker:serve"
# Length of the last output that is kept, in bytes, and that a message shows, in characters.
_OUTPUT_BYTES, _OUTPUT_CHARS = 400, 200
_READ_BYTES = 2**20
# Reads that empty the output pipe of a process that has ended.
_MAX_READS = 4
# Job numbers are never used twice, so that a late reply cannot be taken for another job's reply.
_job_numbers = count(PROBE + 1)


class PendingJob(NamedTuple):
    """A job that a worker has received, and whether the worker warms up a new solver before it."""

    job: Job
    warm_up: bool


class Answer(NamedTuple):
    """A worker's answer to the job with a number."""

    number: int
    value: WorkerReply | float  # a duration (s) if the job was a calibration probe
    changed: bool  # whether the solve changed the process; the worker then answers no more


class WorkerProcess:
    """Starts a worker process and exchanges messages with it.

    Attributes:
        group: the group whose jobs it solves, see `worker_group`.
        pending: number -> job, for the jobs that it has received but not answered, in order.
        quick: whether its last job was so short that the worker gets several jobs in advance.
    """

    def __init__(self, memory_limit: int, group: str):
        self.group = group
        memory = shared_memory()
        try:
            self.process = fork(_SERVE, [memory_limit], (memory,))
        finally:
            self.status = WorkerStatus(memory)
        self.pending: dict[int, PendingJob] = {}
        self.quick = False
        self._output = b""
        self._open = {self.process.channel.line.fileno(), self.process.output}

    def put(self, job: Job, time_limit: float, warm_up: bool) -> None:
        """Add a job for the worker; `register` sends it."""
        number = next(_job_numbers)
        self.pending[number] = PendingJob(job, warm_up)
        question = encode_question(job.question)
        self.process.channel.put([number, *job.solver_key, question, time_limit, warm_up])

    def put_probe(self) -> None:
        """Request a calibration probe after the worker's pending jobs."""
        self.process.channel.put([PROBE])

    def withdraw(self) -> list[Job]:
        """Take back the jobs that the worker has not begun.

        A job that the worker begins at this moment is solved twice; the second reply counts.
        """
        current = self.current_number()
        unbegun = [number for number in self.pending if number != current]
        if unbegun:
            self.status.withdrawn = unbegun[-1] + 1
        return [self.pending.pop(number).job for number in unbegun]

    def register(self, poll: select.poll) -> None:
        """Send as much as the socket takes, and add the worker's descriptors to a poll."""
        sent = True
        with suppress(OSError):  # the worker has ended; its exit pipe shows this
            sent = self.process.channel.flush()
        poll.register(self.process.exit_pipe, select.POLLIN)
        for source in self._open:
            poll.register(source, select.POLLIN)
        if not sent:  # the rest of a long message is sent once the worker has read more
            poll.register(self.process.channel.line, select.POLLIN | select.POLLOUT)

    def answers(self, ready: set[int]) -> Iterator[Answer]:
        """The answers that have arrived; also reads the worker's output.

        Args:
            ready: the descriptors that a poll has found readable.

        Raises:
            MessageError: if the worker sent something that is not an answer.
        """
        channel, line = self.process.channel, self.process.channel.line.fileno()
        if self.process.output in ready:
            self._read_output()
        if line not in ready:
            return
        try:
            for message in channel.received():
                yield _answer(message)
        except (EOFError, OSError):  # the worker closed its end: it has ended, or the monitor acts
            self._open.discard(line)

    def _read_output(self) -> None:
        """Read what the worker printed, and keep the last bytes."""
        with suppress(BlockingIOError):
            data = os.read(self.process.output, _READ_BYTES)
            self._output = (self._output + data)[-_OUTPUT_BYTES:]
            if not data:
                self._open.discard(self.process.output)

    def crash_reply(self) -> Reply:
        """The reply to the job of a worker that has ended: its exit status and its last output."""
        code = self.process.exit_code()
        status, message = exit_status(-signal.SIGKILL if code is None else code)
        for _ in range(_MAX_READS):
            self._read_output()
        output = " ".join(self._output.decode("utf-8", "replace").split())[-_OUTPUT_CHARS:]
        if output:
            message = f"{message}; its last output: {output}"
        # C++ ends a process in this way if it cannot allocate memory.
        starved = code == -signal.SIGABRT and "bad_alloc" in output
        outcome = Outcome.OUT_OF_MEMORY if starved else Outcome.CRASHED
        return no_answer(outcome, message, status=status)

    def current_number(self) -> int | None:
        """The number of the job that the worker is solving, or was solving when it ended."""
        reading = self.status.read()
        if reading.phase is Phase.LOST:  # a worker solves its jobs in order
            return next(iter(self.pending), None)
        # An idle worker has a current job if its reply has not arrived yet.
        return reading.job if reading.job in self.pending else None


def _answer(message: Any) -> Answer:
    try:
        number, value, changed = message
        if number == PROBE:
            return Answer(PROBE, float(value), False)
        return Answer(int(number), decode_reply(value), bool(changed))
    except Exception as error:  # a worker may send anything
        raise MessageError(f"an answer that cannot be read: {error}") from None
