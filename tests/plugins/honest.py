"""Plug-ins that keep their promises.

They are slow or quick, and tell what they notice.
"""

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from dubins_study.solvers.analytic import Analytic


class Honest(Analytic):
    """The closed form under another name.

    It is right at once, the same every time.
    """

    name: ClassVar[str] = "honest"


@dataclass(frozen=True)
class Napping(Honest):
    """Answer right after a nap.

    It appends a line with its process id to a file when it begins.
    """

    name: ClassVar[str] = "napping"
    nap: float = 0.05
    note: str = ""

    def solve(self, model, limit):
        if self.note and model.scenario.label != "warm-up":
            with Path(self.note).open("a") as file:
                file.write(f"{os.getpid()}\n")
        if model.scenario.label != "warm-up":
            time.sleep(self.nap)
        return super().solve(model, limit)
