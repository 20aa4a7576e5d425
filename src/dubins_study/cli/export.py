"""`dubins-study export`: a model of one scenario as a file for other solvers."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal import arguments

_FORMATS = "nl, gams, or mod: AMPL's language, model paper only"


def export(
    x: arguments.TargetX,
    y: arguments.TargetY,
    start: arguments.StartPose = ("0", "0", "0"),
    radius: arguments.Radius = 1,
    model: Annotated[
        str, typer.Option(metavar="NAME", help="paper (4.12), or disjunctive")
    ] = "paper",
    file_format: Annotated[str, typer.Option("--format", metavar="NAME", help=_FORMATS)] = "nl",
    order: Annotated[str, typer.Option(metavar="NAME", help="of model paper: LRS or RLS")] = "LRS",
    out: Annotated[
        FilePath | None, typer.Option(metavar="FILE", help="default: standard output")
    ] = None,
) -> None:
    """Write a model of one scenario for other people's solvers."""
    from dubins_study.solvers.export import export as export_model
    from dubins_study.study.scenario import Scenario

    scenario = Scenario(*arguments.start_pose(start), x, y, radius)
    text = export_model(scenario, model, file_format, order)
    if out is None:
        print(text, end="")
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        message = f"--out: cannot write {out}: {error.strerror}"
        raise arguments.CommandError(message) from None
