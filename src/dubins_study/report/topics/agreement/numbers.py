"""The distance between two solvers' answers to the same question."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import FloatArray, Path

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


def agreement(
    rows: pd.DataFrame,
    path_of: Callable[[int], Path | None],
    order: Sequence[str] | None = None,
) -> pd.DataFrame:
    """One row per pair of solvers.

    Args:
        rows: attempts.
        path_of: index of a row -> its path.
        order: of the solvers; None: that of all tables of solvers.

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
    apart = _distances(index, path_of)
    column = {solver: place for place, solver in enumerate(index.columns)}
    solvers = [name for name in order or solver_order(list(column)) if name in column]
    records = []
    for first, second in combinations(solvers, 2):
        present = length[[first, second]].notna().all(axis=1).to_numpy()
        both = length.loc[present, [first, second]]
        over = scale.loc[both.index].to_numpy()
        difference = (both[first] - both[second]).abs() / over
        distance = pd.Series(apart[present, column[first], column[second]] / over, dtype=float)
        questions = int((posed[first] & posed[second]).sum())
        within = (difference <= CLOSE).mean()
        measures = (
            *(difference.median(), difference.max(), within),
            *(distance.median(), distance.max()),
        )
        records.append((first, second, questions, len(both), *measures))
    return pd.DataFrame.from_records(records, columns=list(_COLUMNS))


def _distances(index: pd.DataFrame, path_of: Callable[[int], Path | None]) -> FloatArray:
    """Largest distance at equal arc length of every two answers to a question.

    All answers to a question are looked at in the same places, up to the end of the longest; where
    one has ended it waits at its end.

    Args:
        index: questions by solvers: the row of the answer, NaN if it does not arrive.
        path_of: index of a row -> its path.
    Returns:
        Shape (questions, solvers, solvers), length unit; NaN where an answer is missing.
    """
    solvers = index.shape[1]
    apart = np.full((len(index), solvers, solvers), np.nan)
    for place, rows in enumerate(index.to_numpy(dtype=np.float64)):
        present = np.flatnonzero(~np.isnan(rows))
        paths = [path_of(int(row)) for row in rows[present]]
        known = [path for path in paths if path is not None]
        assert len(known) == len(paths)  # all have a gap, so all have a path
        if len(known) < 2:
            continue
        along = np.linspace(0.0, max(path.total_length for path in known), _SAMPLES)
        points = np.stack([path.at(along)[:, :2] for path in known])
        offsets = points[:, np.newaxis] - points
        largest = np.hypot(offsets[..., 0], offsets[..., 1]).max(axis=-1)
        apart[place][np.ix_(present, present)] = largest
    return apart
