"""Plug-ins that never end, by themselves or in children."""

import os
import signal
import time
from collections import deque
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path

from dubins_study.solvers.analytic import Analytic


def loop_in_c():
    """Loop in C, deaf to signals.

    It holds the interpreter's lock.
    """
    deque(repeat(None), maxlen=0)


def deaf():
    """Ignore every signal but SIGKILL and SIGSTOP.

    (Those two cannot be ignored.)
    """
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGALRM, signal.SIGXCPU):
        signal.signal(number, signal.SIG_IGN)


class Endless(Analytic):
    """Answers the warm-up question, then hangs.

    A worker asks an easy question first.
    """

    def solve(self, model, limit):
        if model.scenario.label == "warm-up":
            return super().solve(model, limit)
        return self.hang() or super().solve(model, limit)


class LoopInC(Endless):
    """Handlers in Python that never run."""

    def hang(self):
        signal.signal(signal.SIGTERM, lambda *_: None)
        signal.signal(signal.SIGINT, lambda *_: None)
        loop_in_c()


class Stubborn(Endless):
    """Catches everything that is raised into it."""

    def hang(self):
        deaf()
        while True:
            try:
                while True:
                    time.sleep(3600)
            except BaseException:
                continue


class Stopped(Endless):
    """Stops itself, as Ctrl-Z would.

    It takes no signal but SIGKILL and SIGCONT.
    """

    def hang(self):
        os.kill(os.getpid(), signal.SIGSTOP)


class OwnSession(Endless):
    """Leaves the run's session and group."""

    def hang(self):
        if os.getpid() != os.getsid(0):
            os.setsid()
        loop_in_c()


@dataclass(frozen=True)
class ForkTwo(Endless):
    """Loops, and so do its two children.

    One child is in a session of its own.
    """

    pids: str = ""

    def hang(self):
        loop_in_two_children(self.pids, ignore_signals=True)
        note(self.pids)
        loop_in_c()


@dataclass(frozen=True)
class ForkAndDie(Endless):
    """Crashes at once and leaves two looping children."""

    pids: str = ""

    def hang(self):
        loop_in_two_children(self.pids)
        time.sleep(0.2)
        os.abort()


@dataclass(frozen=True)
class Daemon(Endless):
    """Answers, and leaves a grandchild behind.

    The grandchild is in its own session, and its parent is gone.
    """

    pids: str = ""

    def hang(self):
        child = os.fork()
        if child == 0:
            os.setsid()
            if os.fork() == 0:
                deaf()
                note(self.pids)
                for fd in range(3, 256):
                    try:
                        os.close(fd)
                    except OSError:
                        continue
                time.sleep(3600)
            os._exit(0)
        os.waitpid(child, 0)


class Noted(Daemon):
    """Answers once the grandchild has written its process id down."""

    def hang(self):
        super().hang()
        while not (Path(self.pids).exists() and Path(self.pids).read_text()):
            time.sleep(0.01)


class LoopInWarmUp(Analytic):
    """Never ends the first question; answers the others."""

    def solve(self, model, limit):
        if model.scenario.label == "warm-up":
            loop_in_c()
        return super().solve(model, limit)


class LoopAlways(Analytic):
    """Never ends a question, the first one included."""

    def solve(self, model, limit):
        loop_in_c()


class LoopInUnavailable(Analytic):
    """Never says whether it is there."""

    def unavailable(self):
        loop_in_c()


def loop_in_two_children(file: str, ignore_signals: bool = False) -> None:
    """Fork two children that loop.

    The second is in a session of its own.
    """
    for own_session in (False, True):
        if os.fork() == 0:
            try:
                if own_session:
                    os.setsid()
                if ignore_signals:
                    deaf()
                note(file)
                loop_in_c()
            finally:
                os._exit(1)


def note(file: str, pid: int | None = None) -> None:
    """Tell the test which process this is."""
    with Path(file).open("a") as stream:
        stream.write(f"{pid or os.getpid()}\n")
