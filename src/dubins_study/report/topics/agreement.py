"""How far the answers of two solvers to the same questions are apart; tables in files alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import BENCHMARK, General, Section, Show, Table, Topic
from dubins_study.report.elements.formats import count, digits, share
from dubins_study.report.statistics.methods import MOST_METHODS, best_of_formulations
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.path import FloatArray, Path

CLOSE = 1e-6
_KEY = ["experiment", "scenario_id", "branch"]
_COLUMNS = (
    *columns(kind="solver", first="solver", second="and"),
    *columns(count, questions="questions", both="both arrive"),
    *columns(digits(3), median="median", largest="largest"),
    *columns(share, within="agree to 1e-6"),
    *columns(digits(3), apart_median="paths, median", apart_largest="paths, largest"),
)
_SAMPLES = 65  # points per path; only in long paths a turn may lie between two points


def agreement(
    rows: pd.DataFrame,
    path_of: Callable[[int], Path | None],
    order: Sequence[str] | None = None,
) -> pd.DataFrame:
    """One row per pair of solvers, in an order; None: that of all tables of solvers.

    Columns first, second, questions (number put to both), both (number where both arrive), median
    and largest of |La - Lb| / max(reference, R), within (share of `both` that agree to 1e-6), and
    apart_median, apart_largest: median and largest over the questions of the largest distance
    between the two paths at equal arc length, divided by the same scale.
    """
    cold = rows[rows["initial_guess"] == "cold"].sort_values("repeat", kind="stable")
    cold = cold.drop_duplicates([*_KEY, "solver"])
    posed = cold.assign(posed=True).pivot(index=_KEY, columns="solver", values="posed").notna()
    arrived = cold[cold["gap"].notna()]
    arrived = arrived.assign(scale=arrived["reference"].clip(lower=arrived["radius"]))
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
    return pd.DataFrame.from_records(records, columns=[column.key for column in _COLUMNS])


def _distances(index: pd.DataFrame, path_of: Callable[[int], Path | None]) -> FloatArray:
    """Largest distance at equal arc length of every two answers to a question.

    All answers to a question are looked at in the same places, up to the end of the longest; where
    one has ended it waits at its end.

    The index holds the rows of the answers, questions by solvers; NaN if one does not arrive. The
    result has the shape (questions, solvers, solvers), in length units; NaN where one is missing.
    """
    solvers = index.shape[1]
    apart = np.full((len(index), solvers, solvers), np.nan)
    for place, rows in enumerate(index.to_numpy(dtype=np.float64)):
        present = np.flatnonzero(~np.isnan(rows))
        if present.size < 2:
            continue
        # An answer with a gap has a path.
        paths = [path for row in rows[present] if (path := path_of(int(row))) is not None]
        along = np.linspace(0.0, max(path.total_length for path in paths), _SAMPLES)
        points = np.stack([path.at(along)[:, :2] for path in paths])
        offsets = points[:, np.newaxis] - points
        largest = np.hypot(offsets[..., 0], offsets[..., 1]).max(axis=-1)
        apart[place][np.ix_(present, present)] = largest
    return apart


def agreement_section(results: Results) -> Section | None:
    """The table of all pairs of solvers; of many, of the best of each formulation."""
    if results.rows["solver"].nunique() > MOST_METHODS:
        return formulations_section(results)
    return _section(results, results.rows)


def formulations_section(results: Results) -> Section | None:
    """The table of the best engine, guess and settings of each formulation."""
    methods = solver_summary(results.attempts)
    best = methods.loc[methods["solver"].isin(best_of_formulations(methods)), "solver"]
    return _section(results, results.rows[results.rows["solver"].isin(best)], best.tolist())


def _section(
    results: Results, rows: pd.DataFrame, formulations: list[str] | None = None
) -> Section | None:
    """The pairs of the rows' solvers; `formulations` are those that stand for one, in order."""
    if rows["solver"].nunique() < 2:
        return None
    pairs = agreement(rows, results.path, formulations)
    pairs = pairs[pairs["questions"] > 0].reset_index(drop=True)
    if not (pairs["both"] > 0).any():
        return None
    key, title, which = "agreement", "Agreement", ""
    if formulations is not None:
        key, title = "agreement-formulations", "Agreement between formulations"
        which = " Of each formulation the method that is most surely right, the fastest of several."
    caption = (
        "Differences in length, and the largest distance between the two paths at equal arc "
        "length, both over max(reference, R). Equal lengths with distant paths are ties, or flat "
        "optima."
    )
    text = (
        "Only cold starts, the first repeat of each, and questions where both arrive; the table "
        f"says how many.{which} The check compares every answer with the shortest length already."
    )
    lead = "Its file says how far the lengths, and the paths, of two solvers are apart."
    table = Table(key, caption, pairs, _COLUMNS, show=Show.FILE)
    return Section(key, title, text, (table,), lead)


TOPIC = Topic("agreement", agreement_section, General.COMPARED)
OF_BENCHMARK = Topic("agreement of formulations", formulations_section, BENCHMARK)
