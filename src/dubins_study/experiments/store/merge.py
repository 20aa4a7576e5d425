"""Results folders of one experiment united into one; what contradicts itself is refused."""

from __future__ import annotations

import glob
import os
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.experiments.provenance import now
from dubins_study.experiments.store.attempts import JUDGED, merged_rows
from dubins_study.experiments.store.disk import StoreError, reason, sync_folder
from dubins_study.experiments.store.folder import counted, read_rows
from dubins_study.experiments.store.lock import LOCK, held, locked
from dubins_study.experiments.store.manifest import (
    check_same,
    count_cells,
    read_manifest,
    write_manifest,
)
from dubins_study.experiments.store.parts import (
    PARTS,
    RUN_ID,
    is_stream,
    part_files,
    read_part,
    write_part,
)
from dubins_study.experiments.store.stream_parts import streamed_counts, streamed_part
from dubins_study.study.check.verdict import Tolerances
from dubins_study.study.rows.schema import KEY, names

_DEFAULT_GAP = Tolerances().gap  # of a manifest that tells none


class Union(NamedTuple):
    """What a merge made.

    Args:
        folder: the new results folder.
        rows: how many it holds.
        again: how many attempts were left out since an earlier one at the same cell agrees.
        stale: how many of its rows are of another code than the first folder's.
    """

    folder: FilePath
    rows: int
    again: int
    stale: int


