"""Plug-ins that want all the memory; each stops at 5 GiB, should nobody stop it."""

from __future__ import annotations

import os
import time

import numpy as np

from solvers.analytic import Analytic

GIB = 2**30


class Creeping(Analytic):
    """1 GiB a second, every page touched."""

    def solve(self, model, limit):
        kept = []
        for _ in range(5 * 16):
            kept.append(np.ones(GIB // 16, np.uint8))
            time.sleep(1 / 16)
        os._exit(9)


class Sudden(Analytic):
    """All at once, in one call of C."""

    def solve(self, model, limit):
        kept = np.ones(5 * GIB, np.uint8)
        os._exit(int(kept[0]) + 8)


class InChild(Analytic):
    """The worker stays small; its child does not."""

    def solve(self, model, limit):
        child = os.fork()
        if child == 0:
            os.setsid()
            kept = [np.ones(GIB // 4, np.uint8) for _ in range(20)]
            os._exit(len(kept))
        os.waitpid(child, 0)
        os._exit(9)


class Refused(Analytic):
    """Asks for what no machine has."""

    def solve(self, model, limit):
        return np.ones(2**60, np.uint8)


class OutOfMemory(Analytic):
    """Says by itself that there is no more."""

    def solve(self, model, limit):
        raise MemoryError("the tree of nodes does not fit")


class Modest(Analytic):
    """Takes half a GiB and gives it back: no reason to be stopped."""

    def solve(self, model, limit):
        np.ones(GIB // 2, np.uint8)
        return super().solve(model, limit)
