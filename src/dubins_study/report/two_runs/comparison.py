"""What a comparison of two runs says."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath

import pandas as pd

from dubins_study.report.two_runs.machine_speed import MachineSpeed


@dataclass(frozen=True, eq=False)
class Comparison:
    """What two runs have in common, and what changed.

    Args:
        solvers: one row per solver; columns of `report.two_runs.numbers.solver_changes`.
        regressions: what became worse, with the scenario and the command that repeats it; columns
            of `report.two_runs.regressions.regressions`.
        unpaired: solver, and how many questions only one of the runs was asked.
        differences: what, base, new: what else the runs differ in.
        speed: of the new run's machine by the base's; None if nothing says it.
        slower: how many times as long counts as slower.
        page: the page that was written; None if none was asked for.
    """

    solvers: pd.DataFrame
    regressions: pd.DataFrame
    unpaired: pd.DataFrame
    differences: pd.DataFrame
    speed: MachineSpeed | None
    slower: float
    page: FilePath | None = None

    @property
    def regressed(self) -> bool:
        """Whether anything became worse."""
        return not self.regressions.empty
