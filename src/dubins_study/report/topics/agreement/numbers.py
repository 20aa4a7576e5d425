"""The distance between two solvers' answers to the same question."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import pandas as pd

from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import Path, largest_distance

CLOSE = 1e-6
_KEY = ["experiment", "scenario_id", "branch"]
_COLUMNS = (
    *("first", "second", "questions", "both"),
    *("median", "largest", "within", "apart_median", "apart_largest"),
)
_SAMPLES = 65  # points per path; only in long paths a turn may lie between two points


def answers(rows: pd.DataFrame) -> pd.DataFrame:
    """The first cold answer of each solver to each question, if it arrives.

    Returns:
        The index of the rows; columns experiment, scenario_id, branch, solver, length, scale,
        radius, where scale is max(reference, radius).
    """
    cold = _first_cold(rows)
    arrived = cold[cold["gap"].notna()]
    scale = arrived["reference"].clip(lower=arrived["radius"])
    return arrived.assign(scale=scale)[[*_KEY, "solver", "length", "scale", "radius"]]


def _first_cold(rows: pd.DataFrame) -> pd.DataFrame:
    """For every question and solver, the cold attempt with the smallest `repeat`."""
    cold = rows[rows["initial_guess"] == "cold"].sort_values("repeat", kind="stable")
    return cold.drop_duplicates([*_KEY, "solver"])


def agreement(rows: pd.DataFrame, path_of: Callable[[int], Path | None]) -> pd.DataFrame:
    """One row per pair of solvers.

    Args:
        rows: attempts.
        path_of: index of a row -> its path.

    Returns:
        Columns first, second, questions (number put to both), both (number where both arrive),
        median and largest of |La - Lb| / max(reference, R), within (share of `both` that agree to
        1e-6), and apart_median, apart_largest: median and largest over the questions of the largest
        distance between the two paths at equal arc length, divided by the same scale.
    """
    cold = _first_cold(rows)
    posed = cold.assign(posed=True).pivot(index=_KEY, columns="solver", values="posed").notna()
    arrived = answers(rows)
    length = arrived.pivot(index=_KEY, columns="solver", values="length")
    index = arrived.reset_index(names="row").pivot(index=_KEY, columns="solver", values="row")
    # Near a circle the two answers have different references; the larger one is the scale.
    scale = arrived.groupby(_KEY)["scale"].max()
    records = []
    for first, second in combinations(solver_order(list(length.columns)), 2):
        both = length[[first, second]].dropna()
        over = scale.loc[both.index].to_numpy()
        difference = (both[first] - both[second]).abs() / over
        pairs = index.loc[both.index, [first, second]].astype(int).itertuples(index=False)
        apart = pd.Series([_apart(path_of(a), path_of(b)) for a, b in pairs], dtype=float) / over
        questions = int((posed[first] & posed[second]).sum())
        within = (difference <= CLOSE).mean()
        measures = (difference.median(), difference.max(), within, apart.median(), apart.max())
        records.append((first, second, questions, len(both), *measures))
    return pd.DataFrame.from_records(records, columns=list(_COLUMNS))


def _apart(first: Path | None, second: Path | None) -> float:
    assert first is not None  # both have a gap, so both have a path
    assert second is not None
    return largest_distance(first, second, _SAMPLES)
