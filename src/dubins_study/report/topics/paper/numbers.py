"""The paper's problems: paths, the printed cells next to ours, every solver's score."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from decimal import Decimal
from typing import Any

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.paper.printed import PRINTED, QUANTITIES, TIMES, compare
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.study.path import Path

TICK_S = 1 / 64  # of the clock that the paper's solve times were read from
_MISPRINTED = ("misprint", "differs")
# Decimals of exact lengths; a double below 100 has no more than the latter.
_PLACES, _MOST_PLACES = 6, 17
_HALF = Decimal("0.005")  # of the last decimal that the paper prints


def word_paths(results: Results, solver: str) -> dict[tuple[str, str], Path]:
    """(label, LS or RS) -> a solver's path, from its first attempt at each of the paper's words."""
    rows = results.rows
    arrived = (rows["solver"] == solver) & rows["branch"].isin(["LS", "RS"]) & rows["gap"].notna()
    first = rows[arrived].drop_duplicates(["label", "branch"])
    paths = {
        (label, branch): results.path(index)
        for index, label, branch in zip(first.index, first["label"], first["branch"], strict=True)
    }
    return {key: path for key, path in paths.items() if path is not None}


def side_by_side(cells: pd.DataFrame) -> pd.DataFrame:
    """Two rows for each printed row of one table: what the paper prints, and the exact lengths.

    Args:
        cells: the rows of one table from `report.paper.printed.compare`.

    Returns:
        Columns label, path, source (`paper` or `exact`), and one for each of `QUANTITIES`: its
        text, empty if the path does not have it.
    """
    records: list[dict[str, object]] = []
    for (label, path), group in cells.groupby(["label", "path"], sort=False):
        printed: dict[str, object] = {"label": label, "path": path, "source": "paper"}
        exact: dict[str, object] = {"label": label, "path": path, "source": "exact"}
        for cell in group.to_dict("records"):
            quantity, mark = str(cell["quantity"]), " ✗" if cell["verdict"] in _MISPRINTED else ""
            printed[quantity] = f"{cell['printed']:.2f}{mark}"
            exact[quantity] = None if pd.isna(cell["ours"]) else _exact_text(cell, bool(mark))
        records += [printed, exact]
    columns = ["label", "path", "source", *QUANTITIES]
    return pd.DataFrame.from_records(records, columns=columns).astype(object)


def _exact_text(cell: Mapping[Hashable, Any], wrong: bool) -> str:
    """The exact length with six decimals; with more if these would round to what is printed wrong.

    Of 1.73499986, six decimals are 1.735000, which looks as if 1.74 were right.
    """
    printed = Decimal(f"{cell['printed']:.2f}")
    texts = (f"{cell['ours']:.{places}f}" for places in range(_PLACES, _MOST_PLACES))
    far = (text for text in texts if abs(Decimal(text) - printed) > _HALF)
    return next(far) if wrong else f"{cell['ours']:.{_PLACES}f}"


def scores(results: Results) -> pd.DataFrame:
    """One row per solver: how it answers the printed cells.

    Columns solver, cells (number of printed cells), answered, printed (number equal to the paper's
    text), length_off and segment_off (largest errors of f and of z1, z2, z3 against the closed
    form, length unit).
    """
    rows = results.rows[results.rows["branch"].isin(["LS", "RS"])]
    exact = compare(word_paths(results, EXACT))
    turns = exact["quantity"] != "f"
    records = []
    for solver in solver_order(rows["solver"].tolist()):
        cells = compare(word_paths(results, solver))
        error = (cells["ours"] - exact["ours"]).abs()
        answered, printed = cells["ours"].notna().sum(), (cells["verdict"] == "correct").sum()
        off = error[~turns].max(), error[turns].max()
        records.append((solver, len(exact), answered, printed, *off))
    columns = ["solver", "cells", "answered", "printed", "length_off", "segment_off"]
    return pd.DataFrame.from_records(records, columns=columns)


def problem_paths(results: Results, problem: int) -> pd.DataFrame:
    """The closed form's paths that the paper's figure of one test problem shows.

    Returns:
        Columns label, branch, path, length, rank (1 the shorter of LS and RS), target_x, target_y,
        radius. For problem 5, as in the paper, only the shorter paths at its three radii.
    """
    paths = word_paths(results, EXACT)
    records = [
        {"label": label, "branch": branch, "path": path, "length": path.total_length}
        for (label, branch), path in paths.items()
        if label.startswith(f"problem {problem}")
    ]
    if not records:
        return pd.DataFrame()
    frame = pd.DataFrame(records)
    frame["rank"] = frame.groupby("label")["length"].rank(method="first")
    scenarios = results.rows.drop_duplicates("label")
    frame = frame.merge(scenarios[["label", "target_x", "target_y", "radius"]], on="label")
    return frame[frame["rank"] == 1] if problem == 5 else frame


def printed_times(results: Results) -> pd.DataFrame:
    """The solve times that the paper prints beside those of our solvers for the same path.

    Returns:
        One row per printed time and solver with a right answer, from its cold attempts at the
        paper's word; columns label, path, word, printed_s (s), ticks (of `TICK_S`), solver,
        wall_s (median, s).
    """
    rows = results.rows
    right = rows[success(rows) & (rows["initial_guess"] == "cold")]
    groups = right.groupby(["label", "branch", "solver"], observed=True)
    medians = groups["wall_s"].median().reset_index()
    words = {(row.label, row.path): row.word for row in PRINTED}
    records = []
    for time in TIMES:
        word, seconds = words[time.label, time.path], float(time.seconds)
        record = {"label": time.label, "path": time.path, "word": word, "printed_s": seconds}
        record |= {"ticks": round(seconds / TICK_S)}
        ours = medians[(medians["label"] == time.label) & (medians["branch"] == word)]
        pairs = zip(ours["solver"], ours["wall_s"], strict=True)
        records += [record | {"solver": solver, "wall_s": wall_s} for solver, wall_s in pairs]
    columns = ["label", "path", "word", "printed_s", "ticks", "solver", "wall_s"]
    return pd.DataFrame.from_records(records, columns=columns)


def time_ends(times: pd.DataFrame) -> pd.DataFrame:
    """One row per printed time, from `printed_times`, with the fastest and the slowest solver.

    Columns label, path, word, printed_s, ticks, exact_s (the closed form's time; NaN if it was not
    asked), fastest and slowest (solvers besides the closed form, None if there are none), and
    their times fastest_s and slowest_s (s).
    """
    keys = ["label", "path", "word", "printed_s", "ticks"]
    records = []
    for key, group in times.groupby(keys, sort=False):
        exact = group.loc[group["solver"] == EXACT, "wall_s"]
        others = group[group["solver"] != EXACT].sort_values("wall_s")
        record: dict[str, object] = dict(zip(keys, key, strict=True))
        record["exact_s"] = exact.iloc[0] if len(exact) else None
        for name, place in (("fastest", 0), ("slowest", -1)):
            record[name] = others["solver"].iloc[place] if len(others) else None
            record[f"{name}_s"] = others["wall_s"].iloc[place] if len(others) else None
        records.append(record)
    return pd.DataFrame.from_records(records)
