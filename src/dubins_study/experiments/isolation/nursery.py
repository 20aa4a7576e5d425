"""What the server does that workers are forked from; imported there, and does nothing elsewhere.

It takes in every process whose parent has ended, whatever session that is in, so that none gets
out of sight; and when it ends, which it does once the process that runs an experiment is gone,
they all end. Linux; elsewhere a process that leaves its worker's session is lost from view.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import signal
import sys
import warnings
from contextlib import suppress
from time import sleep

import psutil

_PR_SET_CHILD_SUBREAPER = 36
_ROUNDS = 200


def _adopt() -> None:
    # out of reach of what is sent to the group of whoever runs the experiment
    with suppress(OSError):
        os.setsid()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
    warnings.filterwarnings("ignore", "forkserver: waitpid returned unexpected pid")
    atexit.register(_end_all, os.getpid())


def _end_all(owner: int) -> None:
    """Kill all descendants; those of a process that ends come here, so look again."""
    if os.getpid() != owner:
        return
    for _ in range(_ROUNDS):
        left = psutil.Process().children(recursive=True)
        left = [one for one in left if _lives(one)]
        if not left:
            return
        for process in left:
            with suppress(psutil.Error):
                process.kill()
        sleep(0.005)


def _lives(process: psutil.Process) -> bool:
    with suppress(psutil.Error):
        return bool(process.status() != psutil.STATUS_ZOMBIE)
    return False


if sys.orig_argv[-1].startswith("from multiprocessing.forkserver import main"):
    _adopt()
