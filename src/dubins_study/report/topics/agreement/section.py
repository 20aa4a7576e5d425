"""The section on agreement between solvers."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    share,
)
from dubins_study.report.elements.style import WIDE, new_figure
from dubins_study.report.topics.agreement.figures import plot_agreement
from dubins_study.report.topics.agreement.numbers import agreement


def agreement_section(results: Results) -> Section | None:
    """Matrix and table of all pairs of solvers."""
    rows = results.rows
    if rows["solver"].nunique() < 2:
        return None
    pairs = agreement(rows, results.path)
    pairs = pairs[pairs["questions"] > 0].reset_index(drop=True)
    if not (pairs["both"] > 0).any():
        return None
    n = len({*pairs["first"], *pairs["second"]})
    figure = new_figure(WIDE, min(7.0, 0.8 + 0.52 * n))
    plot_agreement(figure.add_subplot(), pairs)
    caption = (
        "Below the diagonal: the largest |La − Lb| / max(reference, R) of each pair, darker for "
        "more. Above it: the share of common answers that agree to 1e-6. Empty: no common answer."
    )
    picture = Picture("agreement", caption, figure, "Matrix of agreement between solvers")
    text = (
        "Where two solvers both arrive, how far are their lengths apart, and their paths? Only "
        "cold starts, the first repeat of each, and questions where both arrive; the table says "
        "how many."
    )
    return Section("agreement", "Agreement", text, (picture, _table(pairs)))


def _table(pairs: pd.DataFrame) -> Table:
    number = digits(3)
    columns = (
        Column("first", "solver", kind="code"),
        Column("second", "and", kind="code"),
        Column("questions", "questions", count),
        Column("both", "both arrive", count),
        Column("median", "median", number),
        Column("largest", "largest", number),
        Column("within", "agree to 1e-6", share),
        Column("apart_median", "paths, median", number),
        Column("apart_largest", "paths, largest", number),
    )
    caption = (
        "Differences in length, and the largest distance between the two paths at equal arc "
        "length, both over max(reference, R). Equal lengths with distant paths are ties, or flat "
        "optima."
    )
    return Table("agreement", caption, pairs, columns)
