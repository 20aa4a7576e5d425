"""Plug-ins that turn on their kin: parent, group, siblings. Each deserves a run of its own."""

from __future__ import annotations

import ctypes
import os
import signal

from dubins_study.solvers.analytic import Analytic


class KillsGroup(Analytic):
    """Kills its whole process group."""

    def solve(self, model, limit):
        os.killpg(0, signal.SIGKILL)


class KillsParent(Analytic):
    """Kills whoever started it."""

    def solve(self, model, limit):
        if os.getppid() > 1:
            os.kill(os.getppid(), signal.SIGKILL)
        return super().solve(model, limit)


class InterruptsGroup(Analytic):
    """Sends its group what Ctrl-C sends."""

    def solve(self, model, limit):
        os.killpg(0, signal.SIGINT)
        return super().solve(model, limit)


class Orphan(Analytic):
    """Asks the kernel not to be told of its parent's death, and loops in C."""

    def solve(self, model, limit):
        ctypes.CDLL(None).prctl(1, 0, 0, 0, 0)  # PR_SET_PDEATHSIG
        ctypes.CDLL(None).prctl(4, 0, 0, 0, 0)  # PR_SET_DUMPABLE: /proc tells less of it
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        ctypes.PyDLL(None).sleep(10**6)
