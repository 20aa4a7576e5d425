"""One worker as its pool sees it: the jobs that it has been given, and what comes back."""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Iterator, Sequence
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

_SERVE = "dubins_study.experiments.isolation.worker:serve"
_OUTPUT_BYTES, _OUTPUT_CHARS = 400, 200
_READ_BYTES = 2**20
# what a process that has ended may have left in the pipe
_MAX_READS = 4
_EXIT_WAIT_S = 2.0


class Answer(NamedTuple):
    """A worker's answer to a batch of jobs, or to the calibration probe.

    Args:
        replies: to the first jobs of the batch, by the jobs' numbers.
        left: jobs of the batch that the worker has not taken up.
        changes: what a solve has changed in the process; such a worker answers no more.
        probe_s: seconds that the calibration's piece of work took.
    """

    replies: dict[int, WorkerReply]
    left: list[int]
    changes: list[str]
    probe_s: float | None = None


class WorkerProcess:
    """A worker process, started by this.

    Attributes:
        group: of the jobs that it may be given.
        pending: jobs that it has been given and has not answered, by their numbers.
        batches: the numbers of the jobs of each message that it has not answered, in order.
        quick: whether its last jobs took so little time that more are put to it in advance.
    """

    def __init__(self, memory_limit: int, group: str):
        self.group = group
        self.clock = JobClock()
        try:
            self.process: ForkedProcess = fork(_SERVE, [memory_limit], (self.clock.descriptor,))
        finally:
            self.clock.close_descriptor()
        self.pending: dict[int, WorkerJob] = {}
        self.batches: deque[list[int]] = deque()
        self.quick = False
        self._output = b""
        self._exit_code: int | None = None

    @property
    def pid(self) -> int:
        return self.process.pid

    def put(self, jobs: Sequence[WorkerJob]) -> bool:
        """Give the worker several jobs in one message; whether all of it has been sent."""
        batch, arrays = [], []
        for job in jobs:
            question, more = encode_question(job.question)
            batch.append([*job[:3], question, *job[4:]])
            arrays += more
            self.pending[job.number] = job
        self.batches.append([job.number for job in jobs])
        return self.process.channel.send(batch, arrays)

    def put_probe(self) -> None:
        """Have the worker time the calibration's piece of work after its jobs."""
        self.process.channel.send("probe")

    def answers(self) -> Iterator[Answer]:
        """The answers that have arrived; the channel must be readable.

        Raises:
            EOFError: if the worker has closed the channel.
            MessageError: if what it sent is no answer.
        """
        for value, arrays in self.process.channel.received():
            try:
                yield self._answer(value, memoryview(arrays))
            except Exception as error:  # a worker may send anything
                raise MessageError(f"an answer that cannot be read: {error}") from None

    def _answer(self, value: dict[str, Any], arrays: memoryview) -> Answer:
        if "probe_s" in value:
            return Answer({}, [], [], float(value["probe_s"]))
        batch, replies = self.batches[0], {}
        for number, encoded in zip(batch, value["replies"], strict=False):
            replies[number], arrays = decode_reply(encoded, arrays)
        self.batches.popleft()
        return Answer(replies, batch[len(replies) :], [str(name) for name in value["changes"]])

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
            if self.process.wait(_EXIT_WAIT_S):
                self._exit_code = self.process.exit_code()
            else:
                self.process.kill()
                self._exit_code = -signal.SIGKILL
        return self._exit_code

    def current_job(self) -> WorkerJob | None:
        """The job that the worker is at, or was at when it ended."""
        reading = self.clock.read()
        if reading.phase is Phase.LOST:  # it takes them up in turn
            return next(iter(self.pending.values()), None)
        # an idle worker may not have sent its last answer yet
        return self.pending.get(reading.job)

    def begun(self) -> set[int]:
        """The numbers of the jobs that the worker is at: a whole batch, or the current job."""
        batch, job = set(self.batches[0] if self.batches else ()), self.current_job()
        # between two jobs of a batch it is at none
        return batch if len(batch) > 1 or (job is not None and job.number in batch) else set()

    def answered_in_batch(self, job: WorkerJob) -> bool:
        """Whether the worker is through with a job whose reply was to travel with others."""
        together = any(job.number in batch for batch in self.batches if len(batch) > 1)
        return together and self.clock.read().phase is Phase.IDLE
