"""Right solvers with bad habits.

They harm their process, their time or their next answer.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path as FilePath
from typing import ClassVar

import numpy as np

from dubins_study import Claim, Question, Solution, Solver
from lying_dubins.lies import honest


class Habit(Solver):
    """Answers rightly, and has a habit."""

    method = ("one NLP a word", "MINPACK hybr", "bearing")
    summary = "A right solver with a bad habit, to try the conformance kit on"

    def solve(self, question: Question, limit: float) -> Solution:
        self.habit()
        return honest(question.scenario)

    def habit(self) -> None:
        """What it does beside answering."""


class Moves(Habit):
    name = "moves"

    def habit(self) -> None:
        os.chdir("/")


class Tells(Habit):
    """Prints, and promises not to."""

    name = "tells"
    keeps_limit = True

    def habit(self) -> None:
        print("iteration 1 of 1")


class Litters(Habit):
    name = "litters"

    def habit(self) -> None:
        FilePath("model.lp").write_text("minimise\n")


class Shouts(Habit):
    """Changes how numpy treats errors, for everyone."""

    name = "shouts"

    def habit(self) -> None:
        np.seterr(all="raise")


class Sets(Habit):
    name = "sets"

    def habit(self) -> None:
        os.environ["DUBINS_QUESTIONS"] = str(time.monotonic())


class Leaves(Habit):
    """A thread for each question, which goes on."""

    name = "leaves"

    def habit(self) -> None:
        threading.Thread(target=time.sleep, args=(600,), daemon=True).start()


class Spawns(Habit):
    """A process for each question, which goes on."""

    name = "spawns"

    def habit(self) -> None:
        subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])


class Late(Habit):
    """Promises to keep its limit, and takes two seconds."""

    name = "late"
    keeps_limit = True

    def habit(self) -> None:
        time.sleep(2)


class Remembers(Habit):
    """Is sure of its first answer only."""

    name = "remembers"
    _asked: ClassVar[list[Question]] = []

    def solve(self, question: Question, limit: float) -> Solution:
        answer = honest(question.scenario)
        self._asked.append(question)
        return answer if len(self._asked) == 1 else replace(answer, claim=Claim.FEASIBLE)


class Keeps(Habit):
    """Keeps its answers by the target alone."""

    name = "keeps"
    _answers: ClassVar[dict[tuple[float, float], Solution]] = {}

    def solve(self, question: Question, limit: float) -> Solution:
        s = question.scenario
        target = s.target_x, s.target_y
        answer = self._answers.setdefault(target, honest(s))
        if answer.path is None:
            return answer
        return replace(answer, path=replace(answer.path, start=s.start))


class KeepsSets(Habit):
    """Keeps its answers by the set of points.

    Their order is ignored.
    """

    name = "keeps-sets"
    takes = frozenset({"free final heading", "via points"})
    _answers: ClassVar[dict[tuple[object, ...], Solution]] = {}

    def solve(self, question: Question, limit: float) -> Solution:
        s = question.scenario
        rest = s.start, s.target_x, s.target_y, s.radius
        return self._answers.setdefault((frozenset(s.via), *rest), honest(s))


class Gambles(Habit):
    """Cuts its first arc in two where chance says."""

    name = "gambles"

    def solve(self, question: Question, limit: float) -> Solution:
        answer = honest(question.scenario)
        if answer.path is None:
            return answer
        share = np.random.default_rng().uniform(0.1, 0.9)
        first, *rest = answer.path.lengths
        curvature = np.insert(answer.path.curvatures, 0, answer.path.curvatures[0])
        length = np.array([share * first, (1 - share) * first, *rest])
        return replace(answer, path=replace(answer.path, curvatures=curvature, lengths=length))


class Unsure(Habit):
    """Raises where it is asked whether it can run."""

    name = "unsure"

    def unavailable(self) -> str | None:
        raise OSError("no licence server")


class Breaks(Habit):
    """Declares an unknown word and an unknown guarantee."""

    name = "breaks"
    branches = ("best", "LSLS")
    guarantee = "perfect"
