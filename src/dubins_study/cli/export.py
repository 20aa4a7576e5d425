"""`dubins-study export`: a model of one scenario as a file for other solvers."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.arguments import (
    Radius,
    StartPose,
    TargetX,
    TargetY,
    scenario_of,
)
from dubins_study.cli.terminal.refusals import CommandError


def export(
    x: TargetX,
    y: TargetY,
    start: StartPose = ("0", "0", "0"),
    radius: Radius = "1",
    model: Annotated[
        str, typer.Option(metavar="NAME", help="paper (4.12), or disjunctive")
    ] = "paper",
    file_format: Annotated[
        str,
        typer.Option(
            "--format", metavar="NAME", help="nl, gams, or mod: AMPL's language, model paper only"
        ),
    ] = "nl",
    order: Annotated[str, typer.Option(metavar="NAME", help="of model paper: LRS or RLS")] = "LRS",
    out: Annotated[
        FilePath | None, typer.Option(metavar="FILE", help="default: standard output")
    ] = None,
) -> None:
    """Write a model of one scenario for other people's solvers."""
    from dubins_study.solvers.export import export as export_model

    scenario = scenario_of((x, y), start, radius)
    text = export_model(scenario, model, file_format, order)
    if out is None:
        print(text, end="")
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise CommandError(f"--out: cannot write {out}: {error.strerror}") from None
