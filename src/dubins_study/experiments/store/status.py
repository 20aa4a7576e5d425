"""The status of a results folder: cells done, left and failing, and the time left."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.store.folder import DAMAGED, RowCount, count_rows
from dubins_study.experiments.store.lock import is_locked, lock_holder
from dubins_study.experiments.store.manifest_changes import KILLED, RUNNING
from dubins_study.study.rows.manifest import Manifest, RunEntry, read_manifest
from dubins_study.study.rows.parts import ResultsError, folder_paths

# Attempts to read a folder: a running run may replace its parts while they are read.
_MAX_TRIES = 3
_RUN_FIELDS = {"run_id", "started", "ended", "seconds", "state", "jobs", "engine"}


@dataclass(frozen=True)
class Status:
    """What a results folder holds.

    Args:
        cells: number of cells that it should hold.
        left: solver -> number of cells that are not done; only solvers with cells left.
        failing: outcome -> number of rows, without `returned`.
        verdicts: solver -> verdict -> number of rows; the outcome replaces a missing verdict.
        stale: number of rows of earlier code, which do not count.
        damaged: number of parts that cannot be read.
        aside: number of damaged parts that runs have moved away.
        finished: whether a run has come to the end and no cell is left.
        process: pid of the current run, 0 if it is unknown; None if no run is active.
        jobs: number of jobs of the last run.
        seconds_left: estimated time (s) for the cells that are left, with `jobs` processes. It uses
            the mean time of each solver's rows and the overhead of earlier runs, and leaves out the
            solvers in `unknown`.
        unknown: solvers with cells left but without any row, so that their time is unknown.
        runs: the runs, the earliest first; the state of a killed run is `killed`.
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
    runs: list[RunEntry]

    def as_json(self) -> dict[str, Any]:
        """Plain values; `left` is the total number, `left_by_solver` the number per solver."""
        return {
            **vars(self),
            "left": sum(self.left.values()),
            "left_by_solver": self.left,
            "runs": [
                run.model_dump(include=_RUN_FIELDS) | {"spread": run.spread} for run in self.runs
            ],
        }


def status(folder: str | FilePath) -> Status:
    """The status of a results folder. Nothing is written, and a run may be active in the folder.

    Raises:
        ResultsError: if it is not a results folder, or a part has another schema.
    """
    [place] = folder_paths([folder])
    for attempt in range(_MAX_TRIES):
        live, manifest = is_locked(place), read_manifest(place)
        try:
            counts, damaged = count_rows(place)
        except ResultsError:
            if not live or attempt == _MAX_TRIES - 1:
                raise
        else:
            break
    return _status(place, manifest, counts, damaged, live)


def _status(
    folder: FilePath, manifest: Manifest, counts: list[RowCount], damaged: int, live: bool
) -> Status:
    digests = manifest.code_digests
    current = [count for count in counts if digests.get(count.solver) == count.code_digest]
    rows, failing = Counter[str](), Counter[str]()
    verdicts = defaultdict[str, Counter[str]](Counter)
    for count in sorted(current):
        rows[count.solver] += count.rows
        returned = count.outcome == "returned"
        if not returned:
            failing[count.outcome] += count.rows
        verdicts[count.solver][count.verdict if returned else count.outcome] += count.rows
    left = {
        spec: entry.cells - rows[spec]
        for spec, entry in manifest.solvers.items()
        if entry.cells > rows[spec]
    }
    runs = _runs(manifest.runs, live)
    jobs = runs[-1].jobs if runs else 1
    seconds, unknown = _time_left(left, current, _overhead(counts, runs), jobs)
    pid = lock_holder(folder).get("pid", 0) if live else None
    aside = folder / DAMAGED
    return Status(
        folder=str(folder),
        cells=manifest.cells,
        done=rows.total(),
        left=left,
        failing=dict(failing.most_common()),
        verdicts={spec: dict(of_solver) for spec, of_solver in verdicts.items()},
        stale=sum(count.rows for count in counts) - rows.total(),
        damaged=damaged,
        aside=len(list(aside.glob("*.parquet"))) if aside.is_dir() else 0,
        finished=bool(manifest.finished) and not live and not left,
        process=pid if pid is None or isinstance(pid, int) else 0,
        jobs=jobs,
        seconds_left=seconds,
        unknown=unknown,
        runs=runs,
    )


def _runs(runs: Sequence[RunEntry], live: bool) -> list[RunEntry]:
    """The runs; one that ended without writing its final state is `killed`, its time unknown."""
    ended = [
        run.with_changes(state=KILLED, seconds=None) if run.state == RUNNING else run
        for run in (runs[:-1] if live else runs)
    ]
    return [*ended, *runs[len(ended) :]]


def _time_left(
    left: Mapping[str, int], counts: Sequence[RowCount], overhead_s: float, jobs: int
) -> tuple[float | None, list[str]]:
    """Estimated seconds for the cells that are left, and the solvers without any row."""
    rows, wall_s = Counter[str](), defaultdict[str, float](float)
    for count in counts:
        rows[count.solver] += count.rows
        wall_s[count.solver] += count.wall_s
    known = {spec: cells for spec, cells in left.items() if rows[spec]}
    unknown = [spec for spec in left if spec not in known]
    if unknown and not known:
        return None, unknown
    seconds = (n * (wall_s[spec] / rows[spec] + overhead_s) for spec, n in known.items())
    return sum(seconds) / jobs, unknown


def _overhead(counts: Sequence[RowCount], runs: Sequence[RunEntry]) -> float:
    """Mean seconds per cell in addition to its solve, over all runs that recorded a duration."""
    run_s = {run.run_id: run.seconds * run.jobs for run in runs if run.seconds}
    timed = [count for count in counts if count.run_id in run_s]
    rows = sum(count.rows for count in timed)
    if not rows:
        return 0.0
    total_s = sum(run_s[run_id] for run_id in {count.run_id for count in timed})
    return max(0.0, (total_s - sum(count.wall_s for count in timed)) / rows)
