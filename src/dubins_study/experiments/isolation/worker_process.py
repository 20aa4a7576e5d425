"""A worker process from its owner's side: tasks go in, answers come back, limits end it.

A worker answers its tasks in order. Its current task is therefore the first one that it has not
answered. The task began when the worker sent the answer before, or when it woke up for the task.
"""

from __future__ import annotations

import os
import select
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from time import monotonic, process_time
from typing import Any, NamedTuple, Self, TypeVar

import psutil

from dubins_study.experiments.isolation.fork_server import exit_status, fork
from dubins_study.experiments.isolation.messages import MessageError
from dubins_study.solvers.reply import Reply, no_answer
from dubins_study.study.rows.schema import Times
from dubins_study.study.words import Outcome

# Seconds between two checks of the limits. The memory of a worker's children is read at every tenth
# check only: listing them takes milliseconds if many processes run.
POLL_INTERVAL_S, _CHECKS_PER_CHILDREN_CHECK = 0.02, 10
# Seconds within which an idle worker must begin its next task.
_STALL_S = 10.0
# A pause between two checks longer than this means that the whole process was suspended.
_SUSPENDED_S = 1.0
# Length of the last output that is kept, in bytes, and that a message shows, in characters.
_OUTPUT_BYTES, _OUTPUT_CHARS = 400, 200
_READ_BYTES = 2**20
# Reads that empty the output pipe of a process that has ended.
_MAX_READS = 4
_GIB = 2**30


class Allowance(NamedTuple):
    """The seconds that a task may take, and a margin beyond them for what is no part of the limit.

    `activity` says what the worker does where the limit is ours; it is empty for a caller's limit.
    """

    limit_s: float
    margin_s: float = 0.0
    activity: str = ""


STARTING = Allowance(60.0, activity="starting a worker")


class Task(NamedTuple):
    """A task that a worker has received, with any object of the caller's as `tag`."""

    number: int  # from 0, which is the start of the process
    allowance: Allowance
    decode: Callable[[Any], Any]  # makes a value of what the worker answers; may raise anything
    tag: Any = None
    expected_s: float = 0.0


class Answer(NamedTuple):
    """A worker's answer to a task."""

    task: Task
    value: Any
    seconds: float  # that the task took, by time stamps of the worker
    waited_s: float  # from the beginning of the task until its answer was read
    changed: bool  # whether the task changed the process; the worker then answers no more


class Ended(NamedTuple):
    """The end of a worker: the reply to the task that it was at, if it had begun one."""

    reply: Reply
    task: Task | None


