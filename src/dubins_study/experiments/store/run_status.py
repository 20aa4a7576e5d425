"""A run as a manifest tells of it, whoever wrote that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dubins_study.experiments.store.manifest import is_count
from dubins_study.experiments.store.run_entry import RUNNING
from dubins_study.study.rows.machine_noise import is_number, probes_of, varied


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
    """An entry of the manifest, whoever wrote it."""
    seconds: Any = entry.get("seconds")
    jobs: Any = entry.get("jobs")
    ended = entry.get("ended")
    return RunStatus(
        run_id=str(entry.get("run_id")),
        started=str(entry.get("started")),
        ended=None if ended is None else str(ended),
        seconds=float(seconds) if is_number(seconds) and seconds >= 0 else None,
        state=_state(entry, live),
        jobs=max(1, jobs) if is_count(jobs) else 1,
        engine=str(entry.get("engine", "local")),
        spread=varied(probes_of(entry)),
    )


def _state(entry: Mapping[str, Any], live: bool) -> str:
    """Running, finished, interrupted or killed, which a run cannot say of itself.

    Args:
        entry: a run's in the manifest, whoever wrote it.
        live: whether a process holds the folder, and this is the last of its runs.
    """
    state = str(entry.get("state"))
    return "killed" if state == RUNNING and not live else state
