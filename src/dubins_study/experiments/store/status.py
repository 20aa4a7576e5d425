"""The status of a results folder.

Cells that are done, left and failing are counted, and the time left is estimated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import pandas as pd

from dubins_study.experiments.store.folder import DAMAGED, is_locked, lock_holder, read_rows
from dubins_study.experiments.store.manifest_changes import KILLED, RUNNING
from dubins_study.study.rows.manifest import Manifest, RunEntry, read_manifest
from dubins_study.study.rows.parts import ResultsError, folder_paths

# Attempts to read a folder: a running run may replace its parts while they are read.
_MAX_TRIES = 3
_COLUMNS = ["outcome", "verdict", "message", "wall_s"]  # beside those of the key
_RUN_FIELDS = {"run_id", "started", "ended", "seconds", "state", "jobs", "executor"}


@dataclass(frozen=True)
class Status:
    """The state of a results folder.

    Args:
        cells: number of cells that it should hold.
        left: solver -> number of cells that are not done; only solvers with cells left.
        failing: outcome -> number of rows, without `returned` and `unsupported`.
        reasons: why solvers are unavailable.
        verdicts: solver -> verdict -> number of rows; the outcome replaces a missing verdict.
        stale: number of rows of earlier code, which do not count.
        damaged: number of parts that cannot be read.
        aside: number of damaged parts that runs have moved away.
        finished: whether a run has come to the end and no cell is left.
        process: pid of the current run, 0 if it is unknown; None if no run is active.
        jobs: number of jobs of the last run.
        seconds_left: estimated time (s) for the cells that are left, with `jobs` processes: the
            mean of a solve so far, since their order is random. None without rows.
        runs: the runs, the earliest first; the state of a killed run is `killed`.
    """

    folder: str
    cells: int
    done: int
    left: dict[str, int]
    failing: dict[str, int]
    reasons: list[str]
    verdicts: dict[str, dict[str, int]]
    stale: int
    damaged: int
    aside: int
    finished: bool
    process: int | None
    jobs: int
    seconds_left: float | None
    runs: list[RunEntry]

    def as_json(self) -> dict[str, Any]:
        """The status in plain values.

        `left` is the total number, `left_by_solver` the number per solver.
        """
        return {
            **vars(self),
            "left": sum(self.left.values()),
            "left_by_solver": self.left,
            "runs": [
                run.model_dump(include=_RUN_FIELDS) | {"spread": run.spread} for run in self.runs
            ],
        }


def status(folder: str | FilePath) -> Status:
    """The status of a results folder.

    Nothing is written, and a run may be active in the folder.

    Raises:
        ResultsError: if it is not a results folder, or a part has another schema.
    """
    [place] = folder_paths([folder])
    tries_left = _MAX_TRIES
    while True:
        tries_left -= 1
        live = is_locked(place)
        manifest = read_manifest(place)
        damaged: list[FilePath] = []
        try:
            table = read_rows(place, _COLUMNS, damaged)
        except ResultsError:
            if live and tries_left:
                continue
            raise
        # a spoilt row may lack any of them
        blanks = {"outcome": "", "verdict": "", "message": "", "wall_s": 0.0}
        return _status(place, manifest, table.to_pandas().fillna(blanks), len(damaged), live)


def _status(
    folder: FilePath, manifest: Manifest, rows: pd.DataFrame, damaged: int, live: bool
) -> Status:
    """The status by a folder's manifest and rows.

    Rows of other code than the manifest's are counted as `stale`, and nowhere else.
    """
    current = rows[rows["code_digest"] == rows["solver"].map(manifest.code_digests)]
    done = _counts(current["solver"])
    failed = current["outcome"][~current["outcome"].isin(("returned", "unsupported"))]
    endings = current["verdict"].where(current["outcome"] == "returned", current["outcome"])
    left = {
        spec: entry.cells - done.get(spec, 0)
        for spec, entry in manifest.solvers.items()
        if entry.cells > done.get(spec, 0)
    }
    runs = _runs(manifest.runs, live)
    jobs = 1
    if runs:
        jobs = runs[-1].jobs
    waiting = sum(left.values())
    seconds_left: float | None = 0.0  # nothing is left; None if no row tells how long a solve takes
    if waiting:
        seconds_left = None
        if len(current):
            seconds_left = float(current["wall_s"].mean()) * waiting / jobs
    return Status(
        folder=str(folder),
        cells=manifest.cells,
        done=len(current),
        left=left,
        failing=_counts(failed),
        reasons=current.loc[current["outcome"] == "unavailable", "message"].unique().tolist(),
        verdicts={str(s): _counts(group) for s, group in endings.groupby(current["solver"])},
        stale=len(rows) - len(current),
        damaged=damaged,
        aside=len(list((folder / DAMAGED).glob("*.parquet"))),
        finished=bool(manifest.finished) and not live and not left,
        process=_process(folder, live),
        jobs=jobs,
        seconds_left=seconds_left,
        runs=runs,
    )


def _process(folder: FilePath, live: bool) -> int | None:
    """The current run's pid, or 0 if unknown.

    None if no run is active.
    """
    if not live:
        return None
    pid = lock_holder(folder).get("pid")
    if not isinstance(pid, int):
        return 0
    return pid


def _counts(values: pd.Series[str]) -> dict[str, int]:
    return {str(value): int(count) for value, count in values.value_counts().items()}


def _runs(runs: Sequence[RunEntry], live: bool) -> list[RunEntry]:
    """The runs of a folder, with their states.

    A run that ended without writing its final state is `killed`, its time unknown.
    """
    ended = runs
    if live:
        ended = runs[:-1]  # the last run is the one that is active
    shown = [*runs]
    for place, run in enumerate(ended):
        if run.state == RUNNING:
            shown[place] = run.with_changes(state=KILLED, seconds=None)
    return shown
