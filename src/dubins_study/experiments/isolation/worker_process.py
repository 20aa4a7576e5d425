"""One worker as its pool sees it: the jobs that it has been given, and what comes back."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.fork_server import ForkedProcess, fork
from dubins_study.experiments.isolation.job_clock import JobClock, Phase
from dubins_study.experiments.isolation.messages import (
    MessageError,
    WorkerReply,
    decode_reply,
    encode_question,
)
from dubins_study.experiments.isolation.worker import WorkerJob
from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.reply import no_answer

_NO_REPLY = WorkerReply(no_answer(Outcome.RAISED, ""))
_SERVE = "dubins_study.experiments.isolation.worker:serve"
_OUTPUT_BYTES, _OUTPUT_CHARS = 400, 200
_READ_BYTES = 2**20
# what a process that has ended may have left in the pipe
_MAX_READS = 4
_EXIT_WAIT_S = 2.0


class Answer(NamedTuple):
    """A worker's answer to a job, or to the calibration probe.

    Args:
        job: its number; None for the probe.
        reply: to the job.
        changes: what the solve has changed in the process; such a worker answers no more.
        probe_s: seconds that the calibration's piece of work took.
    """

    job: int | None
    reply: WorkerReply
    changes: list[str]
    probe_s: float = 0.0


class WorkerProcess:
    """A worker process, started by this.

    Attributes:
        place: among the pool's workers.
        group: of the jobs that it may be given.
        pending: jobs that it has been given and has not answered, by their numbers, in order.
        quick: whether its last job took so little time that more are put to it in advance.
    """

    def __init__(self, memory_limit: int, place: int, group: str):
        self.place, self.group = place, group
        self.clock = JobClock()
        try:
            self.process: ForkedProcess = fork(_SERVE, [memory_limit], (self.clock.descriptor,))
        finally:
            self.clock.close_descriptor()
        self.pending: dict[int, WorkerJob] = {}
        self.quick = False
        self._output = b""
        self._exit_code: int | None = None

    @property
    def pid(self) -> int:
        return self.process.pid

    def put(self, job: WorkerJob) -> None:
        """Give the worker a job, which `flush` sends."""
        self.pending[job.number] = job
        question, arrays = encode_question(job.question)
        self.process.channel.put([*job[:3], question, *job[4:]], arrays)

    def put_probe(self) -> None:
        """Have the worker time the calibration's piece of work after its jobs."""
        self.process.channel.put("probe")

    def flush(self) -> bool:
        """Send what the worker has been given; whether all of it has been sent."""
        with suppress(OSError):  # the worker has ended, which its status tells
            return self.process.channel.flush()
        return True

    def withdraw(self) -> list[int]:
        """Take back the jobs that the worker has not begun; their numbers.

        A job that it begins at this very moment is solved twice; the second reply counts.
        """
        current = self.current_job()
        unbegun = [number for number in self.pending if current is None or number != current.number]
        if unbegun:
            self.clock.withdraw(unbegun[-1] + 1)
        for number in unbegun:
            del self.pending[number]
        return unbegun

    def answers(self) -> Iterator[Answer]:
        """The answers that have arrived; the channel must be readable.

        Raises:
            EOFError: if the worker has closed the channel.
            MessageError: if what it sent is no answer.
        """
        for value, arrays in self.process.channel.received():
            try:
                yield _answer(value, arrays)
            except Exception as error:  # a worker may send anything
                raise MessageError(f"an answer that cannot be read: {error}") from None

    def read_output(self) -> bool:
        """Read what the worker printed, and keep the end of it; False once there is no more."""
        try:
            data = os.read(self.process.output, _READ_BYTES)
        except BlockingIOError:
            return True
        self._output = (self._output + data)[-_OUTPUT_BYTES:]
        return bool(data)

    def last_output(self) -> str:
        """What a worker that has ended printed last, on one line."""
        for _ in range(_MAX_READS):
            with suppress(OSError):
                self.read_output()
        return " ".join(self._output.decode("utf-8", "replace").split())[-_OUTPUT_CHARS:]

    def exit_code(self) -> int:
        """How the process ended: it is waited for, but not for longer than the kernel may take."""
        if self._exit_code is None:
            ended = self.process.wait(_EXIT_WAIT_S)
            self._exit_code = self.process.exit_code() if ended else -signal.SIGKILL
        return self._exit_code

    def current_job(self) -> WorkerJob | None:
        """The job that the worker is at, or was at when it ended."""
        reading = self.clock.read()
        if reading.phase is Phase.LOST:  # it takes them up in turn
            return next(iter(self.pending.values()), None)
        # the reply of an idle worker may be still on its way
        return self.pending.get(reading.job)


def _answer(value: dict[str, Any], arrays: bytes) -> Answer:
    if "probe_s" in value:
        return Answer(None, _NO_REPLY, [], float(value["probe_s"]))
    changes = [str(name) for name in value["changes"]]
    return Answer(int(value["job"]), decode_reply(value["reply"], arrays), changes)
