"""One start and target at many turning radii: lengths, words and times."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT, SUCCESSES
from dubins_study.report.statistics.metrics import by_solver, circle_radius, runs_of
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario

_FEWEST_RADII = 4  # fewer do not show a curve
_PLACE = ["x", "y", "heading", "target_x", "target_y"]
_SINGLE_WORDS = ("LS", "RS")
VISIBLE = 0.01  # relative; an answer that is longer by less lies on the line of the shortest ones


class Span(NamedTuple):
    """A range of radii with one shortest word."""

    word: str
    left: float  # radius
    right: float
    first: int  # row of `Sweep.shortest`
    past: int  # the row after the last


@dataclass(frozen=True, eq=False)
class Sweep:
    """What the figure of one sweep draws; lengths and radii in the scenario's unit."""

    label: str  # of its scenarios
    circle: float  # the radius at which a turning circle passes through the target, R*
    shortest: pd.DataFrame  # radius, length, word; one row per radius, rising
    spans: tuple[Span, ...]  # of the words, by rising radius
    single_words: pd.DataFrame  # word, radius, length (NaN where the word does not exist)
    wrong: pd.DataFrame  # solver, radius, length, arrives; the answers that are visibly wrong
    times: pd.DataFrame  # solver, radius, wall_s (median of cold attempts, s; NaN where none)


def sweep_rows(rows: pd.DataFrame) -> dict[tuple[str, str], pd.DataFrame]:
    """(experiment, label) -> rows, for each label with one start and target at many radii."""
    best = rows[rows["branch"] == "best"]
    groups = best.groupby(["experiment", "label"], sort=True)
    return {
        (str(experiment), str(label)): group
        for (experiment, label), group in groups
        if group.loc[group["reference_word"].notna(), "radius"].nunique() >= _FEWEST_RADII
        and len(group[_PLACE].drop_duplicates()) == 1
    }


def sweep(label: str, rows: pd.DataFrame) -> Sweep:
    """The sweep of some rows of `sweep_rows`."""
    first = rows.iloc[0]
    line = _shortest(rows)
    missed = ~rows["verdict"].isin(SUCCESSES)
    wrong = rows[missed & ~(rows["gap"] <= VISIBLE)]
    return Sweep(
        label,
        circle_radius(*(first[key] for key in _PLACE)),
        line,
        _spans(line),
        single_words(first, line["radius"].min(), line["radius"].max()),
        wrong[["solver", "radius", "length"]].assign(arrives=wrong["gap"].notna()),
        _times(rows, line["radius"]),
    )


def _times(rows: pd.DataFrame, radii: pd.Series) -> pd.DataFrame:
    """One row per solver and radius, so that a curve breaks where a solver was not asked."""
    medians = cold(rows).groupby(["solver", "radius"], observed=True)["wall_s"].median()
    solvers = medians.index.unique("solver")
    every = pd.MultiIndex.from_product([solvers, radii], names=["solver", "radius"])
    return medians.reindex(every).reset_index()


def cold(rows: pd.DataFrame) -> pd.DataFrame:
    """The cold attempts; all of them if there are none."""
    chosen = rows[rows["initial_guess"] == "cold"]
    return chosen if len(chosen) else rows


def answers(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: how its answers along the sweeps are wrong.

    Columns solver, attempts, right, little (longer by at most `VISIBLE`), longer (by more), lost
    (no path that arrives), most (largest gap of a path that arrives).
    """
    right = rows["verdict"].isin(SUCCESSES)
    little = ~right & (rows["gap"] <= VISIBLE)
    lost = ~right & rows["gap"].isna()
    kinds = {"right": right, "little": little, "longer": ~right & ~little & ~lost, "lost": lost}
    groups = rows.assign(**kinds).groupby("solver", observed=True)
    frame = groups[list(kinds)].sum().assign(attempts=groups.size(), most=groups["gap"].max())
    return by_solver(frame.reset_index())


def _shortest(rows: pd.DataFrame) -> pd.DataFrame:
    """Word and length at each radius; the length is the closed form's answer where there is one."""
    known = rows[rows["reference_word"].notna()].sort_values("radius").drop_duplicates("radius")
    exact = rows[rows["solver"] == EXACT].drop_duplicates("radius").set_index("radius")["length"]
    length = known["radius"].map(exact).fillna(known["reference"]).astype(float)
    frame = pd.DataFrame(
        {"radius": known["radius"], "length": length, "word": known["reference_word"]}
    )
    return frame.reset_index(drop=True)


def _spans(line: pd.DataFrame) -> tuple[Span, ...]:
    """Where each word is the shortest: it changes at the geometric mean of two radii."""
    radii = line["radius"].tolist()
    spans = []
    for first, past, word in runs_of(line["word"].tolist()):
        left = radii[0] if first == 0 else math.sqrt(radii[first - 1] * radii[first])
        right = radii[-1] if past == len(radii) else math.sqrt(radii[past - 1] * radii[past])
        spans.append(Span(word, left, right, first, past))
    return tuple(spans)


def single_words(row: pd.Series, low: float, high: float) -> pd.DataFrame:
    """The lengths of LS and RS at radii from `low` to `high`, for the start and target of a row."""
    radii = np.geomspace(low, high, 300)
    where: dict[str, Any] = {key: float(row[key]) for key in _PLACE}
    records = []
    for word in _SINGLE_WORDS:
        for radius in radii:
            path = shortest(Scenario(**where, radius=radius), word)
            records.append((word, radius, math.nan if path is None else path.total * radius))
    return pd.DataFrame.from_records(records, columns=["word", "radius", "length"])
