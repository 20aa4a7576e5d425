"""How far a results folder is: done, left, failing, and what the rest will take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.store.disk import StoreError
from dubins_study.experiments.store.lock import held, holder
from dubins_study.experiments.store.manifest import read_manifest
from dubins_study.experiments.store.parts import DAMAGED
from dubins_study.experiments.store.run_status import RunStatus, run_status
from dubins_study.experiments.store.tally import Tally, counted

# a live run may replace its parts while they are read
_TRIES = 3


@dataclass(frozen=True)
class Status:
    """What a results folder holds.

    Args:
        cells: how many it is asked for.
        left: how many of these are not done, by solver; solvers with nothing left are not named.
        failing: rows by outcome, those that returned left out.
        verdicts: rows by verdict (or by outcome, if nothing returned), solver by solver.
        stale: rows of earlier code, which count for nothing.
        damaged: parts that cannot be read.
        aside: damaged parts that runs have put aside.
        process: what runs there now, if anything does: its pid.
        seconds_left: an estimate of what is left, with `jobs` processes as in the last run, from
            the mean time of each solver's rows and what the runs so far took beside; without the
            solvers named in `unknown`, of which no row is there to judge by.
    """

    folder: str
    cells: int
    done: int
    left: dict[str, int]
    failing: dict[str, int]
    verdicts: dict[str, dict[str, int]]
    stale: int
    damaged: int
    aside: int
    finished: bool
    process: int | None
    jobs: int
    seconds_left: float | None
    unknown: list[str]
    runs: list[RunStatus]

    def as_json(self) -> dict[str, Any]:
        """Plain values; `left` is the number, `left_by_solver` tells it solver by solver."""
        return {**asdict(self), "left": sum(self.left.values()), "left_by_solver": self.left}


def status(folder: str | FilePath) -> Status:
    """How far a results folder is; nothing is written, and a run may be going on in it.

    Raises:
        StoreError: if it is none, or a part is of another schema.
    """
    place = FilePath(folder)
    for attempt in range(_TRIES):
        live, manifest = held(place), read_manifest(place)
        try:
            tallies, damaged = counted(place)
        except StoreError:
            if not live or attempt == _TRIES - 1:
                raise
        else:
            break
    return _status(place, manifest, tallies, damaged, live)


def _status(
    folder: FilePath, manifest: Mapping[str, Any], tallies: list[Tally], damaged: int, live: bool
) -> Status:
    solvers = manifest.get("solvers") or {}
    current = [t for t in tallies if solvers.get(t.solver, {}).get("code_digest") == t.code_digest]
    done: Counter[str] = Counter()
    failing: Counter[str] = Counter()
    verdicts: dict[str, dict[str, int]] = {}
    for tally in current:
        done[tally.solver] += tally.rows
        returned = tally.outcome == "returned"
        if not returned:
            failing[tally.outcome] += tally.rows
        own = verdicts.setdefault(tally.solver, {})
        said = tally.verdict if returned else tally.outcome
        own[said] = own.get(said, 0) + tally.rows
    asked = {spec: known.get("cells", 0) for spec, known in solvers.items()}
    left = {spec: cells - done[spec] for spec, cells in asked.items() if cells > done[spec]}
    entries = manifest.get("runs") or []
    runs = [run_status(entry, live and entry is entries[-1]) for entry in entries]
    jobs = runs[-1].jobs if runs else 1
    seconds, unknown = _time_left(left, current, tallies, runs, jobs)
    pid = holder(folder).get("pid") if live else None
    aside = folder / DAMAGED
    return Status(
        folder=str(folder),
        cells=manifest["cells"],
        done=done.total(),
        left=left,
        failing=dict(failing.most_common()),
        verdicts=dict(sorted(verdicts.items())),
        stale=sum(t.rows for t in tallies) - done.total(),
        damaged=damaged,
        aside=len(list(aside.glob("*.parquet"))) if aside.is_dir() else 0,
        finished=bool(manifest.get("finished")) and not live,
        process=pid if isinstance(pid, int) else 0 if live else None,
        jobs=jobs,
        seconds_left=seconds,
        unknown=unknown,
        runs=runs,
    )


def _time_left(
    left: Mapping[str, int],
    current: list[Tally],
    tallies: list[Tally],
    runs: list[RunStatus],
    jobs: int,
) -> tuple[float | None, list[str]]:
    """Seconds that the cells left will take, and the solvers that nothing is known of."""
    rows: Counter[str] = Counter()
    wall: dict[str, float] = {}
    for tally in current:
        rows[tally.solver] += tally.rows
        wall[tally.solver] = wall.get(tally.solver, 0.0) + tally.wall
    unknown = [spec for spec in left if not rows[spec]]
    known = {spec: cells for spec, cells in left.items() if rows[spec]}
    if unknown and not known:
        return None, unknown
    solving = sum(cells * wall[spec] / rows[spec] for spec, cells in known.items())
    beside = sum(known.values()) * _overhead(tallies, runs)
    return (solving + beside) / jobs, unknown


def _overhead(tallies: list[Tally], runs: list[RunStatus]) -> float:
    """Seconds that a cell took beside its solve, over all runs that say how long they took."""
    timed = {run.run_id: run for run in runs if run.seconds}
    own = [tally for tally in tallies if tally.run_id in timed]
    rows = sum(tally.rows for tally in own)
    used = {tally.run_id for tally in own}
    took = sum(run.seconds * run.jobs for key, run in timed.items() if key in used and run.seconds)
    return max(0.0, (took - sum(tally.wall for tally in own)) / rows) if rows else 0.0
