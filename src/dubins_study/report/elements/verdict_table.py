"""How counts of verdicts are shown, one row a solver."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.content import Column, count, seconds, share


def verdict_columns() -> tuple[Column, ...]:
    """The columns of `topics.summary.numbers.summary` as tables show them."""
    counts = ("attempts", "optimal", "none exists", "longer", "misses", "none")
    return (
        Column("solver", "solver", kind="code"),
        *(Column(key, key, count) for key in counts),
        Column("success", "success", share),
        Column("false_claims", "false claims", count),
        Column("wrong_basins", "wrong basins", count),
        Column("not_returned", "not returned", count),
        Column("wall_s", "median time", seconds),
    )


def marks_of_failures(frame: pd.DataFrame) -> dict[tuple[int, str], str]:
    """Marks for the counts of answers that are wrong or missing, where there are any."""
    wrong = ("misses", "none", "false_claims", "not_returned")
    rows = frame.to_dict("records")
    return {(i, key): "bad" for i, row in enumerate(rows) for key in wrong if row[key]}
