"""A worker process from its owner's side.

Tasks go in, answers come back, limits end it.

A worker answers its tasks in order. Its current task is therefore the first one that it has not
answered: it began when the answer before it arrived, or when the worker woke up for it.
"""

from __future__ import annotations

import os
import select
import signal
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from time import monotonic
from typing import Any, NamedTuple, TypeVar

import psutil

from dubins_study.asking.reply import Reply, no_answer
from dubins_study.experiments.isolation.fork_server import fork
from dubins_study.study.rows.schema import Times
from dubins_study.study.words import Outcome

# Seconds between two checks of the limits.
POLL_INTERVAL_S = 0.02
# The memory of a worker's children is read at every tenth check only: listing them takes
# milliseconds if many processes run.
_CHECKS_PER_CHILDREN_CHECK = 10
# Seconds within which an idle worker must begin its next task.
_STALL_S = 10.0
# Seconds that count at most between two checks. In a longer pause the run was suspended.
_MAX_PAUSE_S = 1.0
_OUTPUT_BYTES = 400  # length of the last output that is kept
_OUTPUT_CHARS = 200  # length of the last output that a message shows
_READ_BYTES = 2**20
_GIB = 2**30


class Allowance(NamedTuple):
    """Seconds that a task may take, with a margin.

    The margin is for time that is no part of the limit.
    """

    limit_s: float
    margin_s: float = 0.0
    activity: str = ""  # the worker's activity, if the limit is not the caller's


_STARTING = Allowance(60.0, activity="starting a worker")
_WAKING = Allowance(_STALL_S, activity="waiting for it to begin")


class Task(NamedTuple):
    """A task that a worker has received.

    The caller may attach any object as `tag`.
    """

    message: list[Any]
    allowance: Allowance
    put_s: float  # when the owner handed it over
    tag: Any = None


class Answered(NamedTuple):
    """A worker's answer to a task."""

    task: Task
    value: Any
    changed: bool  # whether the task changed the process; the worker then answers no more


class Ended(NamedTuple):
    """The end of a worker.

    `reply` tells why the worker ended, and answers the task that it had begun. If it had begun
    none, `task` is None.
    """

    reply: Reply
    task: Task | None


