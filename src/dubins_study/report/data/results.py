"""Read results folders: rows and paths."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path as FilePath
from typing import Any, NamedTuple, TypeAlias

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
_Folders: TypeAlias = str | FilePath | Iterable[str | FilePath]
Settings: TypeAlias = dict[str, dict[str, Any]]  # spec -> its settings
_NO_ROWS = pa.schema([ARROW_SCHEMA.field(name) for name in _COLUMNS]).empty_table()


@dataclass(frozen=True)
class Folder:
    """A results folder: its manifest and row counts."""

    manifest: Manifest
    rows: RowCounts
    recheck: Recheck | None = None  # of a folder made elsewhere, whose rows were judged anew

    @property
    def name(self) -> str:
        """The experiment's name."""
        return self.manifest.experiment.name

    @property
    def section(self) -> str | None:
        """The report section that the experiment names, or None."""
        return self.manifest.experiment.section

    @property
    def title(self) -> str:
        """The experiment's title, or else its name."""
        return self.manifest.experiment.title or self.name


@dataclass(frozen=True, eq=False)
class Results:
    """The attempts of one or more folders.

    `rows` has one row per attempt, with the scalar columns of `study.rows.schema` and those that
    `select_attempts` adds. `rows` and `controls` share an index. `controls` also holds the
    questions that solvers do not take. `only` returns a selection; it restricts `folders`, `rows`,
    `untaken` and `elsewhere`, and keeps the other fields.
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
        """The rows with counted verdicts and weights (`counted`)."""
        return counted(self.rows)

    @property
    def settings(self) -> Settings:
        """Every spec's settings, from the manifests."""
        settings: Settings = {}
        for folder in self.folders:
            settings |= {spec: entry.settings for spec, entry in folder.manifest.solvers.items()}
        return settings

    def only(self, experiments: Collection[str]) -> Results:
        """The results restricted to experiments with these names.

        A selection is stored in `selections`, so that equal names give the same object.
        """
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

        `index` is the row's label in the index of `rows`.
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


def load(folders: _Folders) -> Results:
    """Read folders and join their attempts into one `Results`.

    If two have the same cell, the first folder's row is kept. Folders after the first that were
    made elsewhere are judged anew (`report.data.rejudged`). A `ResultsError` names the folder that
    cannot be read, or has no rows.
    """
    return _joined(_read_full(folders))


def load_with_rows(folders: _Folders) -> tuple[Results | None, tuple[Folder, ...]]:
    """Read folders like `load`; return results and empty folders.

    A folder without rows is no error here: it stands in the second value, in the order of the
    arguments. The first value is None if no folder has rows.
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


def _read(folders: _Folders) -> list[_Stored]:
    """Read the manifest and the rows of each folder.

    The folders of the first argument define the usual set-ups. A folder of a later argument is
    judged anew if its set-up is none of them, i.e. another machine or other versions of packages.
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
    """The results folders that one argument stands for.

    They are the folder itself if it has a manifest, else the folders directly inside that have one.
    A folder without either comes back too, and reading it fails with a message.
    """
    if not folder.is_dir() or (folder / MANIFEST).exists():
        return [folder]
    return sorted(inner.parent for inner in folder.glob(f"*/{MANIFEST}")) or [folder]


def _read_full(folders: _Folders) -> list[_Stored]:
    """Read folders; an error names one without rows."""
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
    """The rows that count, and each folder's counts.

    An error names a folder that has rows of earlier code only. A warning is logged if questions
    have different time limits.
    """
    manifests = [folder.manifest for folder in stored]
    rows, counts = select_attempts([folder.rows for folder in stored], manifests)
    for entry, count in zip(stored, counts, strict=True):
        if not count.current:
            raise ResultsError(f"{entry.folder} has no rows but of earlier code: run it again")
        if count.other_limits:
            _LOG.warning("dubins-study: %s: %s", entry.folder, count.limits_text)
    return rows, counts


def _joined(stored: Sequence[_Stored]) -> Results:
    """Make the results of the folders' counted rows."""
    rows, counts = _selected(stored)
    added = ["experiment", "answerable", "left_open", "late", "elsewhere"]
    frame = rows.select([*added, *_SCALARS]).to_pandas()
    untaken = frame["outcome"] == UNTAKEN
    elsewhere = frame[frame["elsewhere"] & ~untaken]
    if len(elsewhere):  # their answers count, their times are of another machine
        for name in MEASURED_TIMES:
            frame[name] = frame[name].mask(frame["elsewhere"])
    taken = frame[~untaken]
    return Results(
        folders=tuple(
            Folder(manifest=entry.manifest, rows=count, recheck=entry.recheck)
            for entry, count in zip(stored, counts, strict=True)
        ),
        rows=taken,
        untaken=frame.loc[untaken, ["solver", "experiment"]],
        elsewhere=elsewhere,
        controls=rows.select([*_CONTROLS, *_START]).combine_chunks(),
        methods=methods(taken),
    )
