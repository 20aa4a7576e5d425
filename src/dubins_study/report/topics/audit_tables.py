"""Audits of printed numbers: two sections.

The first is on the paper's cells, paths, algorithm and statements. The second is on published
lengths of routes.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Place, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, share
from dubins_study.report.paper.printed import Record, committed, misprints
from dubins_study.report.paper.routes import PRINTED_ROUTES, SHORTEST, compared
from dubins_study.report.topics.routes import with_legs

_SYMBOLS = {"z1": "ζ₁", "z2": "ζ₂", "z3": "ζ₃", "f": "f"}


def _decimals(places: int, sign: str = "") -> Any:
    """A format with `places` decimals."""
    return lambda value: f"{float(value):{sign}.{places}f}".replace("-", "−")


_ROW = columns(kind="text", table="table", label="scenario", path="path")
_CELLS = (
    *_ROW,
    *columns(kind="text", quantity="cell"),
    *columns(printed="printed"),
    *columns(_decimals(9), exact="exact"),
    *columns(_decimals(9, "+"), difference="printed − exact"),
    *columns(kind="text", verdict="verdict"),
)
_PATHS = (
    *_ROW,
    *columns(kind="text", word="word"),
    *columns(digits(3), miss="miss", rounding_allows="rounding allows"),
)
_ALGORITHM = (
    *columns(kind="text", label="scenario", circle="circle"),
    *columns(_decimals(6), radius="R*"),
    *columns(kind="text", word_beyond="beyond"),
    *columns(digits(6), length_beyond="length"),
    *columns(kind="text", algorithm_word="algorithm"),
    *columns(digits(6), algorithm_length="length"),
    *columns(share, algorithm_excess="too long"),
)
_STATEMENTS = (
    *columns(kind="text", where="where"),
    *columns(kind="prose", says="says"),
    *columns({True: "right", False: "wrong or incomplete"}.__getitem__, kind="text", holds="is"),
    *columns(kind="prose", finding="found"),
)


def audit_section(results: Results) -> Section | None:
    """The section with the findings of the committed audit.

    None without rows: only a page with the paper's own experiment has it.
    """
    if results.rows.empty:
        return None
    audit = committed()
    verdicts = Counter(cell["verdict"] for cell in misprints(audit))
    causes = ", ".join(f"{number} {verdict}" for verdict, number in verdicts.items())
    text = (
        "Every printed number is recomputed from the exact headings in interval arithmetic. "
        "dubins-study audit repeats this, and with --json shows 40 digits of each number. The "
        f"wrong cells by their likely cause: {causes}. The bias is only a guess: it would print "
        "the missing turn as 0.01, not 0."
    )
    lead = (
        "Each line is one claim of the paper, checked in exact arithmetic. See which numbers are "
        "wrong, by how much, and why."
    )
    return Section("audit", "The audit of the paper", text, audit_tables(audit), lead)


def audit_tables(audit: Record) -> tuple[Table, ...]:
    """Tables of an audit, one per kind of claim."""
    cells = pd.DataFrame(misprints(audit)).replace({"quantity": _SYMBOLS})
    paths = pd.DataFrame(audit["paths"])
    beyond = pd.DataFrame({"miss": paths["miss"] > paths["rounding_allows"]})
    return (
        Table(
            "audit-cells",
            "The cells that are no correct roundings, all lengths. Double rounding: first to more "
            "decimals. Solver bias: model (4.12) at Ipopt's last barrier parameter, where "
            "the missing turn is not quite zero. Wrong: neither of these, nor truncated.",
            cells,
            _CELLS,
        ),
        Table(
            "audit-paths",
            "The printed segments, driven from the start: how far from the target they end, and "
            f"how far correct roundings may end. {beyond['miss'].sum()} end farther away.",
            paths,
            _PATHS,
            marks(beyond, "miss"),
        ),
        Table(
            "audit-algorithm",
            "Algorithm 1 just beyond R*, where the target is inside a turning circle. The "
            "shortest path turns away first (RL or LR). The algorithm knows LS and RS only; the "
            "unsplit model (4.12) also knows LR. Lengths.",
            pd.DataFrame(audit["algorithm"]),
            _ALGORITHM,
        ),
        Table(
            "audit-statements",
            "Statements of the paper, checked on its own scenarios.",
            pd.DataFrame(audit["statements"]),
            _STATEMENTS,
        ),
    )


_MOST_DIGITS = 17  # of a printed length; the CSV file has all


def _beginning(text: str) -> str:
    if len(text) <= _MOST_DIGITS:
        return text
    return f"{text[:_MOST_DIGITS]}…"


_PRINTED = (
    *columns(kind="text", label="route"),
    *columns(count, legs="legs"),
    *columns(kind="text", source="source", verdict="verdict"),
    *columns(_beginning, printed="printed"),
    *columns(digits(12), length="ours", low="proven: at least", high="at most"),
    *columns(digits(2), difference="printed − ours"),
)


def routes_table(frame: pd.DataFrame) -> Table:
    """The table of published lengths of routes beside ours.

    The frame is that of `audit_routes` or `printed_routes`. A length that is not the shortest is
    marked.
    """
    caption = (
        "Lengths as printed. Ours: the best path of any solver, driven by the check. At least "
        "and at most: the proven interval around the shortest length."
    )
    wrong = pd.DataFrame({"verdict": frame["verdict"] != SHORTEST})
    return Table("routes-printed", caption, frame, _PRINTED, marks(wrong, "verdict"))


def printed_routes(rows: pd.DataFrame) -> pd.DataFrame:
    """Published lengths of routes beside the shortest paths found.

    For each route, the shortest path that any solver returned is taken. A row is a published length
    whose route has such a path. The columns are those of `_PRINTED`.
    """
    arrived = rows[rows["gap"].notna()].sort_values("length", kind="stable")
    names = {"reference_low": "low", "reference_high": "high"}
    best = arrived.drop_duplicates("label").rename(columns=names)
    paths = best[["label", "legs", "length", "low", "high"]]
    lines = pd.DataFrame(PRINTED_ROUTES)[["label", "source", "printed"]].merge(paths, on="label")
    findings = [
        compared(line["printed"], line["length"], line["low"], line["high"])
        for line in lines.to_dict("records")
    ]
    return lines.join(pd.DataFrame(findings, columns=["difference", "verdict"]))


def printed_section(results: Results) -> Section | None:
    """The section with published lengths beside ours.

    Ours are those of `printed_routes`.
    """
    frame = printed_routes(with_legs(results.rows))
    if frame.empty:
        return None
    wrong = frame[frame["verdict"] != SHORTEST]
    others = "; ".join(wrong["source"] + ", " + wrong["label"] + ": " + wrong["verdict"])
    text = (
        f"{count(len(frame) - len(wrong))} of {count(len(frame))} published lengths are the "
        f"shortest, to the last digit that the proof decides. The others: {others or 'none'}. "
        "dubins-study audit kaya searches for the shortest paths again."
    )
    lead = "See which published lengths of four routes are proved to be the shortest."
    return Section("routes-printed", "Published routes", text, (routes_table(frame),), lead)


TOPIC = Topic("the audit of the paper", audit_section, "paper", place=Place.PAPER)
PRINTED_TOPIC = Topic("published routes", printed_section, "kaya")
