"""`dubins-study run`: an experiment, run or continued."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from dubins_study.cli import arguments
from dubins_study.cli.terminal.refusals import CommandError

if TYPE_CHECKING:
    from dubins_study.experiments.interruption import Interruption
    from dubins_study.experiments.store.status import Status


def run(
    experiment: arguments.Experiment = None,
    scenarios: arguments.Scenarios = None,
    out: arguments.ResultsFolder = None,
    solver: arguments.Specs = None,
    jobs: arguments.Jobs = 1,
    time_limit: arguments.CellLimit = None,
    memory_limit: arguments.MemoryLimit = None,
    repeats: arguments.Repeats = None,
    restart: arguments.Restart = False,
    trust_plugins: arguments.TrustPlugins = False,
    engine: arguments.Engine = "local",
    scheduler: arguments.Scheduler = None,
    as_json: arguments.StatusJson = False,
) -> None:
    """Run an experiment, or go on with it.

    Cells that are done are skipped.
    """
    counts: list[int] = []  # number of cells done, and of all cells, as last reported
    with _interruptible(restart, counts) as stop:
        from dubins_study.cli.terminal import streams
        from dubins_study.experiments.run import run as run_experiment
        from dubins_study.experiments.store.status import status as status_of

        stop.check()
        _check_names(experiment, None if scenarios is None else str(scenarios))
        with (
            streams.solvers_to_stderr(),
            streams.progress(experiment or str(scenarios), counts) as progress,
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
                engine=engine,
                scheduler=scheduler,
                scenarios=scenarios,
                progress=progress,
            )
        _print_status(status_of(folder), as_json)


def _print_status(state: Status, as_json: bool) -> None:
    """What the folder of a run holds and, once it is finished, how to see it."""
    from dubins_study.cli.status import status_text
    from dubins_study.study.values import plain

    if as_json:
        print(json.dumps(state.as_json(), indent=2))
        return
    print(status_text(state))
    if state.finished:
        # on a line of its own, to be copied
        print(f"\nits page:\n{plain(shlex.join(['dubins-study', 'report', state.folder]))}")


@contextmanager
def _interruptible(restart: bool, counts: list[int]) -> Iterator[Interruption]:
    """After an interruption, say how to go on, and exit with code 130.

    Entered before the imports that take long: a library whose import is interrupted raises strange
    errors.

    Args:
        restart: whether the command throws away earlier rows.
        counts: the numbers of cells done and of all cells, once they are known.
    """
    from dubins_study.experiments.interruption import Interruption

    try:
        with Interruption() as stop:
            yield stop
    except KeyboardInterrupt:
        next_step = "run the same command without --restart" if restart else "run the same command"
        cells = " ({} of {} cells done)".format(*counts) if counts else ""
        print(f"interrupted; what was done is kept, {next_step} to go on{cells}", file=sys.stderr)
        raise typer.Exit(130) from None


def _check_names(experiment: str | None, scenarios: str | None) -> None:
    """Refuse a run of nothing; warn of an experiment whose report's section does not exist."""
    if experiment is None and scenarios is None:
        raise CommandError(
            "run: no experiment; expected a name (dubins-study experiments lists them), a "
            ".toml file, or --scenarios FILE with --solver SPEC"
        )
    if experiment is not None and scenarios is None:
        _check_section(experiment)


def _check_section(experiment: str) -> None:
    """Say so where an experiment's file names a section that the report does not have.

    Rows are rows whatever the report makes of them, so that the run goes on.
    """
    from dubins_study.experiments.definition.experiment_text import packaged, text_of

    section = None if experiment in packaged() else text_of(experiment).fields().get("section")
    if not isinstance(section, str):
        return
    from dubins_study.report.page.sections import KEYS
    from dubins_study.study.values import did_you_mean

    if section not in KEYS:
        print(
            f"dubins-study: no section of the report is called {section!r}; "
            f"{did_you_mean(section, KEYS)}"
            f"choose one of: {', '.join(KEYS)}",
            file=sys.stderr,
        )
