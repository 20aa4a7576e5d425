"""How far a results folder is: done, left, failing, and how long the rest will take."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

from dubins_study.experiments.store.folder import DAMAGED, RowCount, count_rows
from dubins_study.experiments.store.lock import is_locked, lock_holder
from dubins_study.experiments.store.manifest_changes import KILLED, RUNNING
from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.manifest import Manifest, RunEntry, read_manifest

# a live run may replace its parts while they are read
_MAX_TRIES = 3
_RUN_FIELDS = {"run_id", "started", "ended", "seconds", "state", "jobs", "engine"}


@dataclass(frozen=True)
class Status:
    """What a results folder holds.

    Args:
        cells: how many it is asked for.
        left: how many of these are not done, by solver; solvers with nothing left are not named.
        failing: rows by outcome, `returned` left out.
        verdicts: by solver, rows by verdict, or by outcome where nothing returned.
        stale: rows of earlier code, which count for nothing.
        damaged: parts that cannot be read.
        aside: damaged parts that runs have moved away.
        process: the pid of the run that is going on, 0 if it is unknown; None if there is none.
        jobs: of the last run.
        seconds_left: an estimate of what is left, with `jobs` processes, from the mean time of
            each solver's rows and the overhead of the runs so far; without the solvers named in
            `unknown`, of which there is no row to judge by.
        runs: the earliest first; of a run that was killed, the state is `killed`.
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
        """Plain values; `left` is the number, `left_by_solver` gives it solver by solver."""
        return {
            **vars(self),
            "left": sum(self.left.values()),
            "left_by_solver": self.left,
            "runs": [
                run.model_dump(include=_RUN_FIELDS) | {"spread": run.spread} for run in self.runs
            ],
        }


def status(folder: str | FilePath) -> Status:
    """How far a results folder is; nothing is written, and a run may be going on in it.

    Raises:
        ResultsError: if it is no results folder, or a part is of another schema.
    """
    place = FilePath(folder)
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
    pid = lock_holder(folder).get("pid")
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
        finished=bool(manifest.finished) and not live,
        process=None if not live else pid if isinstance(pid, int) else 0,
        jobs=jobs,
        seconds_left=seconds,
        unknown=unknown,
        runs=runs,
    )


def _runs(runs: Sequence[RunEntry], live: bool) -> list[RunEntry]:
    """The runs; the state of those that were killed, which no run can write itself, is `killed`."""
    ended = [
        run.with_changes(state=KILLED) if run.state == RUNNING else run
        for run in (runs[:-1] if live else runs)
    ]
    return [*ended, *runs[len(ended) :]]


def _time_left(
    left: Mapping[str, int], counts: Sequence[RowCount], overhead_s: float, jobs: int
) -> tuple[float | None, list[str]]:
    """Seconds that the cells left will take, and the solvers that have no row to judge by."""
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
    """Seconds of a cell beyond its solve, over all runs that say how long they took."""
    run_s = {run.run_id: run.seconds * run.jobs for run in runs if run.seconds}
    timed = [count for count in counts if count.run_id in run_s]
    rows = sum(count.rows for count in timed)
    if not rows:
        return 0.0
    total_s = sum(run_s[run_id] for run_id in {count.run_id for count in timed})
    return max(0.0, (total_s - sum(count.wall_s for count in timed)) / rows)
