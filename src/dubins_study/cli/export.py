"""`dubins-study export`: models as files for other solvers.

They are models of one scenario, or of a suite.
"""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal import arguments, output
from dubins_study.cli.terminal.output import plain

_ASKED = "a target X Y; or an experiment's name, or the path of a .toml file: all its questions"
_FORMATS = "nl, gams, or mod: AMPL's language, model paper only"
_FORMULATION = "of a suite: paper, or route-nlp, disjunctive, heading-milp, tour-milp [settings]"
_OUT = "a file (default: standard output); of a suite the folder, which it needs"


def export(
    asked: Annotated[list[str], typer.Argument(metavar="X Y | SUITE", help=_ASKED)],
    start: arguments.StartPose = ("0", "0", "0"),
    radius: arguments.Radius = 1,
    model: Annotated[
        str, typer.Option(metavar="NAME", help="paper (4.12), or disjunctive")
    ] = "paper",
    file_format: Annotated[str, typer.Option("--format", metavar="NAME", help=_FORMATS)] = "nl",
    order: Annotated[str, typer.Option(metavar="NAME", help="of model paper: LRS or RLS")] = "LRS",
    formulation: Annotated[str | None, typer.Option(metavar="SPEC", help=_FORMULATION)] = None,
    out: Annotated[FilePath | None, typer.Option(metavar="FILE|DIR", help=_OUT)] = None,
) -> None:
    """Write files for other people's solvers.

    They hold a model of one scenario, or of each question of a suite.
    """
    if len(asked) == 1:
        if formulation is None or out is None:
            missing = "--formulation SPEC, such as route-nlp"
            if formulation:
                missing = "--out DIR"
            problem = f"export of {asked[0]!r:.60}, which is no target X Y, needs {missing}"
            raise arguments.CommandError(problem)
        _export_suite(asked[0], formulation, out)
        return
    if len(asked) > 2 or formulation is not None:
        words = " ".join(asked)
        expected = "expected a target X Y with --model, or a suite with --formulation"
        raise arguments.CommandError(f"export is asked of {words!r:.60}; {expected}")
    x, y = map(arguments.number, asked)
    from dubins_study.solvers.export import export as export_model
    from dubins_study.study.scenario import Scenario

    scenario = Scenario(*arguments.start_pose(start), x, y, radius)
    text = export_model(scenario, model=model, format=file_format, order=order)
    if out is None:
        print(text, end="")
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise arguments.CommandError(f"--out: cannot write {out}: {error.strerror}") from None


def _export_suite(suite: str, formulation: str, out: FilePath) -> None:
    from dubins_study.experiments.reference_set import INSTANCES, export_suite

    counts: list[int] = []
    with output.progress(f"export {suite}", counts) as progress:
        exported = export_suite(suite, formulation, out, progress)
    table = plain(str(exported.folder / INSTANCES))
    print(f"{exported.instances} instances, {exported.files} files; the table is {table}")
    if exported.open:
        print(f"open, with an interval wider than the tolerance: {' '.join(exported.open)}")
    if exported.left_out:
        reason = next(iter(exported.left_out.values()))
        print(f"without a file: {len(exported.left_out)} instances; the first: {plain(reason)}")
