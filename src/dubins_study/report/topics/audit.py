"""Audits of what is printed: the paper's cells, paths, algorithm, omissions; published routes."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Place, Section, Table, Topic, picture
from dubins_study.report.elements.formats import count, digits, share
from dubins_study.report.paper.printed import committed, misprints
from dubins_study.report.paper.routes import LONGER, PRINTED_ROUTES, SHORTEST, compared
from dubins_study.report.topics.routes import plot_route, with_legs
from dubins_study.study.scenario_frame import scenario_of

_SYMBOLS = {"z1": "ζ₁", "z2": "ζ₂", "z3": "ζ₃", "f": "f"}


def _cross(wrong: bool) -> str:
    return "✗" if wrong else ""


def _decimals(places: int, sign: str = "") -> Any:
    """A format with `places` decimals."""
    return lambda value: f"{float(value):{sign}.{places}f}".replace("-", "−")


_ROW = columns(kind="text", table="table", label="scenario", path="path")
COLUMNS = {
    "cells": (
        *_ROW,
        *columns(kind="text", quantity="cell"),
        *columns(printed="printed"),
        *columns(_decimals(9), exact="exact"),
        *columns(_decimals(9, "+"), difference="printed − exact"),
        *columns(kind="text", verdict="verdict"),
        *columns(kind="prose", reason="the exact value …"),
    ),
    "paths": (
        *_ROW,
        *columns(kind="text", word="word"),
        *columns(digits(3), miss="miss", rounding_allows="rounding allows"),
        *columns(_cross, kind="text", beyond="beyond"),
        *columns(sum_of_parts="sum of parts", total="total"),
        *columns(_cross, kind="text", wrong_sum="wrong sum"),
    ),
    "algorithm": (
        *columns(kind="text", label="scenario", where="circle, half"),
        *columns(_decimals(6), radius="R*"),
        *columns(digits(6), length_there="on it"),
        *columns(kind="text", word_beyond="beyond"),
        *columns(digits(6), length_beyond="length"),
        *columns(kind="text", algorithm_word="algorithm"),
        *columns(digits(6), algorithm_length="length"),
        *columns(share, algorithm_excess="too long", model_excess="model (4.12)"),
        *columns(count, example_radius="at R ="),
        *columns(share, example_excess="too long"),
    ),
    "omitted": (
        *columns(kind="text", label="scenario", path="path", word="word"),
        *columns(_decimals(6), z2="right turn ζ₂", z3="straight ζ₃", f="total f"),
    ),
    "statements": (
        *columns(kind="text", where="where"),
        *columns(kind="prose", says="says"),
        *columns(
            lambda holds: "right" if holds else "wrong or incomplete", kind="text", holds="is"
        ),
        *columns(kind="prose", finding="found"),
    ),
}
_CAPTIONS = {
    "cells": (
        "The cells that are not correct roundings. Double rounding: first to more decimals. Solver "
        "bias: model (4.12) at Ipopt's last barrier parameter, where the missing turn is not quite "
        "zero. Wrong: neither, nor cut off. Behind: what the verdict gives in the row. Lengths."
    ),
    "paths": (
        "The printed segments driven from the start: how far from the target they end, and how far "
        "correct roundings may. ✗: a miss beyond that, or parts that do not add up to the total; "
        "in {excused} of these {wrong_sums} rows correct roundings would not either. Lengths."
    ),
    "algorithm": (
        "Algorithm 1 where the turning circle, of radius R*, has reached the target. On it the "
        "optimum is one arc; just beyond, it turns away first (RL or LR); the algorithm knows LS "
        "and RS alone, the unsplit model LR too. Last, a round radius beyond. Lengths."
    ),
    "omitted": "Paths that the tables have no row for, though the text speaks of them. Lengths.",
    "statements": "Statements of the paper that its own scenarios decide.",
}


def audit_section(results: Results) -> Section | None:
    """The findings of the committed audit; shown only with the paper's own experiment."""
    if results.rows.empty:
        return None
    audit = committed()
    lead = (
        "Read each line as one claim of the paper and what exact arithmetic makes of it: which "
        "numbers are wrong, by how much, and by what accident."
    )
    return Section("audit", "The audit of the paper", _text(audit), audit_tables(audit), lead)


def audit_tables(audit: dict[str, Any]) -> tuple[Table, ...]:
    """What an audit finds: a table for each kind of claim."""
    frames = {
        "cells": pd.DataFrame(misprints(audit)).replace({"quantity": _SYMBOLS}),
        "paths": _paths(audit["paths"]),
        "algorithm": pd.DataFrame(audit["algorithm"]).assign(
            where=lambda frame: frame["circle"] + ", " + frame["half"]
        ),
        "omitted": pd.DataFrame(audit["omitted"]),
        "statements": pd.DataFrame(audit["statements"]),
    }
    paths = frames["paths"]
    sums = {
        "excused": int((paths["wrong_sum"] & ~paths["correct_parts_add_up"]).sum()),
        "wrong_sums": int(paths["wrong_sum"].sum()),
    }
    crossed = {"paths": marks(paths, "beyond", "wrong_sum")}
    return tuple(
        Table(
            f"audit-{key}",
            _CAPTIONS[key].format(**sums),
            frame,
            COLUMNS[key],
            crossed.get(key, {}),
        )
        for key, frame in frames.items()
    )