class WorkerProcess:
    """A process that answers tasks until it is closed.

    See `worker.answer_tasks`.
    """

    def __init__(self, function: str, arguments: list[Any], memory_bytes: int):
        self._process = fork(function, arguments)
        self._memory_bytes = memory_bytes
        self._checked_s = monotonic()
        self._checks = 0
        # Tasks that are not answered yet, in order. The first "answer" says that it has started.
        self.pending = deque([Task([], _STARTING, self._checked_s)])
        self.closed = False
        # Whether the current task has begun, and since when it runs, or waits for the worker.
        self._begun = True
        self._since_s = self._checked_s
        self._output = b""
        self._open = {self._process.channel.line.fileno(), self._process.output}

    def put(self, message: list[Any], allowance: Allowance, tag: Any = None) -> None:
        """Add a task; `wait` sends it."""
        now_s = monotonic()
        if not self.pending:
            self._begun = False
            self._since_s = now_s
        self.pending.append(Task(message, allowance, now_s, tag))
        self._process.channel.put(message)

    def request(self, message: list[Any], allowance: Allowance) -> Answered | Ended:
        """Put one task and wait for its answer.

        If the worker ends instead, its end is returned. Output from before this task is dropped.
        """
        self._read_output()
        self._output = b""
        self.put(message, allowance)
        task = self.pending[-1]
        while True:
            for _, event in wait([self], POLL_INTERVAL_S):
                if event.task is task or isinstance(event, Ended):
                    return event

    def register(self, poll: select.poll) -> None:
        """Send what the socket takes, and register for polling.

        All descriptors of the worker are added to the poll.
        """
        all_sent = True
        with suppress(OSError):  # the worker has ended; its exit pipe shows this
            all_sent = self._process.channel.flush()
        poll.register(self._process.exit_pipe, select.POLLIN)
        for source in self._open:
            poll.register(source, select.POLLIN)
        if not all_sent:  # the rest of a long message is sent once the worker has read more
            poll.register(self._process.channel.line, select.POLLIN | select.POLLOUT)

    def events(self, ready: set[int]) -> Iterator[Answered | Ended]:
        """Yield answers that have arrived, and the worker's end.

        `ready` has the descriptors that can be read. A worker that breaks a limit, or sends what
        cannot be read, is killed here.
        """
        if self._process.output in ready:
            self._read_output()
        ended = self._process.exit_pipe in ready
        reply = None
        if ended or self._process.channel.line.fileno() in ready:
            try:
                yield from self._answers()
            except Exception as error:  # a worker may send anything
                message = f"stopped: its worker sent what cannot be read: {error}"
                reply = no_answer(Outcome.CRASHED, message)
        if self.closed:
            return
        if ended:
            reply = self._crash_reply()
        elif reply is None and monotonic() - self._checked_s >= POLL_INTERVAL_S:
            reply = self._broken_limit()
        if reply is not None:
            task = None
            if self.pending and self._begun:
                task = self.pending[0]
            self.close()
            yield Ended(reply, task)

    def _answers(self) -> Iterator[Answered]:
        """Yield the answers among the arrived messages.

        A message is "begun", or the answer to the first pending task: `[value, changed]`.
        """
        try:
            for message in self._process.channel.received():
                self._since_s = monotonic()
                if message == "begun":
                    self._begun = True
                    continue
                value, changed = message
                task = self.pending.popleft()
                self._begun = bool(self.pending)
                yield Answered(task, value, bool(changed))
                if self.closed:
                    return
        except (EOFError, OSError):  # the worker closed its end: it has ended, or its limit will
            self._open.discard(self._process.channel.line.fileno())

    def _broken_limit(self) -> Reply | None:
        """The reply if a limit is broken, or None.

        The limits are those of time and of memory; the reply is to the current task.
        """
        now_s = monotonic()
        # A run that was suspended loses no time: a long pause counts as `_MAX_PAUSE_S`.
        suspended_s = max(0.0, now_s - self._checked_s - _MAX_PAUSE_S)
        self._since_s = min(self._since_s + suspended_s, now_s)
        self._checked_s = now_s
        self._checks += 1
        seconds = now_s - self._since_s
        if self.pending:
            allowance = _WAKING
            if self._begun:
                allowance = self.pending[0].allowance
            margin_s = allowance.margin_s
            if seconds > allowance.limit_s + margin_s:
                message = f"stopped after {seconds:.2f} s; the limit is {allowance.limit_s:g} s"
                if margin_s > 1:  # more than an answer needs to arrive
                    message += f", beyond which {margin_s:g} s were allowed"
                if allowance.activity:
                    message = f"stopped after {seconds:.0f} s of {allowance.activity}"
                return no_answer(Outcome.TIMEOUT, message, Times(wall_s=seconds))
        limit = self._memory_bytes
        with_children = self._checks % _CHECKS_PER_CHILDREN_CHECK == 0
        used = _used_bytes(self._process.pid, limit, with_children=with_children)
        if used <= limit:
            return None
        message = f"stopped holding {used / _GIB:.2f} GiB; the limit is {limit / _GIB:g} GiB"
        return no_answer(Outcome.OUT_OF_MEMORY, message, Times(wall_s=seconds))

    def _crash_reply(self) -> Reply:
        """The reply to the task of an ended worker.

        The message tells the exit status and the last output.
        """
        code = self._process.exit_code()
        status = f"exit {code}"
        message = f"its process ended itself with code {code}"
        if code < 0:
            status = f"signal {-code}"
            with suppress(ValueError):  # a signal without a name
                status = signal.Signals(-code).name
            message = f"its process was ended by {status}"
        output = self.last_output()
        if output:
            message += f"; its last output: {output}"
        outcome = Outcome.CRASHED
        # C++ ends a process in this way if it cannot allocate memory.
        if code == -signal.SIGABRT and "bad_alloc" in output:
            outcome = Outcome.OUT_OF_MEMORY
        return no_answer(outcome, message, status=status)

    def last_output(self) -> str:
        """The end of the worker's output, on one line."""
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


def wait(
    workers: Sequence[_AnyWorker], timeout_s: float
) -> Iterator[tuple[_AnyWorker, Answered | Ended]]:
    """Wait for events; yield each with its worker.

    The wait ends as soon as a worker sends anything or ends, or after `timeout_s`.
    """
    poll = select.poll()
    for worker in workers:
        worker.register(poll)
    ready = {descriptor for descriptor, _ in poll.poll(1000 * timeout_s)}
    for worker in workers:
        for event in worker.events(ready):
            yield worker, event


def _used_bytes(pid: int, limit: float, *, with_children: bool) -> int:
    """Bytes of memory that a process uses.

    With `with_children` its descendants are included. The number is 0 if the process has ended.
    """
    try:
        process = psutil.Process(pid)
        family = [process]
        if with_children:
            family += process.children(recursive=True)
    except psutil.Error:
        return 0
    used = 0
    for member in family:
        with suppress(psutil.Error):
            used += member.memory_info().rss
    if used <= limit or len(family) == 1:
        return used
    # Memory that several processes share was counted for each. Above the limit it is counted only
    # once (Linux), which is slower.
    used = 0
    for member in family:
        with suppress(psutil.Error):
            memory = member.memory_full_info()
            used += getattr(memory, "pss", memory.rss)
    return used
