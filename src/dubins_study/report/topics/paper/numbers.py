"""The paper's problems: paths, the printed cells next to ours, every solver's score."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.paper.printed import QUANTITIES, compare
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import Path

_MISPRINTED = ("misprint", "differs")


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
            exact[quantity] = None if pd.isna(cell["ours"]) else f"{cell['ours']:.6f}"
        records += [printed, exact]
    columns = ["label", "path", "source", *QUANTITIES]
    return pd.DataFrame.from_records(records, columns=columns).astype(object)


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
