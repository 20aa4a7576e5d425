"""`dubins-study report`: tables, figures and one page from results folders."""

from __future__ import annotations

import json
import math
from pathlib import Path as FilePath
from typing import Annotated

import typer

# Column of the report's summary -> its name in the terminal; only columns that fit a terminal.
_SUMMARY = {
    "solver": "solver",
    "right_text": "right of n, 95 %",
    "longer": "longer",
    "misses": "misses",
    "none": "none",
    "false_claims": "false claims",
    "wrong_basins": "wrong basins",
    "wall_s": "median ms",
}


def report(
    folders: Annotated[list[FilePath], typer.Argument(metavar="DIR", help="results folders")],
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: report in the first folder")
    ] = None,
    as_json: Annotated[
        bool,
        typer.Option("--json", help="print page and summary as one JSON object"),
    ] = False,
) -> None:
    """Write tables, figures and one page from results folders."""
    from dubins_study.cli.terminal import streams
    from dubins_study.report.page.render import render

    with streams.steps("report") as step:
        page = render(folders, out=out, progress=step)
    print(report_json(page) if as_json else report_text(page))


def _summary(page: FilePath) -> list[dict[str, str]]:
    """The lines of the summary table of a report; numbers as texts, which are empty for none."""
    import csv

    file = page.parent / "tables" / "summary.csv"
    if not file.exists():  # the folders hold no rows
        return []
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def report_json(page: FilePath) -> str:
    """The path of a report's page, and its summary by the columns of tables/summary.csv."""
    rows = [{name: _value(text) for name, text in line.items()} for line in _summary(page)]
    return json.dumps({"page": str(page), "summary": rows}, indent=2, allow_nan=False)


def _value(text: str) -> str | float | None:
    """A cell of the table as JSON has it."""
    if text.isdecimal():
        return int(text)
    try:
        number = float(text)
    except ValueError:
        return text or None
    return number if math.isfinite(number) else None


def report_text(page: FilePath) -> str:
    """The summary table of a report, and the path of its page."""
    from dubins_study.cli.terminal.table import table
    from dubins_study.study.values import plain

    def _line(text: str) -> str:
        return plain(text.replace("\n", " ").replace("\u202f", " "))  # thin spaces of numbers

    lines = _summary(page)
    # the report leaves out a column that its runs do not need
    shown = {name: title for name, title in _SUMMARY.items() if not lines or name in lines[0]}
    rows = [
        [_milliseconds(row[name]) if name == "wall_s" else _line(row[name]) for name in shown]
        for row in lines
    ]
    return f"{table(list(shown.values()), rows)}\n\npage: {plain(str(page))}"


def _milliseconds(seconds: str) -> str:
    return f"{float(seconds) * 1e3:.3g}" if seconds else ""
