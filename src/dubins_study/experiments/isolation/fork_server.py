"""Processes forked from our own server.

The server has our modules loaded and runs no thread.

A plain fork would copy the caller's threads and memory; a fresh interpreter takes a second per
worker. `multiprocessing` has a single fork server for the whole Python process. Our changes to it
(ignored signals, adopted orphans) would also affect processes that the caller starts.

The first half runs in the caller's process, the second half in the server and its children. The
server ends when the process that started it has ended; it first kills all its descendants. On Linux
a process whose parent ends becomes the server's child, in any session, so the server finds all of
them. On other systems a process that leaves its worker's session is not found.
"""

from __future__ import annotations

import atexit
import ctypes
import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Collection
from contextlib import ExitStack, suppress
from importlib import import_module
from pathlib import Path as FilePath
from time import sleep
from typing import Any, NamedTuple

import psutil

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.isolation.messages import Channel
from dubins_study.experiments.isolation.process_state import ONE_THREAD

# The folder from which this package was imported: a forked process must find it too.
_PACKAGE_FOLDER = str(FilePath(__file__).parents[3])
_PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv.pop()); "
    "from dubins_study.experiments.isolation.fork_server import serve; serve()"
)
# Seconds that the server may take to import our modules on a busy machine.
_START_UP_S = 120.0
# Seconds to wait until a killed process has ended.
_KILL_WAIT_S = 2.0
# Seconds to wait until a stopped server has killed its descendants and ended.
_STOP_WAIT_S = 5.0
# Options of Linux's prctl.
_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36
# Rounds of killing: a killed process may leave children, which the next round kills.
_MAX_KILL_ROUNDS = 400
_KILL_ROUND_S = 0.005


class ForkServerError(DubinsStudyError, RuntimeError):
    """A process cannot be forked."""


class ForkedProcess(NamedTuple):
    """A forked process; it leads its own session."""

    pid: int
    channel: Channel  # messages to and from the process; does not block
    output: int  # read end of the pipe that is its stdout and stderr; does not block
    exit_pipe: int  # readable once the process and all its descendants have ended

    def exit_code(self) -> int:
        """Exit code, or -N if signal N killed it.

        The process must have ended. The code can be read once.
        """
        text = os.read(self.exit_pipe, 32)
        if not text:  # the server itself was killed, and the kernel has killed its processes
            return -signal.SIGKILL
        return int(text)

    def kill(self) -> None:
        """Kill the process if it has not ended.

        The server kills its descendants.
        """
        if not _readable(self.exit_pipe, 0):
            with suppress(OSError):
                os.kill(self.pid, signal.SIGKILL)

    def close(self) -> None:
        """Kill the process and close its pipes.

        Between the two, the call waits up to two seconds for the process to end. The channel is
        closed too.
        """
        self.kill()
        _readable(self.exit_pipe, _KILL_WAIT_S)
        self.channel.line.close()
        os.close(self.output)
        os.close(self.exit_pipe)


def _readable(descriptor: int, timeout_s: float) -> bool:
    """Whether a descriptor can be read within `timeout_s`.

    Data can be read, or the end of the stream.
    """
    poll = select.poll()  # `select.select` takes only the first thousand descriptors
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(1000 * timeout_s))


