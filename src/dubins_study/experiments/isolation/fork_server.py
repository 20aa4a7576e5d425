"""Processes forked from a server of our own, which has our modules loaded and runs no thread.

A plain fork would copy the caller's threads and memory; a fresh interpreter takes a second for
every worker. multiprocessing's fork server is one for the whole process: what we change in it
(ignored signals, adopted orphans) would reach the caller's own processes.
"""

from __future__ import annotations

import atexit
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
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
# to kill every process that is left when the caller ends
_EXIT_WAIT_S = 5.0
_OUTPUT_PIPE_BYTES = 2**20
_F_SETPIPE_SZ = 1031


class ForkServerError(DubinsStudyError, RuntimeError):
    """No process can be forked."""


class ForkedProcess(NamedTuple):
    """A process that the server has forked.

    Args:
        pid: its process id; it leads a session of its own.
        channel: messages to and from it.
        output: read end of the pipe that is its stdout and stderr; does not block.
        status: read end of a pipe; readable once the process, and what it has left behind, ended.
    """

    pid: int
    channel: Channel
    output: int
    status: int

    def exit_code(self) -> int:
        """How the process ended, once `status` is readable; minus the number of a signal."""
        text = os.read(self.status, 32)
        # the kernel kills the processes of a server that was killed itself
        return int(text) if text else -signal.SIGKILL

    def wait(self, timeout_s: float) -> bool:
        """Whether the process ends in time."""
        return bool(select.select([self.status], [], [], timeout_s)[0])

    def kill(self) -> None:
        """Kill it; the server kills what it leaves behind."""
        with suppress(OSError):
            os.kill(self.pid, signal.SIGKILL)

    def close(self) -> None:
        """Forget a process that has ended."""
        self.channel.close()
        os.close(self.output)
        os.close(self.status)


class _ForkServer:
    """The server of this process, started when it is first needed, and again if it was killed."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None

    def fork(self, function: str, arguments: list[Any], extra: list[int]) -> ForkedProcess:
        """See `fork`."""
        ours, theirs = socket.socketpair()
        output, output_end = os.pipe()
        status, status_end = os.pipe()
        _enlarge(output_end)
        with theirs:
            try:
                pid = self._request([status_end, output_end, theirs.fileno(), *extra])
            except BaseException:
                ours.close()
                os.close(output)
                os.close(status)
                raise
            finally:
                os.close(output_end)
                os.close(status_end)
        os.set_blocking(output, False)
        channel = Channel(ours)
        with suppress(OSError):  # the process was killed at once; its end is seen by its status
            channel.send([function, arguments, search_path(), dict(os.environ), _directory()])
        ours.setblocking(False)
        return ForkedProcess(pid, channel, output, status)

    def _request(self, descriptors: list[int]) -> int:
        with self._lock:
            for attempts_left in (1, 0):
                try:
                    control = self._running()
                    socket.send_fds(control, [b"f"], descriptors)
                    pid = control.recv(8)
                    if pid:
                        return int.from_bytes(pid)
                except OSError as error:
                    if not attempts_left:
                        raise ForkServerError(f"the fork server does not answer: {error}") from None
                except BaseException:  # interrupted between a request and its answer
                    self._forget()
                    raise
                self._forget()
        raise ForkServerError("the fork server ends before it has forked a process")

    def _running(self) -> socket.socket:
        if self._control is None:
            self._control, theirs = socket.socketpair()
            self._control.settimeout(_START_UP_S)
            with theirs:
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-c", _PROGRAM, json.dumps(search_path())],
                    stdin=theirs.fileno(),
                    stdout=subprocess.DEVNULL,
                    start_new_session=True,
                )
        return self._control

    def _forget(self) -> None:
        if self._control is not None:
            self._control.close()
        if self._process is not None:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_EXIT_WAIT_S)
        self._control = self._process = None

    def stop(self) -> None:
        """End the server, and with it every process that it has forked."""
        with self._lock:
            self._forget()

    def forget_in_child(self) -> None:
        """In a process that the caller has forked: the server is its parent's."""
        self._lock = threading.Lock()
        if self._control is not None:
            self._control.close()
        if self._process is not None:
            self._process.returncode = 0  # it is no child of this process to wait for
        self._control = self._process = None


def search_path() -> list[str]:
    """The caller's `sys.path` without its working directory.

    The files that lie there by chance (`report.py`, `solvers/`) must not stand in for a package.
    """
    here = _directory()
    kept = [os.path.abspath(entry) for entry in sys.path if entry]  # noqa: PTH100
    kept = [entry for entry in kept if entry != here]
    return kept if _PACKAGE_FOLDER in kept else [*kept, _PACKAGE_FOLDER]


def _directory() -> str:
    try:
        return os.getcwd()  # noqa: PTH109
    except OSError:  # it was removed
        return "/"


def _enlarge(pipe: int) -> None:
    """Let a solver that prints much seldom wait for us to read it."""
    if sys.platform == "linux":
        import fcntl

        with suppress(OSError):
            fcntl.fcntl(pipe, _F_SETPIPE_SZ, _OUTPUT_PIPE_BYTES)


_server = _ForkServer()
os.register_at_fork(after_in_child=_server.forget_in_child)
atexit.register(_server.stop)


def fork(function: str, arguments: list[Any], extra: tuple[int, ...] = ()) -> ForkedProcess:
    """Call a function in a process that is forked from the server.

    Args:
        function: `module:name`, called as `name(channel, *arguments, *descriptors)`. Its process
            ends when it returns.
        arguments: plain values, as JSON has them.
        extra: file descriptors that the function is given as well.

    Raises:
        ForkServerError: if the server does not start or does not answer.
    """
    return _server.fork(function, arguments, list(extra))
