"""Write the manifest of a results folder.

The manifest has the number of cells, and an entry for each run.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path as FilePath
from time import monotonic
from typing import Any, Self

from dubins_study.experiments import provenance
from dubins_study.experiments.store.part_writer import write_whole
from dubins_study.study.rows.manifest import MANIFEST, Manifest, Probe, RunEntry
from dubins_study.study.rows.parts import ResultsError, os_errors_as
from dubins_study.study.rows.schema import Key

# States of a run. A manifest never holds `killed`: the entry of a killed run stays `running`.
RUNNING = "running"
FINISHED = "finished"
INTERRUPTED = "interrupted"
KILLED = "killed"

# Seconds between two updates of the manifest.
_WRITE_INTERVAL_S = 2.0
# Number of probes per run: a manifest is read and written as a whole, so it must stay small. If
# there are more, every second one is dropped, later ones included.
_MAX_PROBES = 1000


def write_manifest(folder: FilePath, manifest: Manifest) -> None:
    """Replace the manifest in one step.

    `ResultsError` is raised if the folder cannot be written.
    """
    content = manifest.model_dump(by_alias=True)
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    encoded = text.encode("utf-8", "replace")
    with os_errors_as(f"cannot write {folder / MANIFEST}"):
        write_whole(folder / MANIFEST, lambda file: file.write_bytes(encoded))


def count_by_code(keys: Iterable[Key]) -> Counter[tuple[str, str]]:
    """Number of cells by spec and code digest."""
    # a key begins with the scenario's id and the spec, and ends with the code digest
    return Counter((spec, digest) for _, spec, *_, digest in keys)


def count_cells(
    manifest: Manifest, requested: Collection[str], rows: Mapping[tuple[str, str], int]
) -> tuple[Manifest, bool]:
    """Record how many cells each solver should have.

    Returns the changed manifest, and whether the folder will be finished after this run.

    Args:
        manifest: with an entry for each solver; rows of other code than the entry's do not count.
        requested: the specs that this run asks. Other solvers keep their number of cells.
        rows: the number of rows after this run, by spec and code digest.
    """
    solvers = {}
    complete = True
    for spec, entry in manifest.solvers.items():
        present = rows.get((spec, entry.code_digest), 0)
        cells = present
        if spec not in requested:
            cells = max(present, entry.cells)
        solvers[spec] = entry.with_changes(cells=cells)
        complete = complete and cells <= present
    total = sum(entry.cells for entry in solvers.values())
    return manifest.with_changes(solvers=solvers, cells=total), complete


class RunRecord:
    """Keeps a run's entry in the manifest current.

    The manifest is given without this entry. `completes` says whether the run makes the folder
    finished.
    """

    def __init__(
        self, folder: FilePath, manifest: Manifest, request: RunEntry, completes: bool = True
    ) -> None:
        self._folder = folder
        self._completes = completes
        self._manifest = manifest.with_changes(finished=None)
        self._began = self._written = monotonic()
        self._probes: list[Probe] = []
        self._probes_taken = 0
        self._probe_stride = 1
        self._entry = request.with_changes(
            machine=provenance.machine(),
            governor=provenance.governor(),
            git=provenance.source(),
            load_start=provenance.load_average(),
            started=provenance.now(),
            state=RUNNING,
            probes=self._probes,
        )

    def __enter__(self) -> Self:
        self.write()
        return self

    def __exit__(self, error_type: object, *_: object) -> None:
        ended = provenance.now()
        load = provenance.load_average()
        if error_type is None:
            if self._completes:
                self._manifest = self._manifest.with_changes(finished=ended)
            self.write(state=FINISHED, ended=ended, load_end=load)
            return
        with suppress(ResultsError):  # a full disk was reported already
            self.write(state=INTERRUPTED, ended=ended, load_end=load)

    def probe(self, seconds: float, machine: int = 0) -> None:
        """Record a calibration probe.

        `seconds` is its duration, `machine` the number of its machine.
        """
        self._probes_taken += 1
        if self._probes_taken % self._probe_stride == 0:
            when = round(monotonic() - self._began, 3)
            self._probes.append(Probe(when, took=round(seconds, 9), machine=machine))
            if len(self._probes) > _MAX_PROBES:
                self._probe_stride *= 2
                del self._probes[::2]

    def write_now_and_then(self) -> None:
        """Write the run's duration every few seconds."""
        if monotonic() - self._written > _WRITE_INTERVAL_S:
            self.write()

    def write(self, **changes: Any) -> None:
        """Write the manifest with an updated `RunEntry`.

        `changes` are new values of the entry's fields. The run's duration is updated too.
        """
        self._written = monotonic()
        seconds = round(self._written - self._began, 3)
        self._entry = self._entry.with_changes(seconds=seconds, **changes)
        runs = [*self._manifest.runs, self._entry]
        write_manifest(self._folder, self._manifest.with_changes(runs=runs))
