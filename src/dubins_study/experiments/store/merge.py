"""Unite results folders of one experiment.

Folders that contradict each other are refused.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.experiments.provenance import now
from dubins_study.experiments.store.folder import is_locked, read_rows
from dubins_study.experiments.store.manifest_changes import count_cells, write_manifest
from dubins_study.experiments.store.part_writer import sync_folder, write_part
from dubins_study.study.rows.manifest import Manifest, RunEntry, SolverEntry, read_manifest
from dubins_study.study.rows.parts import PARTS, ResultsError, folder_paths, os_errors_as
from dubins_study.study.rows.repeated import JUDGED, compare_attempts, differences
from dubins_study.study.rows.schema import KEY, RUN_ID, names

# The columns that decide which rows are kept.
COLUMNS = [*names(KEY), *JUDGED, "gap", "run_id", "started"]
_MAX_LISTED = 5


def merged_rows(
    tables: Sequence[pa.Table], folders: Sequence[FilePath], tolerance: float
) -> tuple[pa.Table, int]:
    """The earliest row per cell, and the repeats' number.

    A repeat is a later attempt at the same cell, which agrees. Copies of the kept row do not count.

    Cells whose attempts contradict each other (gaps differ by more than the tolerance) are refused.
    """
    table = pa.concat_tables(tables)
    rows = table.select(COLUMNS).to_pandas()
    sizes = [len(each) for each in tables]
    rows["folder"] = np.repeat([str(folder) for folder in folders], sizes)
    rows = rows.sort_values("started", kind="stable")  # the index is still the place in `table`
    first_rows, pairs = compare_attempts(rows, names(KEY))
    if pairs.empty:
        return table, 0
    differ = differences(pairs, tolerance)
    cells = pairs.index[differ.any(axis=1)]
    if len(cells):
        lines = [_contradiction(pairs.loc[i], differ.loc[i]) for i in cells[:_MAX_LISTED]]
        if len(cells) > _MAX_LISTED:
            lines.append(f"and {len(cells) - _MAX_LISTED} more")
        count = "1 cell"
        if len(cells) > 1:
            count = f"{len(cells)} cells"
        listed = "\n  ".join(lines)
        raise ResultsError(
            f"the folders contradict each other in {count}; nothing was merged:\n  {listed}"
        )
    copies = (pairs["run_id"] == pairs["run_id_kept"]) & (pairs["started"] == pairs["started_kept"])
    # the places in `table` of the rows to keep, in the order of the tables
    positions = np.sort(rows.index.to_numpy()[first_rows])
    return table.take(pa.array(positions)), int((~copies).sum())


def _contradiction(pair: pd.Series[str], differ: pd.Series[bool]) -> str:
    """A sentence about two attempts that contradict.

    It names the cell, and both values of every column in which the attempts differ. `pair` is a row
    of `compare_attempts`; `differ` marks the columns.
    """
    values = "; ".join(
        f"{name} is {pair[f'{name}_kept']} in {pair['folder_kept']} and {pair[name]} in "
        f"{pair['folder']}"
        for name in differ.index[differ]
    )
    return f"{', '.join(str(pair[name]) for name in names(KEY))}: {values}"


class Union(NamedTuple):
    """The result of a merge.

    Args:
        folder: the new results folder.
        rows: number of rows in it.
        agreeing_repeats: number of attempts that were left out because an earlier attempt at the
            same cell agrees; copies of the same attempt are not counted.
        stale: number of its rows whose solver code differs from the first folder's.
    """

    folder: FilePath
    rows: int
    agreeing_repeats: int
    stale: int


def merge(folders: Iterable[str | FilePath], out: str | FilePath) -> Union:
    """Unite results folders of one experiment.

    The union holds every cell of every folder once. Copies of one attempt are united. Of two
    attempts that agree (same outcome, claim, verdict and word; gaps equal within the profile's
    tolerance) the earlier one is kept. If the code of a solver differs between folders, the first
    folder's code counts, and rows of other code are kept as stale rows.

    Args:
        folders: at least two results folders; they are only read.
        out: the new folder; an existing folder must be empty.

    Raises:
        ResultsError: if a folder cannot be read, holds another experiment or is in use, if two
            attempts contradict each other, or if `out` cannot be written. Then nothing is left at
            `out`.
    """
    sources = folder_paths(folders)
    [target] = folder_paths([out])
    manifests = _read_manifests(sources)
    with os_errors_as(f"cannot write to {target}"):
        if target.exists() and not target.is_dir():
            raise ResultsError(f"{target} is no folder; expected a new one or an empty one")
        if target.is_dir() and any(target.iterdir()):
            raise ResultsError(f"{target} is not empty; expected a new folder or an empty one")
        target.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=target.parent, prefix=".merging-") as place:
            fresh = FilePath(place) / target.name
            union = _unite(sources, manifests, fresh)
            if target.is_dir():  # an empty one: one that is not is never replaced
                target.rmdir()
            fresh.rename(target)
            sync_folder(target.parent)
    return union._replace(folder=target)


def _read_manifests(folders: Sequence[FilePath]) -> list[Manifest]:
    """The manifests of folders that can be united.

    Refused are a single folder, one that is in use, and folders of different experiments.
    """
    if len(folders) < 2:
        raise ResultsError(f"{len(folders)} results folder given; expected at least two to merge")
    manifests = [read_manifest(folder) for folder in folders]
    first = manifests[0].experiment
    for folder, manifest in zip(folders, manifests, strict=True):
        if is_locked(folder):
            raise ResultsError(f"{folder} is in use by a run; merge it when that has ended")
        other = manifest.experiment
        if (other.name, other.text) != (first.name, first.text):
            raise ResultsError(
                f"{folder} holds experiment {other.name!r:.60}, {folders[0]} holds "
                f"{first.name!r:.60}; expected folders of one experiment, name and text"
            )
    return manifests


def _unite(folders: Sequence[FilePath], manifests: Sequence[Manifest], fresh: FilePath) -> Union:
    """Write the union to a folder; return its numbers."""
    tolerance = manifests[0].gap_tolerance
    table, repeats = merged_rows([read_rows(folder) for folder in folders], folders, tolerance)
    (fresh / PARTS).mkdir(parents=True)
    if len(table):
        write_part(fresh, "merged-all", table, {RUN_ID: "merged"})
    made_by = table.select(["solver", "code_digest"]).to_pylist()
    counts = Counter((str(row["solver"]), str(row["code_digest"])) for row in made_by)
    manifest, complete = count_cells(_unite_manifests(manifests), (), counts)
    if complete:
        ends = [other.finished for other in manifests if other.finished]
        manifest = manifest.with_changes(finished=max(ends, default=None) or now())
    write_manifest(fresh, manifest)
    rows = counts.total()
    current = sum(counts[code] for code in manifest.code_digests.items())
    return Union(fresh, rows=rows, agreeing_repeats=repeats, stale=rows - current)


def _unite_manifests(manifests: Sequence[Manifest]) -> Manifest:
    """The united manifest of all folders.

    It is the first folder's, with the solvers and runs of all folders. If folders have entries of
    one solver with different code, the first folder's counts. Of entries with the same code, the
    largest number of cells counts.
    """
    solvers: dict[str, SolverEntry] = {}
    runs: dict[str, RunEntry] = {}
    for manifest in manifests:
        for spec, entry in manifest.solvers.items():
            first = solvers.setdefault(spec, entry)
            if first.code_digest == entry.code_digest and first.cells < entry.cells:
                solvers[spec] = first.with_changes(cells=entry.cells)
        for run in manifest.runs:
            runs.setdefault(run.run_id, run)
    created = [manifest.created for manifest in manifests if manifest.created]
    return manifests[0].with_changes(
        created=min(created, default=None),
        finished=None,
        solvers=solvers,
        runs=sorted(runs.values(), key=lambda run: run.started),
    )
