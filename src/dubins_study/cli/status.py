"""`dubins-study status`: what a results folder holds."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from itertools import chain
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from dubins_study.cli.terminal.arguments import Json
from dubins_study.cli.terminal.output import duration, listing, plain, table

if TYPE_CHECKING:
    from dubins_study.experiments.store.status import Status
    from dubins_study.study.rows.manifest import RunEntry

_MOST_RUNS = 10  # only the last runs are listed
_MOST_NAMES = 5  # in one line; `--json` names all


def status(
    folder: Annotated[FilePath, typer.Argument(metavar="DIR", help="a results folder")],
    as_json: Json = False,
) -> None:
    """Tell what a results folder holds.

    Cells that are done, left or failing; its runs; the time that the rest will take.
    """
    from dubins_study.experiments.store.status import status as status_of

    print_status(status_of(folder), as_json)


def print_status(progress: Status, as_json: bool) -> None:
    """Print the status as JSON, or as text."""
    if as_json:
        print(json.dumps(progress.as_json(), indent=2))
    else:
        print(status_text(progress))


def status_text(progress: Status) -> str:
    """The status as lines and two tables."""
    fields: dict[str, str] = {}
    if progress.left:
        fields["left"] = _largest(progress.left)
        fields["time left"] = _time_left(progress)
    if progress.failing:
        fields["failing"] = _largest(progress.failing)
    fields["reasons"] = "; ".join(progress.reasons[:_MOST_NAMES])
    if progress.stale:
        fields["stale"] = f"{progress.stale} rows of earlier code, which count for nothing"
    if progress.damaged:
        fields["damaged"] = (
            f"parts: {progress.damaged}; run again, and their cells are solved again"
        )
    if progress.aside:
        fields["set aside"] = f"damaged parts: {progress.aside}, in damaged/ by earlier runs"
    done = f"{progress.done} of {progress.cells} cells done"
    head = f"{plain(progress.folder)}: {done}, {_state(progress)}"
    return "\n\n".join([f"{head}\n{listing(fields)}".rstrip(), *_tables(progress)])


def _state(progress: Status) -> str:
    if progress.process is not None:
        return f"running: process {progress.process or 'unknown'} is at work"
    if progress.finished:
        return "finished"
    return "not finished: run it again to go on"


def _largest(counts: Mapping[str, int]) -> str:
    """The sum, and the names with the largest counts.

    An example is `12: ipopt 5, slsqp 4, piqp 2, osqp 1`. Further names are counted.
    """
    largest = Counter(counts).most_common(_MOST_NAMES)
    text = ", ".join(f"{name} {number}" for name, number in largest)
    more = len(counts) - len(largest)
    if more:
        text += f" and {more} more"
    return f"{sum(counts.values())}: {text}"


def _time_left(progress: Status) -> str:
    if progress.seconds_left is None:
        return "unknown: no row is done yet to judge by"
    return f"about {duration(progress.seconds_left)}; jobs: {progress.jobs}"


def _tables(progress: Status) -> list[str]:
    tables = []
    kinds = sorted(set(chain.from_iterable(progress.verdicts.values())))
    if kinds:
        rows = [(solver, *map(counts.get, kinds)) for solver, counts in progress.verdicts.items()]
        tables.append(table(("solver", *kinds), rows))
    if progress.runs:
        head = ("run", "started, UTC", "took", "state", "executor", "jobs", "speed varied by")
        tables.append(table(head, [_run(run) for run in progress.runs[-_MOST_RUNS:]]))
    return tables


def _run(run: RunEntry) -> tuple[object, ...]:
    """Cells of a run in the table of runs."""
    took = ""
    if run.seconds is not None:
        took = duration(run.seconds)
    speed_variation = ""
    if run.spread is not None:
        speed_variation = f"{100 * run.spread:.1f} %"
    return (
        run.run_id,
        run.started[:19].replace("T", " "),  # without fractions of a second
        took,
        run.state,
        run.executor,
        run.jobs,
        speed_variation,
    )
