"""Read results folders: rows, and paths."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import pandas as pd
import pyarrow as pa

from dubins_study.report.data.attempts import UNTAKEN, counted, methods
from dubins_study.report.data.rejudged import Recheck, judged_anew, same_set_up
from dubins_study.report.data.selection import RowCounts, select_attempts
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import MANIFEST, Manifest, read_manifest
from dubins_study.study.rows.parts import (
    ARROW_SCHEMA,
    PARTS,
    ResultsError,
    folder_paths,
    part_files,
    printable_batches,
    start_of,
)
from dubins_study.study.rows.schema import MEASURED_TIMES, ROW

_LOG = logging.getLogger(__name__)
_CONTROLS = ["curvatures", "lengths"]
_START = ["x", "y", "heading", "start_heading"]  # what `start_of` reads
_SCALARS = [c.name for c in ROW if not c.manifest and c.name not in _CONTROLS]
_COLUMNS = [*_SCALARS, *_CONTROLS]
_NO_ROWS = pa.schema([ARROW_SCHEMA.field(name) for name in _COLUMNS]).empty_table()


@dataclass(frozen=True)
class Folder:
    """A results folder: its manifest, and the numbers of its rows that do and do not count."""

    manifest: Manifest
    rows: RowCounts
    recheck: Recheck | None = None  # of a folder made elsewhere, whose rows were judged anew

    @property
    def name(self) -> str:
        """The experiment's name."""
        return self.manifest.experiment.name

    @property
    def section(self) -> str | None:
        """The key of the experiment's section.

        The section is one of the report; None if the experiment names none.
        """
        return self.manifest.experiment.section

    @property
    def title(self) -> str:
        """The experiment's title, or its name if it has no title."""
        return self.manifest.experiment.title or self.name


@dataclass(frozen=True, eq=False)
class Results:
    """The attempts of one or more folders.

    `rows` has one row per attempt, with the scalar columns of `study.rows.schema` and those that
    `select_attempts` adds. Its index is that of `controls`, which holds the questions that solvers
    do not take too. In a selection (`only`) the other fields but `folders`, `untaken` and
    `elsewhere` are unchanged.
    """

    folders: tuple[Folder, ...]  # in the order of the arguments
    rows: pd.DataFrame
    untaken: pd.DataFrame  # solver and experiment of each question that a solver does not take
    # the rows of other machines, with their times, which `rows` lacks: nothing ranks them with ours
    elsewhere: pd.DataFrame
    # curvatures, lengths and how a path starts, in Arrow because most sections draw none; by index
    controls: pa.Table
    methods: pd.DataFrame  # solver, formulation, engine, guess
    # by `only`, since several sections are about the same rows
    selections: dict[frozenset[str], Results] = field(default_factory=dict, repr=False)

    @cached_property
    def attempts(self) -> pd.DataFrame:
        """The rows as `counted`."""
        return counted(self.rows)

    @property
    def settings(self) -> dict[str, dict[str, Any]]:
        """Every spec's settings, from the manifests."""
        settings: dict[str, dict[str, Any]] = {}
        for folder in self.folders:
            settings |= {spec: entry.settings for spec, entry in folder.manifest.solvers.items()}
        return settings

    def only(self, experiments: Collection[str]) -> Results:
        """The attempts of some experiments, and their folders."""
        names = frozenset(experiments)
        if names not in self.selections:
            self.selections[names] = replace(
                self,
                folders=tuple(folder for folder in self.folders if folder.name in names),
                rows=self.rows[self.rows["experiment"].isin(names)],
                untaken=self.untaken[self.untaken["experiment"].isin(names)],
                elsewhere=self.elsewhere[self.elsewhere["experiment"].isin(names)],
                selections={},
            )
        return self.selections[names]

    def path(self, index: int) -> Path | None:
        """The path of a row, or None without one.

        The row is given by its index.
        """
        [row] = self.controls.slice(index, 1).to_pylist()
        if row["curvatures"] is None or row["lengths"] is None:
            return None
        return Path(start_of(row), row["curvatures"], row["lengths"])


def load_results(folders: str | FilePath | Iterable[str | FilePath]) -> pd.DataFrame:
    """The judged rows of one or more results folders.

    They are read as the report reads them.

    Args:
        folders: one or more results folders, or folders of results folders. If two hold the same
            cell, the first folder's row is kept.

    Returns:
        One row per attempt, with the columns `experiment` and those of `study.rows.schema` except
        `versions` and `run_id`; `curvatures` and `lengths` are Arrow lists. Rows of
        earlier code are left out. Missing numbers are null.

    Raises:
        ResultsError: naming the folder and what is wrong with it.
    """
    rows, _ = _selected(_read_full(folders))
    controls = {name: pd.arrays.ArrowExtensionArray(rows[name]) for name in _CONTROLS}
    return rows.select(["experiment", *_SCALARS]).to_pandas().assign(**controls)


