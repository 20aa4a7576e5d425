"""Plug-ins whose process dies, each in its own way."""

import ctypes
import os
import signal
import sys

from dubins_study.solvers.analytic import Analytic


def _abort(last_words=b""):
    os.write(2, last_words)
    os.abort()


def _complain():
    print("no licence for more than 3 variables", flush=True)
    os._exit(3)


def _overflow():
    """Use the whole stack of C."""
    sys.setrecursionlimit(10**9)
    deeper = ctypes.CFUNCTYPE(None)(lambda: deeper())
    deeper()


# class -> how its process dies when it is to solve
DEATHS = {
    "Segfault": lambda: ctypes.string_at(0),
    "Abort": lambda: _abort(b"hostile.c:17: Assertion `x > 0' failed.\n"),
    "Killed": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "ExitZero": lambda: os._exit(0),
    "ExitThree": _complain,
    "ExitInC": lambda: ctypes.CDLL(None).exit(5),
    "Chatty": lambda: _abort(b"first words " + b"x" * 5000 + b" last words\n"),
    "Unprintable": lambda: _abort(b"\x1b[31mred\x00\xff\xfe <script>alert(1)</script>\r\n"),
    "Overflown": _overflow,
}


def _solver(name, die):
    return type(name, (Analytic,), {"solve": lambda self, model, limit: die()})


globals().update({name: _solver(name, die) for name, die in DEATHS.items()})


class SomeTimes(Analytic):
    """Dies at every third question of the sweep.

    The question decides, not the count.
    """

    def solve(self, model, limit):
        if model.scenario.label != "warm-up" and round(model.scenario.target_x * 1000) % 3 == 0:
            os.abort()
        return super().solve(model, limit)


class CrashInUnavailable(Analytic):
    """Dies when asked whether it is there."""

    def unavailable(self):
        os.abort()


class Missing(Analytic):
    """Says that it cannot run here."""

    def unavailable(self):
        return "no licence on this machine"


class Narrow(Analytic):
    """Answers one branch only."""

    branches = ("RL",)