class WorkerProcess:
    """A process that answers tasks (see `worker.answer_tasks`) until the `with` block ends.

    Attributes:
        pending: the tasks that it has received but not answered, in order.
        expected_s: how long its pending tasks are expected to take.
        closed: whether the process is gone.
    """

    def __init__(self, function: str, arguments: list[Any], memory_bytes: int):
        self._process = fork(function, arguments)
        self._memory_bytes = memory_bytes
        self.pending = deque([Task(0, STARTING, _nothing)])
        self.expected_s, self.closed = 0.0, False
        self._tasks = 1
        # Whether the current task has begun, and since when it runs, or waits for the worker.
        self._begun, self._since_s = True, monotonic()
        # The last moment at which no answer was waiting to be read.
        self._silent_s = self._since_s
        # The earliest moment at which the current task may have begun, whatever pauses there were.
        self._earliest_s = self._since_s
        self._output = b""
        self._open = {self._process.channel.line.fileno(), self._process.output}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def put(
        self,
        message: list[Any],
        allowance: Allowance,
        decode: Callable[[Any], Any],
        tag: Any = None,
        expected_s: float = 0.0,
    ) -> None:
        """Add a task; `register` sends it."""
        if not self.pending:
            self._begun, self._since_s, self.expected_s = False, monotonic(), 0.0
            self._earliest_s = self._since_s
        self.pending.append(Task(self._tasks, allowance, decode, tag, expected_s))
        self._process.channel.put([self._tasks, *message])
        self.expected_s += expected_s
        self._tasks += 1

    def request(
        self, message: list[Any], allowance: Allowance, decode: Callable[[Any], Any]
    ) -> Answer | Ended:
        """Put one task and wait for its answer, or for the end of the worker."""
        self._read_output()
        self._output = b""
        self.put(message, allowance, decode)
        task, watch = self.pending[-1], Watch()
        while True:
            for _, event in watch.wait([self], POLL_INTERVAL_S):
                if isinstance(event, Ended) or event.task is task:
                    return event

    def register(self, poll: select.poll) -> None:
        """Send as much as the socket takes, and add the worker's descriptors to a poll."""
        sent = True
        with suppress(OSError):  # the worker has ended; its exit pipe shows this
            sent = self._process.channel.flush()
        poll.register(self._process.exit_pipe, select.POLLIN)
        for source in self._open:
            poll.register(source, select.POLLIN)
        if not sent:  # the rest of a long message is sent once the worker has read more
            poll.register(self._process.channel.line, select.POLLIN | select.POLLOUT)

    def events(self, ready: set[int], polled_s: float) -> Iterator[Answer | Ended]:
        """What the worker has sent, and its end, by a poll that began at `polled_s`."""
        if self._process.output in ready:
            self._read_output()
        try:
            if self._process.channel.line.fileno() in ready:
                yield from self._answers()
            else:
                self._silent_s = polled_s
        except MessageError as error:
            yield from self.end(no_answer(Outcome.CRASHED, f"stopped: its worker sent {error}"))
        if not self.closed and self._process.exit_pipe in ready:
            yield from self.end()

    def _answers(self) -> Iterator[Answer]:
        """The answers that have arrived."""
        try:
            for message in self._process.channel.received():
                if message[0] == "begun":
                    self._begun, self._since_s = True, self._moment(message[1])
                    continue
                yield self._answer(message)
                if self.closed:
                    return
        except (EOFError, OSError):  # the worker closed its end: it has ended, or its limit will
            self._open.discard(self._process.channel.line.fileno())

    def _answer(self, message: list[Any]) -> Answer:
        try:
            number, sent_s, value, changed = message
            task = self.pending[0]
            if number != task.number:
                raise ValueError(f"task {number} was not to be answered")
            ended_s, decoded = self._moment(sent_s), task.decode(value)
        except Exception as error:  # a worker may send anything
            raise MessageError(f"an answer that cannot be read: {error}") from None
        began_s, self._since_s = self._since_s, ended_s
        waited_s = monotonic() - self._earliest_s
        self._earliest_s = min(max(self._earliest_s, sent_s), ended_s)
        self.pending.popleft()
        self.expected_s -= task.expected_s
        self._begun = bool(self.pending)
        return Answer(task, decoded, ended_s - began_s, waited_s, bool(changed))

    def _moment(self, stamp_s: float) -> float:
        """A time stamp of the worker's clock, within what its owner has seen itself."""
        return min(max(self._since_s, self._silent_s, stamp_s), monotonic())

    def restart_clock(self) -> None:
        """Give the current task its whole time again."""
        self._since_s = self._silent_s = monotonic()

    def check_limits(self, *, with_children: bool) -> Iterator[Answer | Ended]:
        """End the worker if it breaks the limit of time or of memory."""
        seconds = monotonic() - self._since_s
        if self.pending:
            limit_s, margin_s, activity = self.pending[0].allowance
            if not self._begun:
                limit_s, margin_s, activity = _STALL_S, 0.0, "waiting for it to begin"
            if seconds > limit_s + margin_s:
                message = f"stopped after {seconds:.2f} s; the limit is {limit_s:g} s"
                if activity:
                    message = f"stopped after {seconds:.0f} s of {activity}"
                yield from self.end(no_answer(Outcome.TIMEOUT, message, Times(wall_s=seconds)))
                return
        limit = self._memory_bytes
        used = _used_bytes(self._process.pid, limit, with_children=with_children)
        if used > limit:
            message = f"stopped holding {used / _GIB:.2f} GiB; the limit is {limit / _GIB:g} GiB"
            yield from self.end(no_answer(Outcome.OUT_OF_MEMORY, message, Times(wall_s=seconds)))

    def end(self, reply: Reply | None = None) -> Iterator[Answer | Ended]:
        """Kill the worker; yield the answers that it still gave, and its end.

        `reply` is that to its current task; None if the worker has ended by itself.
        """
        condemned = self._current()
        self._process.kill()
        crash_reply = self._crash_reply()
        with suppress(MessageError):
            yield from self._answers()
        task = self._current()
        if reply is not None and task is not condemned:
            task = None  # it answered in the last moment: the next task has broken no limit
        self.close()
        yield Ended(reply or crash_reply, task)

    def _current(self) -> Task | None:
        """The task that the worker is at, or was at when it ended."""
        return self.pending[0] if self.pending and self._begun else None

    def _crash_reply(self) -> Reply:
        """The reply to the task of a worker that has ended: its exit status and last output."""
        code = self._process.exit_code()
        status, message = exit_status(-signal.SIGKILL if code is None else code)
        for _ in range(_MAX_READS):
            self._read_output()
        output = self.last_output()
        if output:
            message = f"{message}; its last output: {output}"
        # C++ ends a process in this way if it cannot allocate memory.
        starved = code == -signal.SIGABRT and "bad_alloc" in output
        outcome = Outcome.OUT_OF_MEMORY if starved else Outcome.CRASHED
        return no_answer(outcome, message, status=status)

    def last_output(self) -> str:
        """The end of what the worker has printed."""
        if not self.closed:
            self._read_output()
        return " ".join(self._output.decode("utf-8", "replace").split())[-_OUTPUT_CHARS:]

    def _read_output(self) -> None:
        with suppress(BlockingIOError):
            data = os.read(self._process.output, _READ_BYTES)
            self._output = (self._output + data)[-_OUTPUT_BYTES:]
            if not data:
                self._open.discard(self._process.output)

    def kill(self) -> None:
        """Kill the process; may be called from any thread."""
        self._process.kill()

    def close(self) -> None:
        """Kill the process and close its pipes."""
        if not self.closed:
            self.closed = True
            self._process.close()


