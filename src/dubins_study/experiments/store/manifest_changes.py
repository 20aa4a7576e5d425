"""How a results folder's manifest is written: its cells counted, and the run that is going on."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

from dubins_study.experiments import provenance
from dubins_study.experiments.store.whole_file import write_whole
from dubins_study.study.rows.files import ResultsError, os_errors_as
from dubins_study.study.rows.machine_noise import Probe
from dubins_study.study.rows.manifest import MANIFEST, Manifest, RunEntry

# `killed` stands in no manifest: a run that is killed leaves `running`.
RUNNING, FINISHED, INTERRUPTED, KILLED = "running", "finished", "interrupted", "killed"

_WRITE_INTERVAL_S = 2.0
# A manifest is read and written as a whole, so that it must stay small.
_MAX_PROBES = 1000

# A list of numbers that stand on lines of their own. No text matches: in JSON, line breaks of a
# text are escaped.
_NUMBERS = re.compile(r"\[\n[-+.,\d\seE]+\]")


def write_manifest(folder: FilePath, manifest: Manifest) -> None:
    """Replace the manifest in one step; a `ResultsError` if the folder cannot be written."""
    content = manifest.model_dump(by_alias=True)
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    text = _NUMBERS.sub(lambda match: f"[{' '.join(match[0][1:-1].split())}]", text)
    encoded = text.encode("utf-8", "replace")
    with os_errors_as(f"cannot write {folder / MANIFEST}"):
        write_whole(folder / MANIFEST, lambda file: file.write_bytes(encoded))


def count_cells(
    manifest: Manifest, requested: Collection[str], rows: Mapping[tuple[str, str], int]
) -> tuple[Manifest, bool]:
    """Note how many cells the folder is asked for, solver by solver; rows of old code do not count.

    Args:
        requested: the specs that this run asks; for other specs, what an earlier run asked stays.
        rows: how many the folder will hold after this run, by spec and code digest.

    Returns:
        The changed manifest, and whether the folder will be finished after this run.
    """
    solvers, complete = {}, True
    for spec, entry in manifest.solvers.items():
        present = rows.get((spec, entry.code_digest), 0)
        cells = present if spec in requested else max(present, entry.cells)
        solvers[spec] = entry.with_changes(cells=cells)
        complete = complete and cells <= present
    total = sum(entry.cells for entry in solvers.values())
    return manifest.with_changes(solvers=solvers, cells=total), complete


class RunRecord:
    """Keeps a run's entry in the manifest up to date, by a clock that never jumps.

    The entry says what was asked (`request`), where it runs, and of what source.
    """

    def __init__(self, folder: FilePath, manifest: Manifest, request: RunEntry) -> None:
        self._folder, self._manifest = folder, manifest
        self._began = self._written = monotonic()
        self._probes: list[Probe] = []
        self._probes_taken, self._probe_stride = 0, 1
        self._entry = request.with_changes(
            machine=provenance.machine(),
            governor=provenance.governor(),
            thread_limits=provenance.thread_limits(),
            git=provenance.source(),
            load_start=provenance.load_average(),
            started=provenance.now(),
            state=RUNNING,
            probes=self._probes,
        )

    def probe(self, seconds: float, machine: int = 0) -> None:
        """Note how long the calibration probe just took, and on which of several machines.

        Beyond `_MAX_PROBES`, every other probe is dropped, also of those to come.
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
        """Bring the manifest up to date, with new values of fields of `RunEntry`."""
        self._written = monotonic()
        seconds = round(self._written - self._began, 3)
        self._entry = self._entry.with_changes(seconds=seconds, **changes)
        runs = [*self._manifest.runs, self._entry]
        write_manifest(self._folder, self._manifest.with_changes(runs=runs))

    def close(self, state: str, finishes: bool = False) -> None:
        """Write how the run ended, and whether the folder is finished thereby."""
        ended = provenance.now()
        self._manifest = self._manifest.with_changes(finished=ended if finishes else None)
        self.write(state=state, ended=ended, load_end=provenance.load_average())


@contextmanager
def recorded(
    folder: FilePath, manifest: Manifest, request: RunEntry, completes: bool = True
) -> Iterator[RunRecord]:
    """Write the manifest of a run as it begins, and again when it has ended, however it does.

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
    record.close(FINISHED, completes)
