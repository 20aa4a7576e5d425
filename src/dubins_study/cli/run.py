"""`dubins-study run`: an experiment, run or continued."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from dubins_study.cli.status import print_status
from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import number
from dubins_study.cli.terminal.output import plain

if TYPE_CHECKING:
    from dubins_study.experiments.interruption import Interruption

_EXPERIMENT = "a name, or the path of a .toml file; optional with --scenarios"
_SCENARIOS = "ask about these: .csv or .parquet, a row a scenario"
_SOLVERS = "instead of the experiment's own; may be given several times"
_LIMIT = "seconds after which a solve is ended"
_TRUST = "the experiment may name plug-ins and programs"
_SCHEDULER = "of Dask's, with --executor dask"
_JSON = "print the folder's status as one JSON object"


def run(
    experiment: Annotated[
        str | None, typer.Argument(metavar="EXPERIMENT", help=_EXPERIMENT)
    ] = None,
    scenarios: Annotated[FilePath | None, typer.Option(metavar="FILE", help=_SCENARIOS)] = None,
    out: Annotated[
        FilePath | None, typer.Option(metavar="DIR", help="default: results/<experiment or file>")
    ] = None,
    solver: Annotated[list[str] | None, typer.Option(metavar="SPEC", help=_SOLVERS)] = None,
    jobs: Annotated[int, typer.Option(metavar="N", help="processes; 1 where times are quoted")] = 1,
    time_limit: Annotated[
        float | None, typer.Option(metavar="SECONDS", parser=number, help=_LIMIT)
    ] = None,
    memory_limit: Annotated[
        float | None,
        typer.Option(metavar="GIB", parser=number, help="GiB that a solve may hold"),
    ] = None,
    repeats: Annotated[int | None, typer.Option(metavar="N", help="attempts per cell")] = None,
    restart: Annotated[bool, typer.Option("--restart", help="throw away earlier rows")] = False,
    trust_plugins: Annotated[bool, typer.Option("--trust-plugins", help=_TRUST)] = False,
    executor: Annotated[str, typer.Option(metavar="NAME", help="local, or dask")] = "local",
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help=_SCHEDULER)] = None,
    as_json: Annotated[bool, typer.Option("--json", help=_JSON)] = False,
    engine: Annotated[str | None, typer.Option(hidden=True)] = None,  # the old word for executor
) -> None:
    """Run an experiment, or go on with it.

    Cells that are done are skipped.
    """
    counts: list[int] = []  # number of cells done, and of all cells, as last reported
    with _interruptible(restart, counts) as stop:
        from dubins_study.experiments.run import OLD_WORD
        from dubins_study.experiments.run import run as run_experiment
        from dubins_study.experiments.store.status import status as status_of

        stop.check()
        if engine is not None:
            print(f"dubins-study: {OLD_WORD}", file=sys.stderr)
        with (
            output.solvers_to_stderr(),
            output.progress(str(experiment or scenarios), counts) as progress,
        ):
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
                executor=engine or executor,
                scheduler=scheduler,
                scenarios=scenarios,
                progress=progress,
            )
        state = status_of(folder)
        print_status(state, as_json)
        if state.finished and not as_json:  # the command on a line of its own, to be copied
            command = shlex.join(["dubins-study", "report", state.folder])
            print(f"\nits page:\n{plain(command)}")


@contextmanager
def _interruptible(restart: bool, counts: list[int]) -> Iterator[Interruption]:
    """Exit with code 130 after an interruption.

    A message tells how to go on. `counts` is empty, or has the numbers of cells done and of all
    cells. The block begins before the imports that take long: a library whose import is interrupted
    raises strange errors.
    """
    from dubins_study.experiments.interruption import Interruption

    try:
        with Interruption() as stop:
            yield stop
    except KeyboardInterrupt:
        cells = ""
        if counts:
            cells = "{} of {} cells are done and kept; ".format(*counts)
        next_step = "run the same command"
        if restart:
            next_step += " without --restart"
        print(f"interrupted; {cells}{next_step} to go on", file=sys.stderr)
        raise typer.Exit(130) from None
