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
from contextlib import suppress
from importlib import import_module
from time import sleep

# loaded once here, for every worker
import dubins_study.experiments.isolation.worker  # noqa: F401
from dubins_study.experiments.isolation import process_tree
from dubins_study.experiments.isolation.messages import Channel
from dubins_study.experiments.isolation.sandbox import die_with_parent, lead_session, redirect

_PR_SET_CHILD_SUBREAPER = 36
_MAX_DESCRIPTORS = 16
# rounds of killing what is left: each process killed may leave children that were its own
_ROUNDS, _ROUND_S = 400, 0.005


def serve() -> None:
    """Fork a process for every byte that comes down the socket on stdin, until that is closed."""
    control = socket.socket(fileno=os.dup(0))
    with open(os.devnull, "rb") as nothing:  # noqa: PTH123
        os.dup2(nothing.fileno(), 0)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
    wake, wake_end = os.pipe()
    os.set_blocking(wake, False)
    os.set_blocking(wake_end, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake_end, warn_on_full_buffer=False)
    status_pipes: dict[int, int] = {}
    while True:
        ready, _, _ = select.select([control.fileno(), wake], [], [])
        if wake in ready:
            os.read(wake, 4096)
            _reap(status_pipes)
        if control.fileno() in ready:
            request, descriptors, _, _ = socket.recv_fds(control, 1, _MAX_DESCRIPTORS)
            if not request:
                break
            pid = os.fork()
            if pid == 0:
                control.close()
                for pipe in (wake, wake_end, *status_pipes.values()):
                    os.close(pipe)
                _become(descriptors)
            status_pipes[pid] = descriptors[0]
            for descriptor in descriptors[1:]:
                os.close(descriptor)
            control.sendall(pid.to_bytes(8))
    _end_descendants(set())
    os._exit(0)


def _reap(status_pipes: dict[int, int]) -> None:
    """Take the exit codes of all that has ended, and tell those of our own processes."""
    ended: dict[int, int] = {}
    with suppress(ChildProcessError):  # there is no child left
        while True:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                break
            if pid in status_pipes:
                ended[pid] = os.waitstatus_to_exitcode(status)
    if not ended:
        return
    for pid in ended:
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
    _end_descendants(status_pipes.keys() - ended.keys())
    for pid, code in ended.items():
        pipe = status_pipes.pop(pid)
        with suppress(OSError):  # nobody waits for it any more
            os.write(pipe, str(code).encode())
        os.close(pipe)


def _end_descendants(spared: set[int]) -> None:
    """Kill every descendant but the processes named and their own children."""
    for _ in range(_ROUNDS):
        orphans = [pid for pid in process_tree.children(os.getpid()) if pid not in spared]
        if not orphans:
            return
        for orphan in orphans:
            process_tree.kill_family(orphan)
        sleep(_ROUND_S)
        for orphan in orphans:
            with suppress(OSError):
                os.waitpid(orphan, os.WNOHANG)


def _become(descriptors: list[int]) -> None:
    """Be the process that was asked for; it never returns."""
    code = 1
    try:
        status, output, channel_end, *extra = descriptors
        os.close(status)
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        die_with_parent()
        lead_session()
        redirect(output)
        channel = Channel(socket.socket(fileno=channel_end))
        (function, arguments, path, environment, directory), _ = channel.receive()
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
