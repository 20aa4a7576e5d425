"""`dubins-study judge`: answers of other programs, judged.

They answer a suite's questions.
"""

from __future__ import annotations

import shlex
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.output import plain

_ANSWERS = "columns id, curvatures, lengths; maybe claim, bound, seconds, start_heading, method"
_FALSE = {"false_claim": "false claims", "false_bound": "false bounds"}


def judge(
    answers: Annotated[FilePath, typer.Argument(metavar="FILE.csv|.json", help=_ANSWERS)],
    suite: Annotated[
        str, typer.Option(metavar="NAME", help="the experiment that was exported, or a .toml file")
    ] = "benchmark-route",
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: results/<name of the file>")
    ] = None,
) -> None:
    """Judge the answers of any program.

    They become a results folder. Exit code 1 if a claim or a bound is false.
    """
    from dubins_study.experiments.judge import judge_answers

    folder = out or FilePath("results") / answers.stem
    counts: list[int] = []
    with output.progress(f"judge {answers.name}", counts) as progress:
        rows = judge_answers(answers, suite, out=folder, progress=progress)
    lines = []
    for method, method_rows in rows.groupby("solver", sort=False):
        answered = (method_rows["outcome"] == "returned").sum()
        verdict_counts = method_rows["verdict"].value_counts().items()
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in verdict_counts)
        false_counts = [method_rows[name].sum() for name in _FALSE]
        lines.append([method, len(method_rows), answered, verdicts, *false_counts])
    print(output.table(["method", "questions", "answered", "verdicts", *_FALSE.values()], lines))
    for name, what in _FALSE.items():
        for row in rows[rows[name]].to_dict("records"):
            print(f"{what[:-1]} of {row['solver']}: {row['id']}, verdict {row['verdict']}")
    command = shlex.join(["dubins-study", "report", str(folder)])
    print(f"\nits page:\n{plain(command)}")
    raise typer.Exit(int(rows[[*_FALSE]].to_numpy().any()))
