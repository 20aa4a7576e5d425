"""Plug-ins that want all the memory.

Each stops at 5 GiB, should nobody stop it.
"""

import os
import time

import numpy as np

from dubins_study.solvers.analytic import Analytic

GIB = 2**30


class Greedy(Analytic):
    """Answers the warm-up question, then takes memory.

    A worker asks an easy question first.
    """

    def solve(self, model, limit):
        if model.scenario.label != "warm-up":
            self.take()
        return super().solve(model, limit)


class Creeping(Greedy):
    """1 GiB a second, every page touched."""

    def take(self):
        memory = []
        for _ in range(5 * 16):
            memory.append(np.ones(GIB // 16, np.uint8))
            time.sleep(1 / 16)
        os._exit(9)


class Sudden(Greedy):
    """All at once, in one call of C."""

    def take(self):
        memory = np.ones(5 * GIB, np.uint8)
        os._exit(int(memory[0]) + 8)


class InChildren(Greedy):
    """Takes too much memory in its children.

    The worker stays small, and so does each child; together they do not.
    """

    def take(self):
        children = []
        for _ in range(3):
            child = os.fork()
            if child == 0:
                os.setsid()
                memory = np.ones(GIB, np.uint8)
                time.sleep(60)
                os._exit(int(memory[0]))
            children.append(child)
        for child in children:
            os.waitpid(child, 0)
        os._exit(9)


class Refused(Greedy):
    """Asks for what no machine has."""

    def take(self):
        np.ones(2**60, np.uint8)


class OutOfMemory(Greedy):
    """Says by itself that there is no more."""

    def take(self):
        raise MemoryError("the tree of nodes does not fit")


class Modest(Greedy):
    """Takes half a GiB and gives it back.

    That is no reason to be stopped.
    """

    def take(self):
        np.ones(GIB // 2, np.uint8)
