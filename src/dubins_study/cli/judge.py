"""`dubins-study judge`: the answers of any program to a suite's questions, judged."""

from __future__ import annotations

import json
import shlex
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import Json
from dubins_study.cli.terminal.output import plain

if TYPE_CHECKING:
    import pandas as pd

_ANSWERS = "columns id, curvatures, lengths; maybe claim, bound, seconds, start_heading, method"


def judge(
    answers: Annotated[FilePath, typer.Argument(metavar="FILE.csv|.json", help=_ANSWERS)],
    suite: Annotated[
        str, typer.Option(metavar="NAME", help="the experiment that was exported, or a .toml file")
    ] = "benchmark-route",
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: results/<name of the file>")
    ] = None,
    as_json: Json = False,
) -> None:
    """Judge the answers of any program, in any language, and write a results folder.

    Exit code 1 if a claim or a bound is false.
    """
    from dubins_study.experiments.judge import judge_answers, summary

    folder = FilePath("results") / answers.stem if out is None else out
    counts: list[int] = []
    with output.progress(f"judge {answers.name}", counts) as progress:
        rows = judge_answers(answers, suite, out=folder, progress=progress)
    methods = summary(rows)
    if as_json:
        print(json.dumps({"folder": str(folder), "methods": methods}, indent=2))
    else:
        _print(methods, rows, folder)
    wrong = (rows["false_claim"] | rows["false_bound"]).any()
    raise typer.Exit(1 if wrong else 0)


def _print(methods: list[dict[str, Any]], rows: pd.DataFrame, folder: FilePath) -> None:
    """The verdicts of each method, each false claim and bound, and the command for the page."""
    head = [name.replace("_", " ") for name in methods[0]]
    lines = []
    for method in methods:
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in method["verdicts"].items())
        lines.append(list((method | {"verdicts": verdicts}).values()))
    print(output.table(head, lines))
    for row in rows.to_dict("records"):
        false = [name for name in ("claim", "bound") if row[f"false_{name}"]]
        if false:
            what = " and ".join(false)
            print(f"false {what} of {row['solver']}: {row['id']}, verdict {row['verdict']}")
    command = shlex.join(["dubins-study", "report", str(folder)])
    print(f"\nits page:\n{plain(command)}")
