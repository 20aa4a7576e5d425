"""Plug-ins that turn on their kin: parent, group, siblings. Each deserves a run of its own."""

from __future__ import annotations

import os
import signal

from dubins_study.solvers.analytic import Analytic


class KillsGroup(Analytic):
    """Kills its whole process group."""

    def solve(self, model, limit):
        os.killpg(0, signal.SIGKILL)


class InterruptsGroup(Analytic):
    """Sends its group what Ctrl-C sends."""

    def solve(self, model, limit):
        os.killpg(0, signal.SIGINT)
        return super().solve(model, limit)