class _ForkServer:
    """The fork server that this process owns.

    The first request starts the server, and the next one after it was killed.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None

    def request(self, descriptors: list[int]) -> None:
        """Ask the server to fork a process.

        `descriptors` are passed to the process, in the order of `serve`. If no server runs, one is
        started.
        """
        with self._lock:
            if self._control is None or self._process is None or self._process.poll() is not None:
                self.stop()
                self._control, server_end = socket.socketpair()
                with server_end:
                    self._process = subprocess.Popen(
                        # -u: the output of a solver is read even if its process crashes
                        [sys.executable, "-uPc", _PROGRAM, json.dumps(_search_path())],
                        stdin=server_end.fileno(),
                        stdout=subprocess.DEVNULL,
                        # a process is forked safely without threads
                        env=os.environ | ONE_THREAD | {"PYTHONIOENCODING": "utf-8:replace"},
                        start_new_session=True,
                    )
            socket.send_fds(self._control, [b"f"], descriptors)

    def wait(self) -> None:
        """Wait a few seconds for the server's end."""
        if self._process is not None:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_STOP_WAIT_S)

    def stop(self) -> None:
        """End the server and all processes forked from it."""
        if self._control is not None:
            self._control.close()
        self.wait()

    def detach_in_child(self) -> None:
        """Forget the server in a forked process.

        The caller has forked this process; the server belongs to its parent.
        """
        if self._process is not None:
            self._process.returncode = 0  # this process cannot wait for its parent's child
        self.stop()
        self._lock = threading.Lock()
        self._process = None
        self._control = None


_server = _ForkServer()
os.register_at_fork(after_in_child=_server.detach_in_child)
atexit.register(_server.stop)


def fork(function: str, arguments: list[Any]) -> ForkedProcess:
    """Call a function in a newly forked process.

    The process is forked from the server, and ends when the function returns. The result is the
    caller's side of the process.

    `function` is `module:name`, called as `name(channel, *arguments)` with arguments that JSON can
    hold. The new process gets the caller's environment and working directory, and the caller's
    `sys.path` without the working directory.
    """
    directory = os.getcwd()  # noqa: PTH109
    message = [function, arguments, _search_path(), dict(os.environ), directory]
    reason: OSError | None = None
    for _attempt in range(2):  # the server may have been killed just now
        try:
            return _forked(message)
        except OSError as error:
            reason = error
            _server.wait()
    raise ForkServerError(f"the fork server does not answer: {reason}")


def _forked(message: list[Any]) -> ForkedProcess:
    """Fork a process, and send it a message.

    Of each pair of ends the caller keeps one; the server passes the other to the process. If the
    server does not answer, all ends are closed and OSError is raised.
    """
    with ExitStack() as process_ends, ExitStack() as caller_ends:
        line, line_end = socket.socketpair()
        caller_ends.enter_context(line)
        process_ends.enter_context(line_end)
        output, output_end = os.pipe()
        exit_pipe, exit_end = os.pipe()
        for pipe in (output, exit_pipe):
            caller_ends.callback(os.close, pipe)
        for pipe in (output_end, exit_end):
            process_ends.callback(os.close, pipe)
        _server.request([exit_end, output_end, line_end.fileno()])
        process_ends.close()
        # The exit pipe first gives the process id, and once the process has ended its exit code.
        pid = b""
        if _readable(exit_pipe, _START_UP_S):
            pid = os.read(exit_pipe, 8)
        if not pid:
            raise ConnectionError("it ended, or hangs")
        channel = Channel(line)
        channel.put(message)
        with suppress(OSError):  # the process was killed at once; its exit pipe will show this
            channel.flush()
        line.setblocking(False)
        os.set_blocking(output, False)
        caller_ends.pop_all()
        return ForkedProcess(int.from_bytes(pid), channel, output=output, exit_pipe=exit_pipe)


def _search_path() -> list[str]:
    """The caller's `sys.path` without its working directory.

    Files in that directory may hide a package.
    """
    directory = os.getcwd()  # noqa: PTH109
    entries = [os.path.abspath(entry) for entry in sys.path if entry]  # noqa: PTH100
    entries = [entry for entry in entries if entry != directory]
    if _PACKAGE_FOLDER not in entries:
        entries.append(_PACKAGE_FOLDER)
    return entries


# The server's own process.


