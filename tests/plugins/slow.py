"""Plug-ins with slsqp's answers that take their time."""

import os
import time
from dataclasses import dataclass
from pathlib import Path

from dubins_study.solvers.paper_nlp.nlp import Slsqp


@dataclass(frozen=True)
class Slow(Slsqp):
    """Naps before each of its solves."""

    nap: float = 0.1  # s

    def solve(self, model, limit):
        time.sleep(self.nap)
        return super().solve(model, limit)


class Telling(Slsqp):
    """Tells when it is asked, and naps.

    It leaves the file `asked` beside its own. It takes as many seconds as the variable NAP says.
    """

    def solve(self, model, limit):
        if model.leg.question.scenario.label != "warm-up":
            Path(__file__).with_name("asked").touch()
            time.sleep(float(os.environ["NAP"]))
        return super().solve(model, limit)
