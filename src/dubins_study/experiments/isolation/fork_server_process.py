"""The fork server's own process: it forks on request and kills the descendants of a worker.

The server ends when the process that started it has ended; it first kills all its descendants. On
Linux a process whose parent ends becomes the server's child, in any session, so the server finds
all of them. On other systems a process that leaves its worker's session is not found.
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import socket
import sys
from collections.abc import Collection
from contextlib import suppress
from importlib import import_module
from time import sleep

import psutil

# Loaded once here, for all workers.
import dubins_study.experiments.isolation.worker  # noqa: F401
from dubins_study.experiments.isolation.messages import Channel

# Options of Linux's prctl.
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
_MAX_DESCRIPTORS = 16
# Rounds of killing, and seconds per round: a killed process may leave children, which the next
# round kills.
_MAX_KILL_ROUNDS, _KILL_ROUND_S = 400, 0.005


def serve() -> None:
    """Fork a process per byte received from the socket on stdin, until that socket is closed."""
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
            request, descriptors, _, _ = socket.recv_fds(control, 1, _MAX_DESCRIPTORS)
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
    """Collect all ended children, and write the exit codes of forked ones to their pipes."""
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
    """Kill every descendant except the spared processes and their descendants."""
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


def _run_child(server: int, output: int, line: int, *extra: int) -> None:
    """In the forked process: receive a function's name and call it. This never returns."""
    code = 1
    try:
        # From now on, the kernel kills this process when the server ends.
        _set_process_option(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != server:  # the server has ended just before
            os._exit(1)
        os.setsid()  # so that Ctrl-C in a terminal does not reach this process
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
            signal.signal(number, signal.SIG_DFL)
        _redirect(output)
        channel = Channel(socket.socket(fileno=line))
        function, arguments, path, environment, directory = channel.receive()
        sys.path[:] = path
        os.environ.clear()
        os.environ.update(environment)
        with suppress(OSError):  # the directory was removed meanwhile
            os.chdir(directory)
        module, _, name = function.partition(":")
        getattr(import_module(module), name)(channel, *arguments, *extra)
        code = 0
    except EOFError:  # the pool has closed the channel
        code = 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        with suppress(Exception):
            sys.stderr.flush()
        os._exit(code)


def _redirect(output: int) -> None:
    """Send stdout and stderr to a pipe, and close the pipe's own descriptor."""
    for name, number in (("stdout", 1), ("stderr", 2)):
        os.dup2(output, number)
        stream = open(  # noqa: SIM115
            number, "w", encoding="utf-8", errors="replace", buffering=1, closefd=False
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)
    os.close(output)


def _set_process_option(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, value)
