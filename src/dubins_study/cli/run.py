"""`dubins-study run`: an experiment, run or continued."""

from __future__ import annotations

import json
import sys
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.arguments import CommandError, number, whole_number
from dubins_study.cli.terminal import completion


def run(
    experiment: Annotated[
        str | None,
        typer.Argument(
            metavar="EXPERIMENT",
            help="a name, or the path of a .toml file; optional with --scenarios",
            autocompletion=completion.experiments,
        ),
    ] = None,
    scenarios: Annotated[
        FilePath | None,
        typer.Option(metavar="FILE", help="ask about these: .csv or .parquet, a row a scenario"),
    ] = None,
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: results/<experiment or file>")
    ] = None,
    solver: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SPEC",
            help="instead of the experiment's own; may be given several times",
            autocompletion=completion.solvers,
        ),
    ] = None,
    jobs: Annotated[
        int, typer.Option(parser=whole_number, help="processes; 1 where times are quoted")
    ] = 1,
    time_limit: Annotated[
        float | None, typer.Option(parser=number, help="seconds after which a solve is ended")
    ] = None,
    memory_limit: Annotated[
        float | None, typer.Option(parser=number, help="GiB that a solve may hold")
    ] = None,
    repeats: Annotated[
        int | None, typer.Option(parser=whole_number, help="attempts per cell")
    ] = None,
    restart: Annotated[bool, typer.Option("--restart", help="throw away earlier rows")] = False,
    trust_plugins: Annotated[
        bool, typer.Option("--trust-plugins", help="the experiment may name plug-ins and programs")
    ] = False,
    engine: Annotated[str, typer.Option(help="local, or dask")] = "local",
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of Dask's; default: one on this machine")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="print the folder's status as one JSON object")
    ] = False,
) -> None:
    """Run an experiment, or go on with it.

    Cells that are done are skipped.
    """
    from dubins_study.experiments.interruption import Interruption

    counts: list[int] = []  # number of cells done, and of all cells, as last reported
    try:
        # Before the other imports: a library whose import is interrupted raises strange errors.
        with Interruption() as stop:
            from dubins_study.cli.status import status_text
            from dubins_study.cli.terminal import streams
            from dubins_study.experiments.run import run as run_experiment
            from dubins_study.experiments.store.status import status as status_of

            stop.check()
            if experiment is None and scenarios is None:
                raise CommandError(
                    "run: no experiment; expected a name (dubins-study experiments lists them), a "
                    ".toml file, or --scenarios FILE with --solver SPEC"
                )
            if experiment is not None and scenarios is None:
                _check_section(experiment)
            name = experiment or str(scenarios)
            with streams.solvers_to_stderr(), streams.progress(name, counts) as progress:
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
                    scenarios=scenarios,
                    progress=progress,
                )
            folder_status = status_of(folder)
            print(
                json.dumps(folder_status.as_json(), indent=2)
                if as_json
                else status_text(folder_status)
            )
    except KeyboardInterrupt:
        next_step = "run the same command without --restart" if restart else "run the same command"
        cells = " ({} of {} cells done)".format(*counts) if counts else ""
        print(f"interrupted; what was done is kept, {next_step} to go on{cells}", file=sys.stderr)
        raise typer.Exit(130) from None


def _check_section(experiment: str) -> None:
    """Say so where an experiment's file names a section that the report does not have.

    Rows are rows whatever the report makes of them, so that the run goes on.
    """
    from dubins_study.experiments.definition.experiment import packaged, read

    section = None if experiment in packaged() else read(experiment).experiment.section
    if section is None:
        return
    from dubins_study.report.page.sections import KEYS
    from dubins_study.study.nearest import did_you_mean

    if section not in KEYS:
        print(
            f"dubins-study: no section of the report is called {section!r}; "
            f"{did_you_mean(section, KEYS)}"
            f"choose one of: {', '.join(KEYS)}",
            file=sys.stderr,
        )
