"""A run's own entry in the manifest: what it was asked, where, and how it went."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

from dubins_study.experiments.provenance import (
    governor,
    load_average,
    machine,
    now,
    source,
    thread_limits,
)
from dubins_study.experiments.store.disk import StoreError
from dubins_study.experiments.store.manifest import write_manifest

# how often a run that goes on brings its entry up to date, in seconds
_BEAT = 2.0
# a manifest is read and written as a whole
_MOST_PROBES = 1000

RUNNING, FINISHED, INTERRUPTED = "running", "finished", "interrupted"


class RunRecord:
    """Keeps the entry of the run that is going on; durations by a clock that never jumps."""

    def __init__(self, folder: FilePath, manifest: dict[str, Any], asked: Mapping[str, Any]):
        self._folder, self._manifest, self._began = folder, manifest, monotonic()
        self._written = self._began
        self._made, self._stride = 0, 1
        self._entry: dict[str, Any] = {
            **asked,
            "machine": machine(),
            "governor": governor(),
            "thread_limits": thread_limits(),
            "git": source(),
            "load_start": load_average(),
            "load_end": None,
            "started": now(),
            "ended": None,
            "seconds": 0.0,
            "state": RUNNING,
            "probes": [],
        }
        manifest["runs"] = [*manifest["runs"], self._entry]

    def probe(self, seconds: float, machine: int = 0) -> None:
        """Note how long the calibration probe just took, and on which of several machines.

        Of more than `_MOST_PROBES` every other is forgotten, and of those to come.
        """
        self._made += 1
        if self._made % self._stride == 0:
            probes = self._entry["probes"]
            when = round(monotonic() - self._began, 3)
            probes.append([when, round(seconds, 9), *([machine] if machine else [])])
            if len(probes) > _MOST_PROBES:
                self._stride *= 2
                del probes[::2]
        self.beat()

    def beat(self) -> None:
        """The run goes on: how long it has taken is written once in a while."""
        if monotonic() - self._written > _BEAT:
            self.write()

    def write(self, **changes: Any) -> None:
        """Bring the manifest up to date.

        Raises:
            StoreError: if the folder cannot be written.
        """
        self._written = monotonic()
        self._entry |= {"seconds": round(self._written - self._began, 3), **changes}
        write_manifest(self._folder, self._manifest)

    def close(self, state: str) -> None:
        """The last word on the run."""
        self.write(state=state, ended=now(), load_end=load_average())


@contextmanager
def recorded(
    folder: FilePath, manifest: dict[str, Any], asked: Mapping[str, Any], completes: bool = True
) -> Iterator[RunRecord]:
    """Write the manifest of a run as it begins, and again when it has ended, however it does.

    A run that is killed has no last word: its entry stays `running` while nobody holds the lock.

    Args:
        folder: locked by this process.
        manifest: with the list `runs`, which gets one entry more.
        asked: what the run was asked: `run_id`, `command`, `engine`, `jobs`, `time_limit_s`,
            `threads`.
        completes: whether the folder is finished when the run is.
    """
    manifest["finished"] = None
    record = RunRecord(folder, manifest, asked)
    record.write()
    try:
        yield record
    except BaseException:
        # a full disk has been told of already
        with suppress(StoreError):
            record.close(INTERRUPTED)
        raise
    if completes:
        manifest["finished"] = now()
    record.close(FINISHED)
