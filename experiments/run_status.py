"""A run as a manifest tells of it, whoever wrote that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from experiments.calibration import spread
from experiments.manifest import is_count
from experiments.record import RUNNING


@dataclass(frozen=True)
class RunStatus:
    """A run as its manifest's entry tells it; what is missing there or makes no sense is None.

    Args:
        seconds: how long it took, or has taken so far.
        state: running, finished, interrupted or killed.
        spread: of the calibration probe (see `experiments.calibration.spread`).
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
        seconds=float(seconds) if _is_number(seconds) and seconds >= 0 else None,
        state=_state(entry, live),
        jobs=max(1, jobs) if is_count(jobs) else 1,
        engine=str(entry.get("engine", "local")),
        spread=spread(probe_seconds(entry)),
    )


def probe_seconds(entry: Mapping[str, Any]) -> list[float]:
    """What the calibration probe took, each time, in a run's entry."""
    listed = entry.get("probes")
    pairs = [p for p in listed if isinstance(p, list)] if isinstance(listed, list) else []
    return [float(p[1]) for p in pairs if len(p) == 2 and _is_number(p[1]) and p[1] > 0]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15


def _state(entry: Mapping[str, Any], live: bool) -> str:
    """Running, finished, interrupted or killed, which a run cannot say of itself.

    Args:
        entry: a run's in the manifest, whoever wrote it.
        live: whether a process holds the folder, and this is the last of its runs.
    """
    state = str(entry.get("state"))
    return "killed" if state == RUNNING and not live else state
