"""The entry of the run that is going on: written to the manifest as it begins, goes on and ends."""

from __future__ import annotations

from collections.abc import Iterator
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
from dubins_study.experiments.store.manifest_changes import write_manifest
from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.machine_noise import Probe
from dubins_study.study.rows.manifest import Manifest, RunEntry

# `killed` stands in no manifest: a run that is killed leaves `running`.
RUNNING, FINISHED, INTERRUPTED, KILLED = "running", "finished", "interrupted", "killed"

_WRITE_INTERVAL_S = 2.0
# A manifest is read and written as a whole, so that it must stay small.
_MAX_PROBES = 1000


class RunRecord:
    """Keeps a run's entry up to date; durations are measured by a clock that never jumps.

    Args:
        folder: the results folder, locked by this process.
        manifest: its manifest, which gets one entry more.
        request: what was asked of the run; where it runs, and of what source, is added.
    """

    def __init__(self, folder: FilePath, manifest: Manifest, request: RunEntry) -> None:
        self._folder, self._manifest = folder, manifest
        self._began = self._written = monotonic()
        self._probes: list[Probe] = []
        self._probes_taken, self._probe_stride = 0, 1
        self._entry = request.with_changes(
            machine=machine(),
            governor=governor(),
            thread_limits=thread_limits(),
            git=source(),
            load_start=load_average(),
            started=now(),
            state=RUNNING,
            probes=self._probes,
        )

    def probe(self, seconds: float, machine: int = 0) -> None:
        """Note how long the calibration probe just took, and on which of several machines.

        Beyond `_MAX_PROBES`, every other probe is dropped, and so are every other of those to
        come.
        """
        self._probes_taken += 1
        if self._probes_taken % self._probe_stride == 0:
            when = round(monotonic() - self._began, 3)
            self._probes.append(Probe(when, round(seconds, 9), machine))
            if len(self._probes) > _MAX_PROBES:
                self._probe_stride *= 2
                del self._probes[::2]
        self.write_now_and_then()

    def write_now_and_then(self) -> None:
        """Write how long the run has taken, if the last time is some seconds ago."""
        if monotonic() - self._written > _WRITE_INTERVAL_S:
            self.write()

    def write(self, **changes: Any) -> None:
        """Bring the manifest up to date.

        Args:
            changes: new values of fields of `RunEntry`.

        Raises:
            ResultsError: if the folder cannot be written.
        """
        self._written = monotonic()
        seconds = round(self._written - self._began, 3)
        self._entry = self._entry.with_changes(seconds=seconds, **changes)
        runs = [*self._manifest.runs, self._entry]
        write_manifest(self._folder, self._manifest.with_changes(runs=runs))

    def close(self, state: str, finished: str | None = None) -> None:
        """Write how the run ended, and when the folder was finished, if it is."""
        self._manifest = self._manifest.with_changes(finished=finished)
        self.write(state=state, ended=now(), load_end=load_average())


@contextmanager
def recorded(
    folder: FilePath, manifest: Manifest, request: RunEntry, completes: bool = True
) -> Iterator[RunRecord]:
    """Write the manifest of a run as it begins, and again when it has ended, however it does.

    A run that is killed cannot write how it ended: its entry stays `running` while nobody holds
    the lock.

    Args:
        folder: locked by this process.
        manifest: of the folder, without this run.
        request: what was asked of the run.
        completes: whether the folder is finished when the run is.
    """
    record = RunRecord(folder, manifest.with_changes(finished=None), request)
    record.write()
    try:
        yield record
    except BaseException:
        with suppress(ResultsError):  # that the disk is full was reported already
            record.close(INTERRUPTED)
        raise
    record.close(FINISHED, finished=now() if completes else None)
