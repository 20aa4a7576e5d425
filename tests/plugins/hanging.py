"""Plug-ins for `test_limits` that harm their process."""

import ctypes
import os
import signal
from dataclasses import dataclass

from dubins_study import Claim, Solution, solve
from dubins_study.solvers.analytic import Analytic


@dataclass(frozen=True)
class Base(Analytic):
    """Answers with the closed form.

    No plug-in inherits its promise.
    """

    name = "base"
    solve_frame = None

    def solve(self, model, limit):
        return super().solve(model, limit)


class Sleeps(Base):
    """Sleeps with the interpreter's lock.

    It behaves like a library that looks at no time.
    """

    def solve(self, model, limit):
        ctypes.PyDLL(None).sleep(1000)


class Spins(Base):
    def solve(self, model, limit):
        while True:
            pass


class Dies(Base):
    def solve(self, model, limit):
        os.kill(os.getpid(), signal.SIGKILL)


class Repeats(Base):
    """Answers with the initial guess.

    The message names the process.
    """

    warm = True

    def solve(self, model, limit):
        guess = model.initial_guess
        return Solution(Claim.FEASIBLE, guess, message=f"process {os.getpid()}")


class Promises(Repeats):
    keeps_limit = True


class Moody(Repeats):
    """Hangs where the target lies behind."""

    def solve(self, model, limit):
        while model.scenario.target_x < 0:
            pass
        return super().solve(model, limit)


class Asks(Base):
    """Asks other solvers in workers of their own."""

    def solve(self, model, limit):
        spec = f"{__file__}:Spins"
        inner = solve(model.scenario, spec, limit=0.5)
        outer = solve(model.scenario, "slsqp", isolated=True)
        return Solution(Claim.LOCAL, outer.path, message=f"{inner.outcome}, {outer.outcome}")