def load(folders: str | FilePath | Iterable[str | FilePath]) -> Results:
    """Read and join results folders.

    If two have the same cell, the first folder's row is kept. Folders after the first that were
    made elsewhere are judged anew (`report.data.rejudged`). A `ResultsError` names the folder that
    cannot be read, or has no rows.
    """
    return _joined(_read_full(folders))


def load_with_rows(
    folders: str | FilePath | Iterable[str | FilePath],
) -> tuple[Results | None, tuple[Folder, ...]]:
    """Read folders, with empty folders apart.

    Like `load`; an empty folder has no rows. The results are None if none has rows.
    """
    stored = _read(folders)
    full = [folder for folder in stored if len(folder.rows)]
    empty = tuple(Folder(folder.manifest, RowCounts()) for folder in stored if not len(folder.rows))
    if not full:
        return None, empty
    return _joined(full), empty


class _Stored(NamedTuple):
    """A results folder: manifest and checked rows."""

    folder: FilePath
    manifest: Manifest
    rows: pa.Table
    recheck: Recheck | None = None


def _read(folders: str | FilePath | Iterable[str | FilePath]) -> list[_Stored]:
    """Read the folders.

    Those of later arguments are judged anew if they are of another set-up. That is another machine
    or other versions than those of the first argument's folders.
    """
    arguments = folder_paths(folders)
    if not arguments:
        raise ResultsError("no results folder given; expected at least one")
    first, *later = map(_results_in, arguments)
    stored = [_Stored(path, read_manifest(path, printable=True), _rows(path)) for path in first]
    manifests = [folder.manifest for folder in stored]
    for path in chain.from_iterable(later):
        manifest = read_manifest(path, printable=True)
        rows = _rows(path)
        recheck: Recheck | None = None
        if not any(same_set_up(manifest, first_manifest) for first_manifest in manifests):
            rows, recheck = judged_anew(rows, manifest)
        stored.append(_Stored(path, manifest, rows, recheck))
    return stored


def _results_in(folder: FilePath) -> list[FilePath]:
    """A results folder, or the results folders inside.

    A folder without results inside stands for itself.
    """
    if not folder.is_dir() or (folder / MANIFEST).exists():
        return [folder]
    return sorted(inner.parent for inner in folder.glob(f"*/{MANIFEST}")) or [folder]


def _read_full(folders: str | FilePath | Iterable[str | FilePath]) -> list[_Stored]:
    stored = _read(folders)
    for entry in stored:
        if not len(entry.rows):
            raise ResultsError(f"{entry.folder} has no rows: expected Parquet files in {PARTS}")
    return stored


def _rows(folder: FilePath) -> pa.Table:
    batches = [_NO_ROWS]
    for file in part_files(folder):
        batches += printable_batches(file, _COLUMNS)
    return pa.concat_tables(batches)


def _selected(stored: Sequence[_Stored]) -> tuple[pa.Table, list[RowCounts]]:
    manifests = [folder.manifest for folder in stored]
    rows, counts = select_attempts([folder.rows for folder in stored], manifests)
    for entry, count in zip(stored, counts, strict=True):
        if not count.current:
            raise ResultsError(f"{entry.folder} has no rows but of earlier code: run it again")
        if count.other_limits:
            _LOG.warning("dubins-study: %s: %s", entry.folder, count.limits_text)
    return rows, counts


def _joined(stored: Sequence[_Stored]) -> Results:
    manifests = [folder.manifest for folder in stored]
    rows, counts = _selected(stored)
    added = ["experiment", "answerable", "left_open", "late", "elsewhere"]
    frame = rows.select([*added, *_SCALARS]).to_pandas()
    untaken = frame["outcome"] == UNTAKEN
    elsewhere = frame[frame["elsewhere"] & ~untaken]
    if len(elsewhere):
        for name in MEASURED_TIMES:
            frame[name] = frame[name].mask(frame["elsewhere"])
    taken = frame[~untaken]
    return Results(
        folders=tuple(map(Folder, manifests, counts, (folder.recheck for folder in stored))),
        rows=taken,
        untaken=frame.loc[untaken, ["solver", "experiment"]],
        elsewhere=elsewhere,
        controls=rows.select([*_CONTROLS, *_START]).combine_chunks(),
        methods=methods(taken),
    )
