"""`dubins-study status`: what a results folder holds."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from dubins_study.cli.terminal.arguments import Json
from dubins_study.cli.terminal.output import duration, plain, table

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

    state = status_of(folder)
    print(json.dumps(state.as_json(), indent=2) if as_json else status_text(state))


def status_text(progress: Status) -> str:
    """The status as a few lines and two tables for the terminal."""
    from dubins_study.study.rows.manifest import NOISY

    done = f"{progress.done} of {progress.cells} cells done"
    lines = [f"{plain(progress.folder)}: {done}, {_state(progress)}"]
    left = sum(progress.left.values())
    if left:
        lines.append(f"left      {left}: {_listed(progress.left)}")
    if progress.failing:
        lines.append(f"failing   {sum(progress.failing.values())}: {_listed(progress.failing)}")
    lines += [f"reason    {plain(reason)}" for reason in progress.reasons[:_MOST_NAMES]]
    if progress.stale:
        lines.append(f"stale     {progress.stale} rows of earlier code, which count for nothing")
    if progress.damaged:
        lines.append(
            f"damaged   {_some(progress.damaged)}; run again, and its cells are solved again"
        )
    if progress.aside:
        lines.append(f"set aside {_some(progress.aside)} in damaged/ by earlier runs")
    if left:
        lines.append(f"time left {_time_left(progress)}")
    lines += [_noise(run) for run in progress.runs if run.spread is not None and run.spread > NOISY]
    return "\n\n".join(["\n".join(lines), *_tables(progress)])


def _state(progress: Status) -> str:
    if progress.process is not None:
        return f"running: process {progress.process or 'unknown'} is at work"
    return "finished" if progress.finished else "not finished: run it again to go on"


def _listed(counts: Mapping[str, int]) -> str:
    """The names with the largest counts, and how many more there are."""
    largest = sorted(counts.items(), key=lambda item: -item[1])
    texts = [f"{plain(name)} {number}" for name, number in largest]
    more = len(texts) - _MOST_NAMES
    return ", ".join(texts[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def _some(parts: int) -> str:
    return f"{parts} damaged part{'' if parts == 1 else 's'}"


def _time_left(progress: Status) -> str:
    jobs = f"with {progress.jobs} job{'' if progress.jobs == 1 else 's'}"
    if progress.seconds_left is None:
        return "unknown: no row is done yet to judge by"
    return f"about {duration(progress.seconds_left)} {jobs}"


def _noise(run: RunEntry) -> str:
    return (
        f"noise     the machine's speed varied by {100 * (run.spread or 0):.1f} % during run "
        f"{plain(run.run_id)}: its times are worth that much less"
    )


def _tables(progress: Status) -> list[str]:
    tables = []
    kinds = sorted({kind for counts in progress.verdicts.values() for kind in counts})
    if kinds:
        rows = [
            (plain(solver), *(str(counts.get(kind, "")) for kind in kinds))
            for solver, counts in progress.verdicts.items()
        ]
        tables.append(table(("solver", *map(plain, kinds)), rows))
    if progress.runs:
        head = ("run", "started, UTC", "took", "state", "executor", "jobs", "speed varied by")
        tables.append(table(head, [_run(run) for run in progress.runs[-_MOST_RUNS:]]))
    return tables


def _run(run: RunEntry) -> tuple[str, ...]:
    return (
        plain(run.run_id),
        plain(run.started[:19].replace("T", " ")),  # without fractions of a second
        "" if run.seconds is None else duration(run.seconds),
        plain(run.state),
        plain(run.executor),
        str(run.jobs),
        "" if run.spread is None else f"{100 * run.spread:.1f} %",
    )
