"""Plug-ins that print, lie, fail or cannot run.

They are asked by commands, which have to say so.
"""

import os
import time

from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Solution
from dubins_study.study.path import Path
from dubins_study.study.words import Claim

print("loaded")


class Loud(Analytic):
    """Prints from Python and from below it."""

    def solve(self, model, limit):
        print("from Python")
        os.write(1, b"from below")
        return super().solve(model, limit)


class Liar(Analytic):
    """Claims that a wrong path is optimal."""

    def solve(self, model, limit):
        return Solution(Claim.OPTIMAL, Path(super().solve(model, limit).path.start, [0], [1]))


class Absent(Analytic):
    """Cannot run here."""

    def unavailable(self):
        return "no licence"


class Full(Analytic):
    """Runs out of memory."""

    def solve(self, model, limit):
        raise MemoryError


class Gone(Analytic):
    """Ends its process."""

    def solve(self, model, limit):
        os._exit(3)


class Stuck(Analytic):
    """Does not end for hours."""

    def solve(self, model, limit):
        time.sleep(1e4)
