"""The command line: parse, call the library, print. Results to stdout, the rest to stderr."""

from __future__ import annotations

import re
import sys
from pathlib import Path as FilePath
from typing import Annotated, Any

from dubins_study.errors import DubinsStudyError

try:
    import typer
except KeyboardInterrupt:  # this is the first thing that takes long enough to be interrupted
    sys.exit(130)

app = typer.Typer(
    help="Optimisation solvers judged on the shortest Dubins path to a point.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
# a target such as -6 3 must not be taken for options; what is none of ours is refused by `solve`
_NEGATIVE = {"ignore_unknown_options": True, "allow_extra_args": True}


@app.command(context_settings=_NEGATIVE)
def solve(
    context: typer.Context,
    x: Annotated[str, typer.Argument(metavar="X", help="target position")],
    y: Annotated[str, typer.Argument(metavar="Y", help="target position")],
    start: Annotated[
        tuple[str, str, str],
        typer.Option("--from", metavar="X Y HEADING", help="start pose, e.g. 0 0 120deg"),
    ] = ("0", "0", "0"),
    radius: Annotated[str, typer.Option(help="minimum turning radius")] = "1",
    speed: Annotated[str, typer.Option(help="constant speed")] = "1",
    solver: Annotated[str, typer.Option(help="name or name[setting=value]")] = "analytic",
    branch: Annotated[str, typer.Option(help="best, LS, RS, LR or RL")] = "best",
    profile: Annotated[str, typer.Option(help="default, fast or accurate")] = "default",
    time_limit: Annotated[float, typer.Option(help="seconds that the solve may take")] = 60.0,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
    plot: Annotated[
        FilePath | None, typer.Option(metavar="FILE", help="draw the path: .svg, .pdf or .png")
    ] = None,
) -> None:
    """Solve one scenario and judge the answer."""
    from dubins_study.cli import show, streams

    show.check_words([x, y], context.args, "solve")
    scenario = show.scenario(x, y, start, radius, speed)
    with streams.solvers_to_stderr():
        answer = show.solved(scenario, solver, branch, profile, time_limit)
    refusal = show.no_answer(answer)
    if plot is not None and refusal is None:
        show.plot(answer, plot)
    if as_json or refusal is None:
        print(show.answer_json(answer) if as_json else show.answer_text(answer))
    if refusal is not None:
        raise show.ShowError(refusal)


@app.command(context_settings=_NEGATIVE)
def export(
    context: typer.Context,
    x: Annotated[str, typer.Argument(metavar="X", help="target position")],
    y: Annotated[str, typer.Argument(metavar="Y", help="target position")],
    start: Annotated[
        tuple[str, str, str],
        typer.Option("--from", metavar="X Y HEADING", help="start pose, e.g. 0 0 120deg"),
    ] = ("0", "0", "0"),
    radius: Annotated[str, typer.Option(help="minimum turning radius")] = "1",
    model: Annotated[str, typer.Option(help="paper (4.12), or disjunctive")] = "paper",
    file_format: Annotated[
        str, typer.Option("--format", help="nl, gams, or mod: AMPL's language, model paper only")
    ] = "nl",
    order: Annotated[str, typer.Option(help="of model paper: LRS or RLS")] = "LRS",
    out: Annotated[
        FilePath | None, typer.Option(metavar="FILE", help="default: standard output")
    ] = None,
) -> None:
    """Write a model of one scenario for other people's solvers."""
    from dubins_study.cli import show
    from dubins_study.solvers.export import export as export_model

    show.check_words([x, y], context.args, "export")
    text = export_model(show.scenario(x, y, start, radius, "1"), model, file_format, order)
    if out is None:
        print(text, end="")
    else:
        show.save(text, out)


@app.command()
def solvers(
    as_json: Annotated[bool, typer.Option("--json", help="print a JSON list")] = False,
) -> None:
    """List every solver: available, or why not."""
    from dubins_study.cli import show
    from dubins_study.solvers.registry import entries

    print(show.solvers_json(entries()) if as_json else show.solvers_text(entries()))


@app.command()
def run(
    experiment: Annotated[str, typer.Argument(help="a name, or the path of a .toml file")],
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: results/<experiment>")
    ] = None,
    solver: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="instead of the experiment's own")
    ] = None,
    jobs: Annotated[int, typer.Option(help="processes; 1 where times are quoted")] = 1,
    time_limit: Annotated[
        float | None, typer.Option(help="seconds after which a solve is ended")
    ] = None,
    memory_limit: Annotated[float | None, typer.Option(help="GiB that a solve may hold")] = None,
    repeats: Annotated[int | None, typer.Option(help="attempts per cell")] = None,
    restart: Annotated[bool, typer.Option("--restart", help="throw away earlier rows")] = False,
    trust_plugins: Annotated[
        bool, typer.Option("--trust-plugins", help="the experiment may name plug-ins and programs")
    ] = False,
    engine: Annotated[str, typer.Option(help="local, or dask")] = "local",
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of Dask's; default: one on this machine")
    ] = None,
) -> None:
    """Run an experiment; cells that are done are skipped."""
    from dubins_study.experiments.interruption import Interruption

    told: list[int] = []
    try:
        # from here on, since libraries that are interrupted while they load say odd things
        with Interruption() as stop:
            from dubins_study.cli import show_status, streams
            from dubins_study.experiments.run import run as run_experiment
            from dubins_study.experiments.store.status import status as status_of

            stop.check()
            with streams.solvers_to_stderr(), streams.progress(experiment, told) as tell:
                folder = run_experiment(
                    experiment,
                    out,
                    solvers=solver,
                    jobs=jobs,
                    time_limit=time_limit,
                    memory_limit=memory_limit,
                    repeats=repeats,
                    restart=restart,
                    trust_plugins=trust_plugins,
                    engine=engine,
                    scheduler=scheduler,
                    progress=tell,
                )
            print(show_status.status_text(status_of(folder)))
    except KeyboardInterrupt:
        again = "run the same command without --restart" if restart else "run the same command"
        cells = " ({} of {} cells done)".format(*told) if told else ""
        print(f"interrupted; what was done is kept, {again} to go on{cells}", file=sys.stderr)
        raise typer.Exit(130) from None