def _paths(paths: list[dict[str, Any]]) -> pd.DataFrame:
    """The printed paths: whether the miss is beyond rounding, and whether the sum is wrong."""
    frame = pd.DataFrame(paths)
    beyond = frame["miss"] > frame["rounding_allows"]
    return frame.assign(beyond=beyond, wrong_sum=~frame["adds_up"].astype(bool))


def _text(audit: dict[str, Any]) -> str:
    summary = audit["summary"]
    verdicts = list(summary["verdicts"].items())[1:]  # the first one is `correct rounding`
    others = ", ".join(f"{number} {verdict}" for verdict, number in verdicts if number)
    ticks = ", ".join(sorted({time["printed"] for time in audit["times"]}))
    return (
        "Every printed number recomputed from the exact headings in interval arithmetic; "
        "dubins-study audit does it again and shows 40 digits of each. Of the cells that are not "
        f"correct roundings, by a rule that looks for the accident behind them: {others}. The bias "
        "is no more than a guess: it would print "
        f"{summary['correct_cells_that_the_bias_would_spoil']} of the correct cells otherwise. "
        f"{summary['times_that_are_ticks']} of the {len(audit['times'])} "
        f"printed solve times ({ticks} s) are whole ticks of a clock of 64 a second: "
        "they tell the clock, not the solver."
    )


_MOST_DIGITS = 17  # of a printed length; the CSV file has all


def _beginning(text: str) -> str:
    return text if len(text) <= _MOST_DIGITS else f"{text[:_MOST_DIGITS]}…"


_PRINTED = (
    *columns(kind="text", label="route"),
    *columns(count, legs="legs"),
    *columns(kind="text", source="source", verdict="verdict"),
    *columns(_beginning, printed="printed"),
    *columns(digits(12), length="ours", low="proven: at least", high="at most"),
    *columns(digits(2), difference="printed − ours"),
)


def printed_routes(rows: pd.DataFrame) -> pd.DataFrame:
    """The published lengths of routes beside the shortest path that some solver found.

    One row for each length whose route has a path: the columns `_PRINTED`, and row: the index of
    the path's row.
    """
    found = rows[rows["gap"].notna()].sort_values("length", kind="stable")
    names = {"reference_low": "low", "reference_high": "high"}
    best = found.drop_duplicates("label").reset_index(names="row").rename(columns=names)
    paths = best[["label", "legs", "row", "length", "low", "high"]]
    lines = pd.DataFrame(PRINTED_ROUTES)[["label", "source", "printed"]].merge(paths, on="label")
    findings = [
        compared(line["printed"], line["length"], line["low"], line["high"])
        for line in lines.to_dict("records")
    ]
    return lines.join(pd.DataFrame(findings, columns=["difference", "verdict"]))


def printed_section(results: Results) -> Section | None:
    """Published lengths beside the proven ones, and the better path of one that is too long."""
    frame = printed_routes(with_legs(results.rows))
    if frame.empty:
        return None
    wrong = frame["verdict"] != SHORTEST
    caption = (
        "Lengths as printed; ours is that of the best path found, driven by the check. At least "
        "and at most: the proven interval around the shortest length."
    )
    bad = marks(frame.assign(verdict=wrong), "verdict")
    blocks: list[Table | Picture] = [Table("routes-printed", caption, frame, _PRINTED, bad)]
    blocks += [
        _better(results, line) for line in frame[frame["verdict"] == LONGER].to_dict("records")
    ]
    others = [
        f"{line['source']}, {line['label']}: {line['verdict']}"
        for line in frame[wrong].to_dict("records")
    ]
    text = (
        f"{count((~wrong).sum())} of {count(len(frame))} published lengths are the shortest, to "
        f"the last digit that the proof decides. The others: {'; '.join(others) or 'none'}. "
        "dubins-study audit kaya searches for the shortest paths again."
    )
    lead = "See which published lengths of four routes are the shortest, by proof."
    return Section("routes-printed", "Published routes", text, tuple(blocks), lead)


def _better(results: Results, line: Mapping[Hashable, Any]) -> Picture:
    """The path that is shorter than a published length."""
    path = results.path(line["row"])
    scenario = scenario_of(results.rows.loc[line["row"]].to_dict())
    caption = f"{line['label']}: a path that is {digits(2)(line['difference'])} shorter."
    alt = "The shortest path through the points of a published route"
    drawn = path, scenario, "ours"
    return picture("routes-better", plot_route, *drawn, caption=caption, alt=alt, height=2.9)


TOPIC = Topic("the audit of the paper", audit_section, "paper", place=Place.PAPER)
PRINTED_TOPIC = Topic("published routes", printed_section, "kaya")
