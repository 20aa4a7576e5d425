"""What `dubins-study status` and `merge` print."""

from __future__ import annotations

import json
from collections.abc import Mapping

from dubins_study.cli.show import table
from dubins_study.experiments.store.merge import Union
from dubins_study.experiments.store.status import RunStatus, Status
from dubins_study.study.printable import plain
from dubins_study.study.rows.machine_noise import NOISY

# runs listed at most, the last ones
_MOST_RUNS = 10


def status_json(found: Status) -> str:
    """One object."""
    return json.dumps(found.as_json(), indent=2)


def status_text(found: Status) -> str:
    """A few lines and two tables for a person."""
    lines = [f"{plain(found.folder)}: {found.done} of {found.cells} cells done, {_state(found)}"]
    left = sum(found.left.values())
    if left:
        lines.append(f"left      {left}: {_listed(found.left)}")
    if found.failing:
        lines.append(f"failing   {sum(found.failing.values())}: {_listed(found.failing)}")
    if found.stale:
        lines.append(f"stale     {found.stale} rows of earlier code, which count for nothing")
    if found.damaged:
        lines.append(f"damaged   {_some(found.damaged)}; run again, and its cells are solved again")
    if found.aside:
        lines.append(f"set aside {_some(found.aside)} in damaged/ by earlier runs")
    if left:
        lines.append(f"time left {_time_left(found)}")
    lines += [_noise(run) for run in found.runs if run.spread is not None and run.spread > NOISY]
    return "\n".join([*lines, *_tables(found)])


def _state(found: Status) -> str:
    if found.process is not None:
        return f"running: process {found.process or 'unknown'} is at work"
    return "finished" if found.finished else "not finished: run it again to go on"


def _listed(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{plain(name)} {number}" for name, number in counts.items())


def _some(parts: int) -> str:
    return f"{parts} damaged part{'' if parts == 1 else 's'}"


def _time_left(found: Status) -> str:
    jobs = f"with {found.jobs} job{'' if found.jobs == 1 else 's'}"
    if found.seconds_left is None:
        return "unknown: no row is done yet to judge by"
    said = f"about {duration(found.seconds_left)} {jobs}"
    if found.unknown:
        said += f", without {', '.join(map(plain, found.unknown))}: no row is done yet to judge by"
    return said


def duration(seconds: float) -> str:
    """A duration as a person says it, two digits or so."""
    for unit, length in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"


def _noise(run: RunStatus) -> str:
    return (
        f"noise     the machine's speed varied by {100 * (run.spread or 0):.1f} % during run "
        f"{plain(run.run_id)}: its times are worth that much less"
    )


def _tables(found: Status) -> list[str]:
    shown = []
    kinds = sorted({kind for own in found.verdicts.values() for kind in own})
    if kinds:
        rows = [
            (plain(solver), *(str(own.get(kind, "")) for kind in kinds))
            for solver, own in found.verdicts.items()
        ]
        shown.append(table(("solver", *map(plain, kinds)), rows))
    if found.runs:
        head = ("run", "started", "took", "state", "engine", "jobs", "speed varied by")
        shown.append(table(head, [_run(run) for run in found.runs[-_MOST_RUNS:]]))
    return shown


def _run(run: RunStatus) -> tuple[str, ...]:
    return (
        plain(run.run_id),
        plain(run.started),
        "" if run.seconds is None else duration(run.seconds),
        plain(run.state),
        plain(run.engine),
        str(run.jobs),
        "" if run.spread is None else f"{100 * run.spread:.1f} %",
    )


def merge_text(made: Union) -> str:
    """What a merge made, in a line or three."""
    lines = [f"{plain(str(made.folder))}: {made.rows} rows"]
    if made.again:
        lines.append(f"{made.again} cells were solved in several folders, alike: the earliest kept")
    if made.stale:
        lines.append(f"{made.stale} rows are of another code than the first folder's, thus stale")
    return "\n".join(lines)