def merge(folders: Iterable[str | FilePath], out: str | FilePath) -> Union:
    """Unite results folders of one experiment.

    Every cell of any folder is in the union once. The same attempt in two folders is one; of two
    attempts that agree (outcome, claim, verdict, word, and the gap to the profile's tolerance) the
    earlier is kept. Of a solver with several codes the first folder's counts, rows of others are
    kept as stale ones. Streamed parts are linked or copied as they are.

    Args:
        folders: at least two results folders; they are only read.
        out: the new folder; one that is there must be empty.

    Raises:
        StoreError: if a folder cannot be read, is of another experiment or in use, if two attempts
            contradict each other, or if `out` cannot be written. Nothing is left at `out` then.
    """
    given, target = [FilePath(folder) for folder in folders], FilePath(out)
    manifests = _accepted(given)
    _check_target(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _clear_abandoned(target)
        fresh = FilePath(tempfile.mkdtemp(prefix=f".{target.name}.merging-", dir=target.parent))
    except OSError as error:
        raise StoreError(f"cannot write to {target}: {reason(error)}") from None
    try:
        with locked(fresh):
            made = _united(given, manifests, fresh)
            _put_in_place(fresh, target)
            return made._replace(folder=target)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _accepted(folders: Sequence[FilePath]) -> list[dict[str, Any]]:
    if len(folders) < 2:
        raise StoreError(f"{len(folders)} results folder given; expected at least two to merge")
    manifests = [read_manifest(folder) for folder in folders]
    for folder, manifest in zip(folders, manifests, strict=True):
        if held(folder):
            raise StoreError(f"{folder} is in use by a run; merge it when that has ended")
        try:
            check_same(folder, manifest["experiment"], manifests[0]["experiment"])
        except StoreError:
            raise StoreError(
                f"{folder} holds experiment {manifest['experiment']['name']!r:.60}, {folders[0]} "
                f"holds {manifests[0]['experiment']['name']!r:.60}; expected folders of one "
                "experiment, name and text"
            ) from None
    return manifests


def _check_target(target: FilePath) -> None:
    try:
        taken = target.is_symlink() or (target.exists() and not target.is_dir())
        filled = target.is_dir() and any(target.iterdir())
    except OSError as error:  # a name that is too long, a folder that nobody may look into
        raise StoreError(f"cannot write to {target}: {reason(error)}") from None
    if taken:
        raise StoreError(f"{target} is no folder; expected a new one or an empty one to merge into")
    if filled:
        raise StoreError(f"{target} is not empty; expected a new folder or an empty one")


def _clear_abandoned(target: FilePath) -> None:
    """Remove what merges into the same folder left that were killed; live ones hold a lock."""
    for folder in target.parent.glob(f".{glob.escape(target.name)}.merging-*"):
        ours = folder.is_dir() and not folder.is_symlink() and (folder / LOCK).exists()
        if ours and not held(folder):
            shutil.rmtree(folder, ignore_errors=True)


def _put_in_place(fresh: FilePath, target: FilePath) -> None:
    """In one step; a folder that somebody began at the same place meanwhile is left alone."""
    try:
        fresh.chmod(0o777 & ~_umask())  # mkdtemp makes it private
        if target.is_dir():
            target.rmdir()
        fresh.rename(target)
        sync_folder(target.parent)
    except OSError as error:
        raise StoreError(f"cannot write to {target}: {reason(error)}") from None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _united(
    folders: Sequence[FilePath], manifests: Sequence[dict[str, Any]], fresh: FilePath
) -> Union:
    """Write the union to a folder that nobody sees yet."""
    tolerance = manifests[0].get("gap_tolerance")
    gap = tolerance if isinstance(tolerance, float) and tolerance > 0 else _DEFAULT_GAP
    found = merged_rows([read_rows(folder) for folder in folders], folders, gap)
    try:
        (fresh / PARTS).mkdir()
        _with_streams(folders, fresh, gap)
    except OSError as error:
        raise StoreError(f"cannot write to {fresh}: {reason(error)}") from None
    if len(found.table):
        write_part(fresh, "merged-all", found.table, {RUN_ID: "merged"})
    manifest = _manifest(manifests)
    counts = counted(found.table) + streamed_counts(fresh)
    if count_cells(manifest, (), counts):
        ends = [str(other["finished"]) for other in manifests if other.get("finished")]
        manifest["finished"] = max(ends, default=None) or now()
    write_manifest(fresh, manifest)
    current = {(spec, known["code_digest"]) for spec, known in manifest["solvers"].items()}
    stale = sum(number for made, number in counts.items() if made not in current)
    return Union(fresh, counts.total(), found.again, stale)


def _with_streams(folders: Sequence[FilePath], fresh: FilePath, gap: float) -> None:
    """The streamed parts of all folders, each chunk once, as files; rows are read of doubles only.

    Raises:
        StoreError: if two folders hold different rows of one chunk, or one is damaged.
    """
    found: dict[str, FilePath] = {}
    for folder in folders:
        for part in filter(is_stream, part_files(folder)):
            if streamed_part(part) is None:
                raise StoreError(f"{part} is damaged; run that folder again before it is merged")
            first = found.setdefault(part.name, part)
            if first is not part:
                both = [read_part(file, [*names(KEY), *JUDGED]) for file in (first, part)]
                merged_rows(both, (first, part), gap)
    for name, part in found.items():
        copy = fresh / PARTS / name
        try:
            os.link(part, copy)
        except OSError:  # another disk, or one that knows no links
            shutil.copyfile(part, copy)
    sync_folder(fresh / PARTS)


def _manifest(manifests: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The first folder's manifest, with the solvers and runs of all."""
    solvers: dict[str, dict[str, Any]] = {}
    runs: dict[str, dict[str, Any]] = {}
    for manifest in manifests:
        for spec, known in (manifest.get("solvers") or {}).items():
            first = solvers.setdefault(spec, dict(known))
            if first["code_digest"] == known["code_digest"]:
                first["cells"] = max(first.get("cells", 0), known.get("cells", 0))
        for run in manifest.get("runs") or ():
            runs.setdefault(str(run.get("run_id")), run)
    created = [str(manifest["created"]) for manifest in manifests if manifest.get("created")]
    return {
        **manifests[0],
        "created": min(created, default=None),
        "finished": None,
        "solvers": solvers,
        "runs": sorted(runs.values(), key=lambda run: str(run.get("started"))),
    }
