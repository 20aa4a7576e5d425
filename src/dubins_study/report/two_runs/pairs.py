"""The questions that two runs were both asked, one line per solver and question."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.statistics.metrics import success

_PAIR = ["solver", "scenario_id", "branch", "initial_guess"]
# What names a question to a reader, and what asks it again.
_PLACE = ["label", "x", "y", "heading", "target_x", "target_y", "radius", "speed"]
SIDES = ("base", "new")


def pairs(base: Results, new: Results) -> pd.DataFrame:
    """The questions that both runs have attempts at.

    Returns:
        One row per solver and question, index 0, 1, ...: solver, scenario_id, branch,
        initial_guess, the columns of the scenario, answerable (the question has a path), and for
        each side (`base`, `new`):
        right_SIDE: the share of the repeats that the check accepts;
        false_SIDE: whether any repeat makes a false claim or reports a false bound;
        gap_SIDE: the median gap of the repeats that arrive, NaN if none does;
        time_SIDE: the median time of a call, s.
    """
    sides = [_questions(results).add_suffix(f"_{side}") for side, results in _sided(base, new)]
    joined = sides[0].join(sides[1], how="inner")
    shared = [*_PLACE, "answerable"]
    plain = joined.rename(columns={f"{name}_new": name for name in shared})
    dropped = [f"{name}_base" for name in shared]
    frame = plain.drop(columns=dropped).reset_index()
    return frame.sort_values(_PAIR, ignore_index=True)


def unpaired(base: Results, new: Results) -> pd.DataFrame:
    """How many questions of each solver only one of the runs was asked.

    Returns:
        Columns solver, only_base, only_new; solvers whose questions all have a pair are left out.
    """
    indexes = [_questions(results).index for _, results in _sided(base, new)]
    counts = {
        f"only_{side}": mine.difference(other).to_frame(index=False).groupby("solver").size()
        for side, mine, other in zip(SIDES, indexes, indexes[::-1], strict=True)
    }
    frame = pd.DataFrame(counts).fillna(0).astype(int)
    return frame[frame.sum(axis=1) > 0].rename_axis("solver").reset_index()


def unanswered(results: Results) -> pd.DataFrame:
    """Solvers of which a run lacks cells that it was asked: it is not finished, or lost rows.

    Returns:
        Columns solver, cells (asked), rows (there), both whole numbers.
    """
    rows = results.attempts.frame("SELECT solver, count(*) AS rows FROM chosen GROUP BY solver")
    known = dict(zip(rows["solver"], rows["rows"], strict=True))
    entries = results.folders[0].manifest.solvers
    lines = [
        (spec, entry.cells, int(known.get(spec, 0)))
        for spec, entry in entries.items()
        if known.get(spec, 0) < entry.cells
    ]
    return pd.DataFrame(lines, columns=["solver", "cells", "rows"])


def _sided(base: Results, new: Results) -> list[tuple[str, Results]]:
    return list(zip(SIDES, (base, new), strict=True))


def _questions(results: Results) -> pd.DataFrame:
    rows = results.rows
    false = rows["false_claim"].eq(True) | rows["false_bound"].eq(True)
    attempts = rows[[*_PAIR, *_PLACE, "answerable", "gap"]].assign(
        right=success(rows).fillna(False).astype(float),
        false=false.fillna(False).astype(bool),
        time=rows["wall_s"],
    )
    grouped = attempts.groupby(_PAIR, observed=True)
    shares = {"right": ("right", "mean"), "false": ("false", "any")}
    medians = {"gap": ("gap", "median"), "time": ("time", "median")}
    first = {name: (name, "first") for name in (*_PLACE, "answerable")}
    return grouped.agg(**shares, **medians, **first)
