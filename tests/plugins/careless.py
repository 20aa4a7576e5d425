"""Plug-ins that answer right and leave something behind.

They change a library, leak memory or files, or fork.
"""

import itertools
import os
import sys
import time
from dataclasses import replace

import scipy.optimize

from dubins_study.solvers.analytic import Analytic

KEPT = []


class Patches(Analytic):
    """Takes a function from a library."""

    def solve(self, model, limit):
        scipy.optimize.minimize = None
        return super().solve(model, limit)


class Slips(Analytic):
    """Forks a child that falls out of `solve`."""

    def solve(self, model, limit):
        if os.fork() == 0:
            os.execv("/nonexistent", ["x"])
        os.wait()
        return super().solve(model, limit)


class Forgets(Analytic):
    """Forks; both processes go on."""

    def solve(self, model, limit):
        solution = super().solve(model, limit)
        os.fork()
        return solution


class Leaks(Analytic):
    """Keeps 150 MiB of every solve."""

    def solve(self, model, limit):
        KEPT.append(bytearray(150 * 2**20))
        return super().solve(model, limit)


class OpensFiles(Analytic):
    """Keeps 40 open files of every solve."""

    def solve(self, model, limit):
        KEPT.extend(open(os.devnull) for _ in range(40))  # noqa: PTH123, SIM115
        return super().solve(model, limit)


class Backwards(Analytic):
    """Replaces a clock by one that runs backwards.

    Libraries for tests with time, such as freezegun, replace clocks in every loaded module too.
    """

    def solve(self, model, limit):
        time.sleep(0.2)  # so that the machine's speed is measured meanwhile
        _replace("perf_counter", [5.0, 3.0, 1.0])
        return super().solve(model, limit)


def _replace(name, values):
    clock = itertools.cycle(values).__next__
    for module in list(sys.modules.values()):
        if name in vars(module) and module is not time:
            setattr(module, name, clock)


class HeldUp(Analytic):
    """Names its process; slow where the label says so."""

    def solve(self, model, limit):
        if model.scenario.label == "slow":
            time.sleep(1)
        solution = super().solve(model, limit)
        return replace(solution, message=str(os.getpid()))
