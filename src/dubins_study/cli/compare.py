"""`dubins-study compare`: two runs, solver by solver."""

from __future__ import annotations

import json
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
        FilePath | None, typer.Option(metavar="DIR", help="write a page with tables and figures")
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
    print(json.dumps(_record(comparison), indent=1) if as_json else _text(comparison))
    raise typer.Exit(1 if fail_on_regression and comparison.regressed else 0)


def _record(comparison: Comparison) -> dict[str, Any]:
    speed = comparison.speed
    tables = ("solvers", "regressions", "unpaired", "differences")
    # pandas writes what is not finite as null, and numbers of numpy as numbers
    frames = {
        name: json.loads(getattr(comparison, name).to_json(orient="records", double_precision=15))
        for name in tables
    }
    return frames | {
        "speed": None if speed is None else speed._asdict(),
        "regressed": comparison.regressed,
        "page": None if comparison.page is None else str(comparison.page),
    }


def _text(comparison: Comparison) -> str:
    def ratio(row: Any) -> str:
        low, high = row["time_ratio_low"], row["time_ratio_high"]
        return "" if low != low else f"{row['time_ratio']:.3g} ({low:.3g} to {high:.3g})"

    head = ["solver", "verdict", "right, base", "right, new", "lost", "gained", "time, new / base"]
    rows = [
        (
            row["solver"],
            row["verdict"],
            _percent(row["right_base"], row["questions"]),
            _percent(row["right_new"], row["questions"]),
            row["lost"],
            row["gained"],
            ratio(row),
        )
        for row in comparison.with_verdicts().to_dict("records")
    ]
    speed = comparison.speed
    machine = (
        "Nothing says how fast the machines were: no solver is called slower."
        if speed is None
        else f"The same work took {speed.ratio:.3g} times as long ({speed.low:.3g} to "
        f"{speed.high:.3g}), by {speed.evidence}; times of changed solvers are divided by that."
    )
    lines = [
        output.table(head, rows),
        "",
        machine,
        *_unpaired(comparison),
        *_regressions(comparison),
    ]
    if comparison.page is not None:
        lines.append(f"page: {plain(str(comparison.page))}")
    return "\n".join(lines)


_MOST_LINES = 20


def _unpaired(comparison: Comparison) -> list[str]:
    """How much only one run was asked: nothing is said of it."""
    return [
        f"Not compared: {count} questions of {side} only."
        for side in ("base", "new")
        if (count := comparison.unpaired[f"only_{side}"].sum())
    ]


def _regressions(comparison: Comparison) -> list[str]:
    frame = comparison.regressions
    if frame.empty:
        return ["Nothing became worse."]
    lines = [f"Worse ({len(frame)}):"]
    for row in frame.head(_MOST_LINES).to_dict("records"):
        place = f"{row['solver']}, {row['scenario']}"
        lines.append(plain(f"  {row['kind']}: {place}: {row['base']} -> {row['new']}"))
        if row["command"]:
            lines.append(f"    {plain(row['command'])}")
    if len(frame) > _MOST_LINES:
        lines.append(f"  and {len(frame) - _MOST_LINES} more: --json or --out has them all")
    return lines


def _percent(value: float, questions: int) -> str:
    return f"{100 * value:.1f} % of {questions}" if questions else "none asked"