@app.command()
def status(
    folder: Annotated[FilePath, typer.Argument(metavar="DIR")],
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Tell what a results folder holds: done, left, failing, its runs, and the time left."""
    from dubins_study.cli import show_status
    from dubins_study.experiments.store.status import status as status_of

    found = status_of(folder)
    print(show_status.status_json(found) if as_json else show_status.status_text(found))


@app.command()
def merge(
    folders: Annotated[list[FilePath], typer.Argument(metavar="DIR DIR...")],
    out: Annotated[FilePath, typer.Option(metavar="DIR", help="new, or empty")],
) -> None:
    """Unite results folders of one experiment; refused if they contradict each other."""
    from dubins_study.cli import show_status
    from dubins_study.experiments.store.merge import merge as unite

    print(show_status.merge_text(unite(folders, out)))


@app.command()
def report(
    folders: Annotated[list[FilePath], typer.Argument(metavar="DIR...")],
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: report in the first folder")
    ] = None,
) -> None:
    """Write tables, figures and one page from results folders."""
    from dubins_study import render
    from dubins_study.cli import show, streams

    with streams.spinner("report"):
        page = render(folders, out=out)
    print(show.report_text(page))


@app.command()
def audit(
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Recompute the paper's tables; exit code 1 if the code contradicts the committed audit."""
    from dubins_study.cli import show_audit
    from dubins_study.report.paper.audit import audit as recompute
    from dubins_study.report.paper.audit_check import contradictions
    from dubins_study.report.paper.audit_file import committed

    found = recompute()
    # flushed before the committed audit is read, which may be the file that this is written to
    print(show_audit.audit_json(found) if as_json else show_audit.audit_text(found), flush=True)
    lines = contradictions(found, committed())
    for line in lines:
        print(f"dubins-study: contradiction: {line}", file=sys.stderr)
    raise typer.Exit(1 if lines else 0)


def main() -> Any:
    """The command `dubins-study`. Exit code 2 and one message if the request is bad."""
    try:
        return app()
    except BrokenPipeError:
        sys.exit(0)
    except DubinsStudyError as error:  # anything else is a bug and shows itself
        print(f"dubins-study: {_visible(str(error))}", file=sys.stderr)
        sys.exit(2)


def _visible(message: str) -> str:
    """The message with its control characters, which may come from a file, made visible.

    Line breaks too, but those of a list: of indented lines.
    """
    from dubins_study.study.printable import plain

    return "\n".join(map(plain, re.split(r"\n(?=  )", message)))