_AnyWorker = TypeVar("_AnyWorker", bound=WorkerProcess)


class Watch:
    """Waits for the answers and ends of workers, and checks their limits every 20 ms."""

    def __init__(self) -> None:
        self._checks = 0
        self.begin()

    def begin(self) -> None:
        """Restart the measurement of pauses: time before this call does not count as suspended."""
        self._last_check_s, self._cpu_s = monotonic(), process_time()

    def wait(
        self, workers: Sequence[_AnyWorker], timeout_s: float
    ) -> Iterator[tuple[_AnyWorker, Answer | Ended]]:
        """Wait until something arrives or `timeout_s` is over; yield all that has happened."""
        poll = select.poll()
        for worker in workers:
            worker.register(poll)
        polled_s = monotonic()
        ready = {descriptor for descriptor, _ in poll.poll(1000 * timeout_s)}
        now_s = monotonic()
        due = now_s - self._last_check_s >= POLL_INTERVAL_S
        if due:
            self._checks += 1
            cpu_s, pause_s = process_time() - self._cpu_s, now_s - self._last_check_s
            self.begin()
            # A long pause with little CPU time: the whole run was suspended, no worker could solve.
            # With much CPU time, this process judged or wrote rows while the workers were solving.
            if pause_s > _SUSPENDED_S and cpu_s < pause_s / 2:
                for worker in workers:
                    worker.restart_clock()
        with_children = self._checks % _CHECKS_PER_CHILDREN_CHECK == 0
        for worker in workers:
            for event in worker.events(ready, polled_s):
                yield worker, event
            if due and not worker.closed:
                for event in worker.check_limits(with_children=with_children):
                    yield worker, event


def _nothing(value: Any) -> None:
    """Decode an answer that says nothing."""


def _used_bytes(pid: int, limit: float, *, with_children: bool) -> int:
    """Bytes of memory that a process uses, optionally with its descendants; 0 if it has ended.

    If the sum is above the limit, memory that several processes share is counted only once (Linux).
    This count is slower.
    """
    try:
        process = psutil.Process(pid)
        family = [process, *process.children(recursive=True)] if with_children else [process]
    except psutil.Error:
        return 0
    used = _sum_bytes(family, "memory_info", "rss")
    if with_children and used > limit:
        used = _sum_bytes(family, "memory_full_info", "pss")
    return used


def _sum_bytes(family: list[psutil.Process], method: str, column: str) -> int:
    total = 0
    for process in family:
        with suppress(psutil.Error):
            memory = getattr(process, method)()
            total += getattr(memory, column, memory.rss)
    return total