def serve() -> None:
    """Fork a process per byte received on stdin.

    Stdin is a socket. With each byte come three descriptors of the new process: write end of its
    exit pipe, write end of its output, its end of the channel. When the socket is closed, all
    descendants are killed and the server ends.
    """
    # loaded and read once, for all workers
    import_module("dubins_study.experiments.isolation.worker")
    import_module("dubins_study.experiments.code_digest").study_sources()
    control = socket.socket(fileno=os.dup(0))
    null_device = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null_device, 0)
    os.close(null_device)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    _set_process_option(_PR_SET_CHILD_SUBREAPER, 1)
    wake, wake_end = socket.socketpair()  # the end of a child wakes the loop
    wake_end.setblocking(False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake_end.fileno(), warn_on_full_buffer=False)
    server = os.getpid()
    exit_pipes: dict[int, int] = {}  # process id -> write end of its exit pipe
    while True:
        ready, _, _ = select.select([control, wake], [], [])
        if wake in ready:
            wake.recv(4096)
            _reap(exit_pipes)
        if control in ready:
            request, descriptors, _, _ = socket.recv_fds(control, 1, 3)
            if not request:
                break
            exit_pipe, *others = descriptors
            pid = os.fork()
            if pid == 0:
                signal.set_wakeup_fd(-1)
                for inherited in (control, wake, wake_end):
                    inherited.close()
                for pipe in (exit_pipe, *exit_pipes.values()):
                    os.close(pipe)
                _run_child(server, *others)
            exit_pipes[pid] = exit_pipe
            for descriptor in others:
                os.close(descriptor)
            with suppress(OSError):  # the caller was interrupted and no longer reads the pipe
                os.write(exit_pipe, pid.to_bytes(8))
    _end_descendants(())
    os._exit(0)


def _reap(exit_pipes: dict[int, int]) -> None:
    """Collect all ended children; report their exit codes.

    The exit code of a forked process is written to its exit pipe, which is then closed and removed
    from `exit_pipes`. Before that, its descendants are killed.
    """
    ended: dict[int, int] = {}
    with suppress(ChildProcessError):  # no child is left
        while (child := os.waitpid(-1, os.WNOHANG))[0]:
            if child[0] in exit_pipes:
                ended[child[0]] = os.waitstatus_to_exitcode(child[1])
    for pid in ended:
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
    if ended:
        _end_descendants(exit_pipes.keys() - ended.keys())
    for pid, code in ended.items():
        pipe = exit_pipes.pop(pid)
        with suppress(OSError):  # the caller has closed the pipe
            os.write(pipe, str(code).encode())
        os.close(pipe)


def _end_descendants(spared: Collection[int]) -> None:
    """Kill every descendant except the spared ones.

    The descendants of spared processes are spared too.
    """
    for _ in range(_MAX_KILL_ROUNDS):
        orphans = [child for child in psutil.Process().children() if child.pid not in spared]
        if not orphans:
            return
        for orphan in orphans:
            with suppress(psutil.Error):
                for process in (orphan, *orphan.children(recursive=True)):
                    process.kill()
        sleep(_KILL_ROUND_S)
        for orphan in orphans:
            with suppress(OSError):
                os.waitpid(orphan.pid, os.WNOHANG)


def _run_child(server: int, output: int, line: int) -> None:
    """Receive a function's name and call it.

    This runs in the forked process, and never returns.
    """
    code = 1
    try:
        # From now on, the kernel kills this process when the server ends.
        _set_process_option(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != server:  # the server has ended just before
            os._exit(1)
        os.setsid()  # so that Ctrl-C in a terminal does not reach this process
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
            signal.signal(number, signal.SIG_DFL)
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.close(output)
        channel = Channel(socket.socket(fileno=line))
        function, arguments, path, environment, directory = channel.receive()
        sys.path[:] = path
        os.environ.clear()
        os.environ.update(environment)
        os.chdir(directory)
        module, _, name = function.partition(":")
        getattr(import_module(module), name)(channel, *arguments)
        code = 0
    except EOFError:  # the pool has closed the channel
        code = 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        os._exit(code)


def _set_process_option(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, value)
