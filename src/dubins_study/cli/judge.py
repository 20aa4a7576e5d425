"""`dubins-study judge`: the answers of any program to a suite's questions, judged."""

from __future__ import annotations

import json
import shlex
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import Json
from dubins_study.cli.terminal.output import plain

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
    lines = summary(rows)
    if as_json:
        print(json.dumps({"folder": str(folder), "methods": lines}, indent=2))
    else:
        head = list(lines[0])
        print(output.table(head, [list(line.values()) for line in lines]))
        false = rows[rows["false_claim"] | rows["false_bound"]]
        for row in false.to_dict("records"):
            what = "bound" if row["false_bound"] else f"claim {row['claim']}"
            print(f"false {what}: {row['id']}, verdict {row['verdict']}")
        command = shlex.join(["dubins-study", "report", str(folder)])
        print(f"\nits page:\n{plain(command)}")
    wrong = any(line["false claims"] or line["false bounds"] for line in lines)
    raise typer.Exit(1 if wrong else 0)
