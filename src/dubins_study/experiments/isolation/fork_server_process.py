"""The fork server's own process: forks on request, and kills what a worker leaves behind.

It ends when the process that started it is gone, and kills all its descendants before. On Linux
a process whose parent ends becomes the server's child, whatever session it is in, so that none
gets out of sight; elsewhere one that leaves its worker's session does.
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

# loaded once here, for every worker
import dubins_study.experiments.isolation.worker  # noqa: F401
from dubins_study.experiments.isolation.messages import Channel

_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
_MAX_DESCRIPTORS = 16
# rounds of killing what is left: each process killed may leave children that were its own
_ROUNDS, _ROUND_S = 400, 0.005


def serve() -> None:
    """Fork a process for every byte that comes down the socket on stdin, until that is closed."""
    control = socket.socket(fileno=os.dup(0))
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    _set_process_option(_PR_SET_CHILD_SUBREAPER, 1)
    wake, wake_end = socket.socketpair()  # the end of a child wakes the loop
    wake_end.setblocking(False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake_end.fileno(), warn_on_full_buffer=False)
    server = os.getpid()
    status_pipes: dict[int, int] = {}
    while True:
        ready, _, _ = select.select([control, wake], [], [])
        if wake in ready:
            wake.recv(4096)
            _reap(status_pipes)
        if control in ready:
            request, descriptors, _, _ = socket.recv_fds(control, 1, _MAX_DESCRIPTORS)
            if not request:
                break
            status, *others = descriptors
            pid = os.fork()
            if pid == 0:
                signal.set_wakeup_fd(-1)
                for inherited in (control, wake, wake_end):
                    inherited.close()
                for pipe in (status, *status_pipes.values()):
                    os.close(pipe)
                _become(server, *others)
            status_pipes[pid] = status
            for descriptor in others:
                os.close(descriptor)
            with suppress(OSError):  # the caller was interrupted and does not wait for it
                os.write(status, pid.to_bytes(8))
    _end_descendants(())
    os._exit(0)


def _reap(status_pipes: dict[int, int]) -> None:
    """Take the exit codes of all that has ended, and tell those of our own processes."""
    ended: dict[int, int] = {}
    with suppress(ChildProcessError):  # there is no child left
        while (child := os.waitpid(-1, os.WNOHANG))[0]:
            if child[0] in status_pipes:
                ended[child[0]] = os.waitstatus_to_exitcode(child[1])
    for pid in ended:
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
    if ended:
        _end_descendants(status_pipes.keys() - ended.keys())
    for pid, code in ended.items():
        pipe = status_pipes.pop(pid)
        with suppress(OSError):  # nobody waits for it any more
            os.write(pipe, str(code).encode())
        os.close(pipe)


def _end_descendants(spared: Collection[int]) -> None:
    """Kill every descendant but the processes named and their own children."""
    for _ in range(_ROUNDS):
        orphans = [child for child in psutil.Process().children() if child.pid not in spared]
        if not orphans:
            return
        for orphan in orphans:
            with suppress(psutil.Error):
                for process in (orphan, *orphan.children(recursive=True)):
                    process.kill()
        sleep(_ROUND_S)
        for orphan in orphans:
            with suppress(OSError):
                os.waitpid(orphan.pid, os.WNOHANG)


def _become(server: int, output: int, line: int, *extra: int) -> None:
    """Be a process of its own, and call the function that it is told; it never returns."""
    code = 1
    try:
        _set_process_option(_PR_SET_PDEATHSIG, signal.SIGKILL)  # the kernel ends it with the server
        if os.getppid() != server:  # it ended just now
            os._exit(1)
        os.setsid()  # Ctrl-C in a terminal passes it by
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGCHLD):
            signal.signal(number, signal.SIG_DFL)
        _redirect(output)
        channel = Channel(socket.socket(fileno=line))
        function, arguments, path, environment, directory = channel.receive()
        sys.path[:] = path
        os.environ.clear()
        os.environ.update(environment)
        with suppress(OSError):  # it was removed meanwhile
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
    """Write stdout and stderr to a pipe, which is closed here."""
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
