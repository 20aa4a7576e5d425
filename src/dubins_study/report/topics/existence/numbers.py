"""How solvers recognise that no path exists, and how often they deny one that does."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.elements.shares import with_share
from dubins_study.report.statistics.intervals import bootstrap, medians
from dubins_study.report.statistics.methods import methods_of
from dubins_study.report.statistics.metrics import presolved

# Scenarios that a bootstrap interval is of, at most: more would take memory and change nothing.
MOST_SCENARIOS = 2000
_ANSWERS = ("right", "silent", "wrong")


def existence(counts: pd.DataFrame, methods: pd.DataFrame) -> pd.DataFrame:
    """One row per solver that was asked a question without a path, or that denied a path.

    Args:
        counts: from `report.data.verdicts.existence`.
        methods: from `report.data.verdicts.methods`.

    Returns:
        The columns of both; reached (questions without a path that reached the engine); those of
        `with_share` for right, silent and wrong, shares of `reached`, and for denied, a share of
        the questions that have a path; in the order of `methods_of`.
    """
    frame = methods_of(methods).join(counts.set_index("solver")).reset_index()
    frame["reached"] = frame[list(_ANSWERS)].sum(axis="columns").round(6)
    for name in _ANSWERS:
        frame = with_share(frame, name, frame[name], frame["reached"])
    frame = with_share(frame, "denied", frame["denied"], frame["questions"])
    asked = (frame[["reached", "presolved"]] > 0).any(axis="columns")
    return frame[asked | (frame["denied"] > 0)].reset_index(drop=True)


def engine_times(rows: pd.DataFrame) -> pd.DataFrame:
    """Median time of the attempts at questions without a path that reached an engine.

    The interval is a bootstrap over scenarios, of at most `MOST_SCENARIOS`, which are drawn by the
    hashes that name them.

    Returns:
        One row per solver: solver, estimate, low, high (s), of the medians over repeats.
    """
    reached = ~rows["answerable"] & ~presolved(rows)
    reached &= ~rows["outcome"].isin(["unsupported", "unavailable"])
    chosen = rows[reached]
    scenarios = np.sort(chosen["scenario_id"].unique())[:MOST_SCENARIOS]
    chosen = chosen[chosen["scenario_id"].isin(scenarios)]
    if chosen.empty:
        return pd.DataFrame(columns=["solver", "estimate", "low", "high"])
    question = ["scenario_id", "experiment", "branch", "initial_guess"]
    table = chosen.groupby([*question, "solver"])["wall_s"].median().unstack("solver")
    table.index = table.index.get_level_values("scenario_id")
    return bootstrap(table, medians).reset_index()
