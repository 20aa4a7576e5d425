"""Plug-ins that change what a process shares.

A witness tells what reached it.
"""

import atexit
import gc
import locale
import os
import random
import signal
import sys
import threading
import time
import warnings
from contextlib import suppress
from dataclasses import replace
from multiprocessing.util import Finalize
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_info, threadpool_limits

from dubins_study.solvers.analytic import Analytic

SEED = 424242


def _seed():
    random.seed(SEED)
    np.random.seed(SEED)  # noqa: NPY002


def _burn():
    def burn():
        while True:
            pass

    threading.Thread(target=burn, name="faults-burner").start()


def _seeded():
    state = random.Random(SEED).getstate()[1][:9]
    legacy = np.random.get_state()  # noqa: NPY002
    return random.getstate()[1][:9] == state or legacy[1][0] == SEED


def _unprintable():
    """Whether stdout is gone or was redirected.

    Redirected means that it leads to the file that a solver opened.
    """
    try:
        return os.fstat(1).st_rdev == Path("/dev/zero").stat().st_rdev
    except OSError:
        return True


def _named(name):
    return any(thread.name == name for thread in threading.enumerate())


# what is changed, how, and how one sees that it is
STATES = {
    "seed": (_seed, _seeded),
    "warnings": (
        lambda: warnings.simplefilter("error", FutureWarning),
        lambda: ("error", None, FutureWarning, None, 0) in warnings.filters,
    ),
    "cwd": (lambda: os.chdir("/proc"), lambda: os.getcwd() == "/proc"),  # noqa: PTH109
    "environ": (
        lambda: os.environ.update(FAULTS_TAINT="1", OMP_NUM_THREADS="7", PATH="/nowhere"),
        lambda: "FAULTS_TAINT" in os.environ or os.environ.get("PATH") == "/nowhere",
    ),
    "seterr": (lambda: np.seterr(all="raise"), lambda: np.geterr()["under"] == "raise"),
    "threads": (
        lambda: threadpool_limits(3),
        lambda: any(pool["num_threads"] == 3 for pool in threadpool_info()),
    ),
    "signals": (
        lambda: signal.signal(signal.SIGUSR1, signal.SIG_IGN),
        lambda: signal.getsignal(signal.SIGUSR1) == signal.SIG_IGN,
    ),
    "alarm": (
        lambda: signal.setitimer(signal.ITIMER_REAL, 3600),
        lambda: signal.getitimer(signal.ITIMER_REAL)[0] > 0,
    ),
    "locale": (
        lambda: locale.setlocale(locale.LC_ALL, "C"),
        lambda: locale.setlocale(locale.LC_CTYPE) == "C",
    ),
    "recursion": (lambda: sys.setrecursionlimit(345), lambda: sys.getrecursionlimit() == 345),
    "sys.path": (lambda: sys.path.insert(0, "/faults"), lambda: "/faults" in sys.path),
    "gc": (gc.disable, lambda: not gc.isenabled()),
    "thread": (_burn, lambda: _named("faults-burner")),
    "closed": (lambda: os.close(1), _unprintable),
    "opened": (lambda: os.dup2(os.open("/dev/zero", os.O_RDWR), 1), _unprintable),
    "stdout": (lambda: setattr(sys, "stdout", None), lambda: sys.stdout is None),
}
if len(os.sched_getaffinity(0)) > 1:  # of one core none can be taken away
    STATES["affinity"] = (
        lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))}),
        lambda: len(os.sched_getaffinity(0)) == 1,
    )


class Tainting(Analytic):
    """Changes one thing at each question, and answers right."""

    def solve(self, model, limit):
        solution = super().solve(model, limit)
        if model.scenario.label != "warm-up":
            number = round((model.scenario.target_x - 2.0) / 7.0 * (len(STATES) - 1))
            list(STATES.values())[number][0]()
        return solution


class Witness(Analytic):
    """Answers right, and says what it found changed."""

    def solve(self, model, limit):
        solution = super().solve(model, limit)
        changes = [name for name, (_, changed) in STATES.items() if changed()]
        return replace(solution, message=" ".join(changes))


class HangsAtExit(Analytic):
    """The worker has an end that does not end."""

    def solve(self, model, limit):
        atexit.register(time.sleep, 3600)
        Finalize(None, time.sleep, args=(3600,), exitpriority=100)
        threading.Thread(target=time.sleep, args=(3600,)).start()
        return super().solve(model, limit)


class ClosesStandard(Analytic):
    """Closes stdin, stdout and stderr."""

    def solve(self, model, limit):
        for fd in (0, 1, 2):
            with suppress(OSError):  # closed already
                os.close(fd)
        return super().solve(model, limit)


class ClosesAll(Analytic):
    """Closes all open files above, and so its pipe.

    The pipe is the way back to whoever asked.
    """

    def solve(self, model, limit):
        os.closerange(3, 4096)
        return super().solve(model, limit)


class Floods(Analytic):
    """Writes a quarter of a GB to both streams.

    They are stdout and stderr, in Python and in C.
    """

    def solve(self, model, limit):
        line = "flood " * 2**17 + "\n"
        for _ in range(96):
            print(line)
            os.write(1, line.encode())
            os.write(2, line.encode())
        return super().solve(model, limit)


class ReadsStdin(Analytic):
    """Asks the user something."""

    def solve(self, model, limit):
        try:
            input("licence key? ")
        except EOFError:
            return super().solve(model, limit)
