"""Processes forked from a server of our own, which has our modules loaded and runs no thread.

A plain fork would copy the caller's threads and memory; a fresh interpreter takes a second for
every worker. multiprocessing's fork server is one for the whole process: what we change in it
(ignored signals, adopted orphans) would reach the caller's own processes.
"""

from __future__ import annotations

import atexit
import fcntl
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from contextlib import ExitStack, suppress
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.isolation.messages import Channel

# the folder from which this package was imported: a forked process must find it as well
_PACKAGE_FOLDER = str(FilePath(__file__).parents[3])
_PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv.pop()); "
    "from dubins_study.experiments.isolation.fork_server_process import serve; serve()"
)
# to import our modules on a busy machine
_START_UP_S = 120.0
# for the kernel to end a process that was killed, and for the server to kill all that is left
_KILL_WAIT_S, _STOP_WAIT_S = 2.0, 5.0
_OUTPUT_PIPE_BYTES = 2**20


class ForkServerError(DubinsStudyError, RuntimeError):
    """No process can be forked."""


class ForkedProcess(NamedTuple):
    """A process that the server has forked.

    Args:
        pid: its process id; it leads a session of its own.
        channel: messages to and from it; does not block.
        output: read end of the pipe that is its stdout and stderr; does not block.
        status: read end of a pipe; readable once the process, and what it has left behind, ended.
    """

    pid: int
    channel: Channel
    output: int
    status: int

    def exit_code(self, timeout_s: float = _KILL_WAIT_S) -> int | None:
        """How the process ended, or None if it has not ended in time; to be read once.

        Minus the number of the signal that ended it.
        """
        if not _readable(self.status, timeout_s):
            return None
        text = os.read(self.status, 32)
        # the kernel kills the processes of a server that was killed itself
        return int(text) if text else -signal.SIGKILL

    def kill(self) -> None:
        """Kill it, if it has not ended; the server kills what it leaves behind."""
        if not _readable(self.status, 0):
            with suppress(OSError):
                os.kill(self.pid, signal.SIGKILL)

    def close(self) -> None:
        """Kill it, wait for its end, and close what leads to it."""
        self.kill()
        _readable(self.status, _KILL_WAIT_S)
        self.channel.line.close()
        os.close(self.output)
        os.close(self.status)


def exit_status(code: int) -> tuple[str, str]:
    """The end of a process in a word and in a sentence.

    Args:
        code: its exit code, or minus the number of the signal that ended it.
    """
    if code >= 0:
        return f"exit {code}", f"its process ended itself with code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return name, f"its process was ended by {name}"


def _readable(descriptor: int, timeout_s: float) -> bool:
    """Whether something can be read in time, if only that nothing will come any more."""
    poll = select.poll()  # `select.select` takes only the first thousand descriptors
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(1000 * timeout_s))


class _ForkServer:
    """The server of this process, started when it is first needed, and again if it was killed."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None

    def request(self, descriptors: list[int]) -> None:
        """Have a process forked, which is given descriptors."""
        with self._lock:
            if self._control is None or self._process is None or self._process.poll() is not None:
                self.stop()
                self._control, server_end = socket.socketpair()
                with server_end:
                    self._process = subprocess.Popen(
                        [sys.executable, "-P", "-c", _PROGRAM, json.dumps(_search_path())],
                        stdin=server_end.fileno(),
                        stdout=subprocess.DEVNULL,
                        start_new_session=True,
                    )
            socket.send_fds(self._control, [b"f"], descriptors)

    def wait(self) -> None:
        """Wait a few seconds for the end of the server."""
        if self._process is not None:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_STOP_WAIT_S)

    def stop(self) -> None:
        """End the server, and with it every process that it has forked."""
        if self._control is not None:
            self._control.close()
        self.wait()

    def forget_in_child(self) -> None:
        """In a process that the caller has forked: the server is its parent's."""
        if self._process is not None:
            self._process.returncode = 0  # it is no child of this process to wait for
        self.stop()
        self._lock, self._process, self._control = threading.Lock(), None, None


_server = _ForkServer()
os.register_at_fork(after_in_child=_server.forget_in_child)
atexit.register(_server.stop)


def fork(function: str, arguments: list[Any], extra: tuple[int, ...] = ()) -> ForkedProcess:
    """Call a function in a process that is forked from the server.

    The caller's environment and working directory, and its `sys.path` without that, go with it.

    Args:
        function: `module:name`, called as `name(channel, *arguments, *descriptors)`. Its process
            ends when it returns.
        arguments: plain values, as JSON has them.
        extra: file descriptors that the function is given as well.

    Raises:
        ForkServerError: if the server does not start or does not answer.
    """
    message = [function, arguments, _search_path(), dict(os.environ), _directory()]
    reason: OSError | None = None
    for _attempt in range(2):  # the server may have been killed just now
        try:
            return _forked(message, extra)
        except OSError as error:
            reason = error
            _server.wait()
    raise ForkServerError(f"the fork server does not answer: {reason}")


def _forked(message: list[Any], extra: tuple[int, ...]) -> ForkedProcess:
    with ExitStack() as process_ends, ExitStack() as caller_ends:
        line, line_end = socket.socketpair()
        caller_ends.enter_context(line)
        process_ends.enter_context(line_end)
        (output, output_end), (status, status_end) = os.pipe(), os.pipe()
        for pipe in (output, status):
            caller_ends.callback(os.close, pipe)
        for pipe in (output_end, status_end):
            process_ends.callback(os.close, pipe)
        if hasattr(fcntl, "F_SETPIPE_SZ"):  # a solver that prints much seldom waits for us to read
            with suppress(OSError):
                fcntl.fcntl(output_end, fcntl.F_SETPIPE_SZ, _OUTPUT_PIPE_BYTES)
        _server.request([status_end, output_end, line_end.fileno(), *extra])
        process_ends.close()
        pid = os.read(status, 8) if _readable(status, _START_UP_S) else b""
        if not pid:
            raise ConnectionError("it ended, or hangs")
        channel = Channel(line)
        channel.put(message)
        with suppress(OSError):  # the process was killed at once; its end is seen by its status
            channel.flush()
        line.setblocking(False)
        os.set_blocking(output, False)
        caller_ends.pop_all()
        return ForkedProcess(int.from_bytes(pid), channel, output, status)


def _search_path() -> list[str]:
    """The caller's `sys.path` without its working directory.

    The files that lie there by chance (`report.py`, `solvers/`) must not stand in for a package.
    """
    entries = [os.path.abspath(entry) for entry in sys.path if entry]  # noqa: PTH100
    entries = [entry for entry in entries if entry != _directory()]
    return entries if _PACKAGE_FOLDER in entries else [*entries, _PACKAGE_FOLDER]


def _directory() -> str:
    try:
        return os.getcwd()  # noqa: PTH109
    except OSError:  # it was removed
        return "/"
