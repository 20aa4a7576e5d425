"""The comparison's tables."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.content import Table
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.elements.identity import (
    interval_column,
    interval_keys,
    method_columns,
    with_interval_texts,
)
from dubins_study.report.topics.comparison.paired import LEVEL, separated

# Rivals of a formulation's or an engine's best method that a table of tests shows.
_MOST_RIVALS = 6


def rank_table(ranked: pd.DataFrame, shift: float, common: int, limit_s: float) -> Table:
    """Shares right, means and ranks."""
    places = zip(ranked["rank"], ranked["best"], ranked["worst"], strict=True)
    frame = ranked.assign(
        place=[str(rank) if rank is not pd.NA else f"none\n({a} to {b})" for rank, a, b in places]
    )
    shown = (
        *method_columns(frame),
        *columns(count, questions="questions"),
        interval_column("right", "right"),
        interval_column("mean", "mean time"),
        *columns(kind="cell", place="rank"),
        *columns(count, rank_tenth="shift / 10", rank_tenfold="shift × 10"),
        interval_column("par2", "PAR-2"),
        *columns(seconds, common="mean over common"),
    )
    caption = (
        f"Mean time: shifted geometric mean, shift {seconds(shift)} (the lower quartile of the "
        f"times), a failure costs the limit of {seconds(limit_s)}. The rank is that of the mean; "
        "none if it changes at a tenth or ten times the shift, or if failures cost twice or ten "
        "times the limit. PAR-2: arithmetic mean, a failure costs twice the limit. Over common: "
        f"the shifted mean over the {count(common)} questions that all methods answer which are "
        "right on at least nine tenths of them. 95 % intervals: Wilson's for shares, for as many "
        "trials as there are questions, and bootstrap over scenarios for means."
    )
    shows = {"right": share, "mean": seconds, "par2": seconds}
    frame = with_interval_texts(frame, **shows)
    return Table(
        "comparison-ranks", caption, frame, shown, numbers=interval_keys(*shows), dense=True
    )


def test_table(tests: pd.DataFrame, ranked: pd.DataFrame, shared: str) -> Table:
    """Paired tests of methods that share a formulation or an engine; the nearest rivals."""
    names = ranked["short"] if shared == "formulation" else ranked["name"]
    near = tests.groupby(["shared", "solver"], sort=False).head(_MOST_RIVALS)
    frame = near.assign(
        solver_name=near["solver"].map(names),
        rival_name=near["rival"].map(names),
        verdict=separated(near).map({True: "they differ", False: "no rank"}),
    ).reset_index(drop=True)
    shown = (
        *columns(kind="text", shared=shared, solver_name="method", rival_name="rival"),
        *columns(count, pairs="questions", wins="faster", losses="slower", ties="ties"),
        *columns(digits(2), p="p", p_holm="p, Holm"),
        *columns(kind="text", verdict="verdict"),
    )
    left_out = len(tests) - len(near)
    rest = f" {count(left_out)} tests of rivals with larger means are left out." if left_out else ""
    what = (
        "the best method of each formulation against the others of the same formulation"
        if shared == "formulation"
        else "the best methods of one engine on two formulations"
    )
    caption = (
        f"Paired tests of {what}: Wilcoxon's signed ranks of the ratio of times, question by "
        "question; a failure loses to every right answer, two failures tie. Holm's correction over "
        f"all {count(len(tests))} tests. No rank: p above {LEVEL}; do not say which is "
        f"faster.{rest}"
    )
    return Table(f"comparison-tests-{shared}", caption, frame, shown, dense=True)


def spread_table(spread: pd.DataFrame, methods: pd.DataFrame) -> Table:
    """Spread over repeats, of the methods whose verdict or time changes most."""
    frame = methods.join(spread, how="inner").reindex(spread.index)
    changing = frame[frame["changing"] > 0]
    shown_rows = changing if len(changing) else frame.head(5)
    shown = (
        *method_columns(shown_rows),
        *columns(count, questions="questions", repeats="repeats"),
        interval_column("changing", "verdict changes"),
        *columns(share, sometimes="right only sometimes"),
        *(Column(key, title, digits(2)) for key, title in _SPREADS),
    )
    same = len(frame) - len(changing)
    caption = (
        "Spread over repeats, each with another seed where the engine draws random numbers: how "
        "often the verdict changes (Wilson's 95 % interval), and the spread of the time. "
        f"{count(same)} methods give one verdict in all repeats"
        f"{' and are left out' if len(changing) else '; those with the widest spread are shown'}."
    )
    shown_rows = with_interval_texts(shown_rows, changing=share)
    numbers = interval_keys("changing")
    return Table("comparison-spread", caption, shown_rows, shown, numbers=numbers, dense=True)


_SPREADS = (("cv", "time: deviation / mean"), ("iqr_relative", "time: quartile range / median"))
