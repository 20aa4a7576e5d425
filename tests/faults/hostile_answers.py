"""Plug-ins that answer, but with nonsense, lies or traps."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Solution
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose
from dubins_study.study.words import Claim


class Rude(BaseException):
    """No Exception, so that `except Exception` lets it pass."""


class Speechless(Exception):  # noqa: N818
    """Cannot even say what it is."""

    def __str__(self):
        raise ValueError("no words")

    __repr__ = __str__


class RaisesRude(Analytic):
    def solve(self, model, limit):
        raise Rude("not for you")


class RaisesExit(Analytic):
    def solve(self, model, limit):
        raise SystemExit(7)


class RaisesInterrupt(Analytic):
    def solve(self, model, limit):
        raise KeyboardInterrupt("from inside")


class RaisesSpeechless(Analytic):
    def solve(self, model, limit):
        raise Speechless


class RaisesAtLength(Analytic):
    def solve(self, model, limit):
        raise OSError("licence " * 2**17)


class RaisesMarkup(Analytic):
    def solve(self, model, limit):
        raise OSError("\ud800 \x00 \x1b[31m <script>alert(1)</script> \r\n|`$(id)`")


class RaisesGroup(Analytic):
    def solve(self, model, limit):
        raise ExceptionGroup("several", [OSError("a"), ValueError("b")])


class RaisesInBuild(Analytic):
    def build(self, question):
        raise RuntimeError("cannot be translated")


class RaisesInUnavailable(Analytic):
    def unavailable(self):
        raise RuntimeError("cannot say")


class NotANumber(Analytic):
    def solve(self, model, limit):
        path = Path(model.scenario.start, [np.nan, 0.0], [1.0, np.nan])
        return Solution(Claim.OPTIMAL, path, float("nan"), float("inf"), (np.nan, np.inf))


class Infinite(Analytic):
    def solve(self, model, limit):
        return Solution(Claim.OPTIMAL, Path(model.scenario.start, [0.0], [np.inf]), -np.inf)


class Elsewhere(Analytic):
    def solve(self, model, limit):
        return Solution(Claim.OPTIMAL, Path(model.scenario.start, [0.0], [1.0]), 1.0)


class OtherStart(Analytic):
    """Drives well, from a start of its own: the straight way."""

    def solve(self, model, limit):
        s = model.scenario
        heading = np.arctan2(s.target_y - s.y, s.target_x - s.x)
        length = float(np.hypot(s.target_x - s.x, s.target_y - s.y))
        return Solution(Claim.OPTIMAL, Path(Pose(s.x, s.y, heading), [0.0], [length]), length)


class Empty(Analytic):
    def solve(self, model, limit):
        return Solution(Claim.OPTIMAL, Path(model.scenario.start, [], []))


class NoPath(Analytic):
    def solve(self, model, limit):
        return Solution(Claim.OPTIMAL, None, 3.0)


class SaysImpossible(Analytic):
    def solve(self, model, limit):
        return Solution(Claim.INFEASIBLE)


class Modest(Analytic):
    """No path and no claim: nothing to hold against it."""

    def solve(self, model, limit):
        return Solution(Claim.NONE)


class NoClaim(Analytic):
    def solve(self, model, limit):
        return Solution("superb", shortest_path(model.scenario))


class ForcedClaim(Analytic):
    """Past the check of a solution's fields."""

    def solve(self, model, limit):
        solution = super().solve(model, limit)
        object.__setattr__(solution, "claim", "superb")
        return solution


class ForcedCount(Analytic):
    def solve(self, model, limit):
        solution = super().solve(model, limit)
        object.__setattr__(solution, "iterations", "many")
        return solution


class ForcedPath(Analytic):
    """A path whose arrays do not fit one another."""

    def solve(self, model, limit):
        solution = super().solve(model, limit)
        object.__setattr__(solution.path, "length", np.zeros((3, 7)))
        return solution


class AnswersNone(Analytic):
    def solve(self, model, limit):
        return None


class AnswersText(Analytic):
    def solve(self, model, limit):
        return "optimal"


class AnswersDict(Analytic):
    def solve(self, model, limit):
        return {"claim": "optimal"}


class AnswersNumber(Analytic):
    def solve(self, model, limit):
        return 3


class AnswersGenerator(Analytic):
    def solve(self, model, limit):
        yield super().solve(model, limit)


class Liar(Path):
    """Says that it is short and ends anywhere."""

    total_length = 1.0
    end = Pose(0.0, 0.0, 0.0)
    word = lambda *_: "S"  # noqa: E731


class LyingPath(Analytic):
    def solve(self, model, limit):
        return Solution(Claim.OPTIMAL, Liar(model.scenario.start, [0.0], [1.0]), 1.0)


class Easier(Analytic):
    """Halves the radius of the question, and answers that."""

    def solve(self, model, limit):
        object.__setattr__(model.scenario, "radius", model.scenario.radius / 2)
        return super().solve(model, limit)


class Trap(str):
    """A text that runs a program in whoever unpickles it."""

    __slots__ = ("file",)

    def __str__(self):
        return self

    def __reduce__(self):
        code = f"open({self.file!r}, 'a').write('sprung')"
        return exec, (code,)


@dataclass(frozen=True)
class Trapped(Analytic):
    """Its message is a trap; in turn by the constructor and past it."""

    sprung: str = ""

    def solve(self, model, limit):
        trap = Trap("hello")
        trap.file = self.sprung
        solution = super().solve(model, limit)
        path = solution.path
        if round(model.scenario.target_x) % 2:
            return Solution(solution.claim, path, native_status=trap, message=trap)
        object.__setattr__(solution, "message", trap)
        return solution


@dataclass(frozen=True)
class TrappedError(Analytic):
    """An exception whose type and arguments are traps."""

    sprung: str = ""

    def solve(self, model, limit):
        trap = Trap("hello")
        trap.file = self.sprung

        class Sprung(Exception):  # noqa: N818
            __reduce__ = trap.__reduce__

        raise Sprung(trap)


@dataclass(frozen=True)
class TrappedReturn(Analytic):
    """Something else than a solution, which is a trap."""

    sprung: str = ""

    def solve(self, model, limit):
        trap = Trap("hello")
        trap.file = self.sprung
        return trap


@dataclass(frozen=True)
class Huge(Analytic):
    """The shortest path in many pieces."""

    pieces: int = 20_000

    def solve(self, model, limit):
        path = shortest_path(model.scenario)
        k = np.repeat(path.curvature, self.pieces)
        lengths = np.repeat(path.length / self.pieces, self.pieces)
        return Solution(Claim.OPTIMAL, Path(path.start, k, lengths))


class Wordy(Analytic):
    """A megabyte of message beside a right answer."""

    def solve(self, model, limit):
        solution = super().solve(model, limit)
        return Solution(solution.claim, solution.path, message="word " * 2**18)


class WritesFile(Analytic):
    """Leaves a file where it was started."""

    def solve(self, model, limit):
        FilePath("left-by-a-solver").write_text(str(os.getpid()))
        return super().solve(model, limit)
