"""Plug-ins that answer, but with nonsense or lies."""

import os
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Solution
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.words import Claim


class Rude(BaseException):
    """No Exception, so that `except Exception` lets it pass."""


class Speechless(Exception):  # noqa: N818
    """Cannot even say what it is."""

    def __str__(self):
        raise ValueError("no words")

    __repr__ = __str__


class RaisesInUnavailable(Analytic):
    def unavailable(self):
        raise RuntimeError("cannot say")


# class -> what its `solve` raises
RAISED = {
    "RaisesRude": lambda: Rude("not for you"),
    "RaisesExit": lambda: SystemExit(7),
    "RaisesInterrupt": lambda: KeyboardInterrupt("from inside"),
    "RaisesSpeechless": Speechless,
    "RaisesAtLength": lambda: OSError("licence " * 2**17),
    "RaisesMarkup": lambda: OSError("\ud800 \x00 \x1b[31m <script>alert(1)</script> \r\n|`$(id)`"),
}
# class -> what its `solve` returns, given the scenario; no solution, or one that misleads
RETURNED = {
    "AnswersGenerator": lambda s: (each for each in [s]),
    "NotANumber": lambda s: Solution(
        *(Claim.OPTIMAL, Path(s.start, [np.nan, 0.0], [1.0, np.nan])),
        *(float("nan"), float("inf"), (np.nan, np.inf)),
    ),
    "Elsewhere": lambda s: Solution(Claim.OPTIMAL, Path(s.start, [0.0], [1.0]), 1.0),
    "Wordy": lambda s: Solution(Claim.OPTIMAL, shortest_path(s), message="word " * 2**18),
}


def _raising(name, error):
    def solve(self, model, limit):
        raise error()

    return type(name, (Analytic,), {"solve": solve})


def _returning(name, answer):
    return type(name, (Analytic,), {"solve": lambda self, model, limit: answer(model.scenario)})


globals().update({name: _raising(name, error) for name, error in RAISED.items()})
globals().update({name: _returning(name, answer) for name, answer in RETURNED.items()})


@dataclass(frozen=True)
class Huge(Analytic):
    """The shortest path in many pieces."""

    pieces: int = 20_000

    def solve(self, model, limit):
        path = shortest_path(model.scenario)
        k = np.repeat(path.curvatures, self.pieces)
        lengths = np.repeat(path.lengths / self.pieces, self.pieces)
        return Solution(Claim.OPTIMAL, Path(path.start, k, lengths))


class WritesFile(Analytic):
    """Leaves a file where it was started."""

    def solve(self, model, limit):
        FilePath("left-by-a-solver").write_text(str(os.getpid()))
        return super().solve(model, limit)
