"""A run as a manifest tells of it, whoever wrote that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dubins_study.experiments.store.run_entry import RUNNING
from dubins_study.study.rows.machine_noise import varied
from dubins_study.study.rows.manifest import RunEntry


@dataclass(frozen=True)
class RunStatus:
    """A run as its manifest's entry tells it; what is missing there or makes no sense is None.

    Args:
        seconds: how long it took, or has taken so far.
        state: running, finished, interrupted or killed.
        spread: of the calibration probe (see `study.rows.machine_noise.varied`).
    """

    run_id: str
    started: str
    ended: str | None
    seconds: float | None
    state: str
    jobs: int
    engine: str
    spread: float | None


def run_status(entry: Mapping[str, Any], live: bool) -> RunStatus:
    """An entry of the manifest, whoever wrote it.

    Args:
        entry: a run's.
        live: whether a process holds the folder, and this is the last of its runs.
    """
    run = RunEntry.model_validate(entry)
    killed = run.state == RUNNING and not live
    return RunStatus(
        run_id=run.run_id,
        started=run.started,
        ended=run.ended,
        seconds=run.seconds,
        state="killed" if killed else run.state,
        jobs=run.jobs,
        engine=run.engine,
        spread=varied(run.probes),
    )
