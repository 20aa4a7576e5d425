"""Plug-ins whose process dies, each in its own way."""

from __future__ import annotations

import ctypes
import os
import signal
import sys

from dubins_study.solvers.analytic import Analytic


class Segfault(Analytic):
    """Reads where nothing is."""

    def solve(self, model, limit):
        ctypes.string_at(0)


class Abort(Analytic):
    """What a failed assertion in C does, last words included."""

    def solve(self, model, limit):
        os.write(2, b"hostile.c:17: Assertion `x > 0' failed.\n")
        os.abort()


class FloatingPoint(Analytic):
    """An integer divided by zero in C."""

    def solve(self, model, limit):
        os.kill(os.getpid(), signal.SIGFPE)


class Illegal(Analytic):
    """A library made for another processor."""

    def solve(self, model, limit):
        os.kill(os.getpid(), signal.SIGILL)


class Bus(Analytic):
    """A mapped file that was cut off."""

    def solve(self, model, limit):
        os.kill(os.getpid(), signal.SIGBUS)


class Killed(Analytic):
    """What the kernel does when memory runs out."""

    def solve(self, model, limit):
        os.kill(os.getpid(), signal.SIGKILL)


class Terminated(Analytic):
    """A polite end is an end as well."""

    def solve(self, model, limit):
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGTERM)


class ExitZero(Analytic):
    """Leaves as if all were well."""

    def solve(self, model, limit):
        os._exit(0)


class ExitThree(Analytic):
    """Leaves with a complaint on stdout."""

    def solve(self, model, limit):
        print("no licence for more than 3 variables", flush=True)
        os._exit(3)


class ExitInC(Analytic):
    """A library that calls exit."""

    def solve(self, model, limit):
        ctypes.CDLL(None).exit(5)


class Chatty(Analytic):
    """Says more than a row can hold before it dies."""

    def solve(self, model, limit):
        os.write(2, b"first words " + b"x" * 5000 + b" last words\n")
        os.abort()


class Unprintable(Analytic):
    """Last words that are no text."""

    def solve(self, model, limit):
        os.write(2, b"\x1b[31mred\x00\xff\xfe <script>alert(1)</script>\r\n")
        os.abort()


class Overflown(Analytic):
    """Uses the whole stack of C."""

    def solve(self, model, limit):
        sys.setrecursionlimit(10**9)
        deeper = ctypes.CFUNCTYPE(None)(lambda: deeper())
        deeper()


class SomeTimes(Analytic):
    """Dies at every third question of the sweep, by the question and not by the count."""

    def solve(self, model, limit):
        if model.scenario.label != "warm-up" and round(model.scenario.target_x * 1000) % 3 == 0:
            os.abort()
        return super().solve(model, limit)


class CrashInBuild(Analytic):
    """Dies before it is asked to solve."""

    def build(self, question):
        os.abort()


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
