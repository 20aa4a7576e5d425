"""`dubins-study compare`: two runs, solver by solver."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import Json
from dubins_study.cli.terminal.output import plain

if TYPE_CHECKING:
    from dubins_study.report.two_runs.comparison import Comparison


def compare(
    base: Annotated[FilePath, typer.Argument(metavar="BASE", help="results folder")],
    new: Annotated[FilePath, typer.Argument(metavar="NEW", help="results folder")],
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="write a page with tables")
    ] = None,
    slower: Annotated[
        float, typer.Option(metavar="RATIO", help="times as long that count as slower")
    ] = 1.1,
    fail_on_regression: Annotated[
        bool, typer.Option("--fail-on-regression", help="exit code 1 if anything became worse")
    ] = False,
    as_json: Json = False,
) -> None:
    """Compare two runs question by question.

    Says what became better or worse, and where.
    """
    from dubins_study.report.two_runs.compare import compare as compare_runs

    with output.steps("compare"):
        comparison = compare_runs(base, new, out=out, slower=slower)
    if as_json:
        print(json.dumps(_record(comparison), indent=1))
    else:
        print(_text(comparison))
    raise typer.Exit(int(fail_on_regression and comparison.regressed))


def _record(comparison: Comparison) -> dict[str, Any]:
    speed = comparison.speed
    tables = ("solvers", "regressions", "unpaired", "differences")
    # pandas writes what is not finite as null, and numbers of numpy as numbers
    frames = {
        name: json.loads(getattr(comparison, name).to_json(orient="records", double_precision=15))
        for name in tables
    }
    return frames | {
        "speed": speed and speed._asdict(),
        "regressed": comparison.regressed,
        "page": comparison.page and str(comparison.page),
    }


# columns that a terminal lacks room for
_LEFT_OUT = ("questions", "timed", "time_base", "time_new")


def _text(comparison: Comparison) -> str:
    from dubins_study.report.two_runs.compare import solvers_table, speed_text, unpaired_text

    full = solvers_table(comparison)
    columns = tuple(column for column in full.columns if column.key not in _LEFT_OUT)
    shown = replace(full, columns=columns)
    rows = [[" ".join(cell.split()) for cell in row] for row in shown.texts()]
    lines = [
        output.table([column.title for column in columns], rows),
        "",
        speed_text(comparison.speed),
        unpaired_text(comparison),
        *_regressions(comparison),
    ]
    if comparison.page is not None:
        lines.append(f"page: {plain(str(comparison.page))}")
    return "\n".join(lines)


_MOST_LINES = 20


def _regressions(comparison: Comparison) -> list[str]:
    frame = comparison.regressions
    if frame.empty:
        return ["Nothing became worse."]
    lines = []
    for row in frame.head(_MOST_LINES).to_dict("records"):
        place = ", ".join(filter(None, (row["solver"], row["scenario"])))
        change = " -> ".join(filter(None, (row["base"], row["new"])))
        line = plain(f"  {row['kind']}: {place}: {change}")
        if row["command"]:
            line += f"\n    {plain(row['command'])}"
        lines.append(line)
    more = len(frame) - len(lines)
    if more:
        lines.append(f"  and {more} more: --json or --out has them all")
    return [f"Worse ({len(frame)}):", *lines]
