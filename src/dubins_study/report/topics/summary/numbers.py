"""How often each solver is right, in all and by where its search began."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.shares import with_share
from dubins_study.report.statistics.methods import methods_of

STARTS = ("cold", "warm")


def by_start(starts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver that was asked cold and warm.

    Args:
        starts: from `report.data.verdicts.starts`.
    Returns:
        solver, and the columns of `with_share` for cold and for warm.
    """
    frame = starts[["solver"]].drop_duplicates(ignore_index=True)
    for start in STARTS:
        rows = starts[starts["initial_guess"] == start].set_index("solver")
        right, questions = (
            frame["solver"].map(rows[name]).fillna(0) for name in ("right", "questions")
        )
        frame = with_share(frame, start, right, questions)
    return frame


def summary(verdicts: pd.DataFrame, methods: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: verdicts, false claims, wrong basins and times where a path exists.

    Solvers that were asked no such question are left out, unless none was.

    Args:
        verdicts: from `report.data.verdicts.verdicts`.
        methods: from `report.data.verdicts.methods`.

    Returns:
        The columns of both, those of `methods_of`, and those of `with_share` for `right`, a share
        of the questions; in the order of `methods_of`.
    """
    asked = verdicts["questions"] > 0
    counted = verdicts[asked] if asked.any() else verdicts
    frame = with_share(counted, "right", counted["right"], counted["questions"])
    named = methods_of(methods[methods["solver"].isin(counted["solver"])])
    return named.join(frame.set_index("solver")).reset_index()
