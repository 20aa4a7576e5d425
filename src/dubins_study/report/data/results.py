"""Read results folders: all attempts for counting, single rows, and paths."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.report.data.attempts import Attempts
from dubins_study.report.data.selection import Database, RowCounts, Source, select_attempts
from dubins_study.report.data.verdicts import methods
from dubins_study.study.path import Path
from dubins_study.study.rows.manifest import Manifest, read_manifest
from dubins_study.study.rows.parts import (
    PARTS,
    ResultsError,
    part_files,
    printable_batches,
    read_footer,
)
from dubins_study.study.rows.schema import ROW
from dubins_study.study.scenario import Pose

_CONTROLS = ["curvatures", "lengths"]
_SCALARS = [c.name for c in ROW if not c.manifest and c.name not in _CONTROLS]
_COLUMNS = [*_SCALARS, *_CONTROLS]


class NoRowsError(ResultsError):
    """A results folder whose run has written no row so far."""

    def __init__(self, folder: FilePath, message: str) -> None:
        super().__init__(f"{folder} has no rows: {message}")
        self.folder = folder


@dataclass(frozen=True)
class Folder:
    """A results folder: its manifest, and the numbers of its rows that do and do not count."""

    manifest: Manifest
    rows: RowCounts

    @property
    def name(self) -> str:
        """The experiment's name."""
        return self.manifest.experiment.name

    @property
    def section(self) -> str | None:
        """The key of the report's section that the experiment names; None if it names none."""
        return self.manifest.experiment.section

    @property
    def title(self) -> str:
        """The experiment's title, or its name if it has no title."""
        return self.manifest.experiment.title or self.name


@dataclass(frozen=True, eq=False)
class Results:
    """The attempts of one or more folders.

    `rows` has one row per attempt, index 0, 1, ...: the scalar columns of `study.rows.schema` that
    a report needs, `experiment`, and `answerable` (the question has an answer, so that a gap can be
    measured). In a selection (`only`) the other fields but `folders` and `attempts` are unchanged.
    """

    folders: tuple[Folder, ...]  # in the order of the arguments
    attempts: Attempts  # for counting
    rows: pd.DataFrame
    # curvatures, lengths, x, y and heading, in Arrow because most sections draw no path; by index
    controls: pa.Table
    solvers: tuple[str, ...] = ()  # specs
    # solver, formulation, engine, guess
    methods: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False)
    # by `only`, since several sections are about the same rows
    selections: dict[frozenset[str], Results] = field(default_factory=dict, repr=False)

    @property
    def settings(self) -> dict[str, dict[str, Any]]:
        """Every spec's settings, as the manifests hold them."""
        entries = (folder.manifest.solvers for folder in self.folders)
        return {spec: entry.settings for solvers in entries for spec, entry in solvers.items()}

    def only(self, experiments: Collection[str]) -> Results:
        """The attempts of some experiments, and their folders."""
        names = frozenset(experiments)
        if names not in self.selections:
            self.selections[names] = replace(
                self,
                folders=tuple(folder for folder in self.folders if folder.name in names),
                attempts=self.attempts.only(names),
                rows=self.rows[self.rows["experiment"].isin(names)],
                selections={},
            )
        return self.selections[names]

    def path(self, index: int) -> Path | None:
        """The path of the row with this index, or None if no path came back."""
        row = {
            name: self.controls.column(name)[index].as_py() for name in self.controls.column_names
        }
        if row["curvatures"] is None or row["lengths"] is None:
            return None
        start = Pose(row["x"], row["y"], row["heading"])
        return Path(start, row["curvatures"], row["lengths"])


def load_results(folders: str | FilePath | Iterable[str | FilePath]) -> pd.DataFrame:
    """The judged rows of one or more results folders, read as the report reads them.

    Args:
        folders: one or more results folders. If two folders hold the same cell, the first folder's
            row is kept.

    Returns:
        One row per attempt, with the columns `experiment` and those of `study.rows.schema` except
        `versions`, `machine` and `run_id`; `curvatures` and `lengths` are Arrow lists. Rows of
        earlier code are left out. Missing numbers are null.

    Raises:
        ResultsError: naming the folder and what is wrong with it.
    """
    several = [folders] if isinstance(folders, str | FilePath) else folders
    results = load(several)
    controls = {name: pd.arrays.ArrowExtensionArray(results.controls[name]) for name in _CONTROLS}
    return results.rows.drop(columns="answerable").assign(**controls)


def load(folders: Iterable[str | FilePath]) -> Results:
    """Read and join results folders; if two hold the same cell, the first folder's row is kept.

    Raises:
        ResultsError: naming the folder and what is wrong with it.
    """
    paths = [FilePath(folder) for folder in folders]
    if not paths:
        raise ResultsError("no results folder given; expected at least one")
    manifests = [read_manifest(path, printable=True) for path in paths]
    sources = [_source(*each) for each in zip(paths, manifests, strict=True)]
    files = [part.file for source in sources for part in source.parts]
    database = Database(_checked_rows(files))
    counts = select_attempts(database, sources)
    for path, rows in zip(paths, counts, strict=True):
        if not rows.current:
            raise ResultsError(f"{path} has no rows but of earlier code: run it again")
    attempts = Attempts(database, {source.experiment for source in sources})
    columns = ", ".join(f'"{name}"' for name in ("experiment", "answerable", *_COLUMNS))
    table = database.table(f"SELECT {columns} FROM attempts ORDER BY part, place")
    return Results(
        folders=tuple(map(Folder, manifests, counts)),
        attempts=attempts,
        rows=table.drop_columns(_CONTROLS).to_pandas(),
        controls=table.select([*_CONTROLS, *Pose._fields]).combine_chunks(),
        solvers=tuple(attempts.values("solver")),
        methods=methods(attempts),
    )


def load_with_rows(
    folders: Iterable[str | FilePath],
) -> tuple[Results | None, tuple[Folder, ...]]:
    """As `load`, with the folders that hold no rows set apart; no results if none has rows."""
    left = [FilePath(folder) for folder in folders]
    empty: list[Folder] = []
    while left or not empty:
        try:
            return load(left), tuple(empty)
        except NoRowsError as error:
            left.remove(error.folder)
            manifest = read_manifest(error.folder, printable=True)
            empty.append(Folder(manifest, RowCounts(0, 0, 0, 0)))
    return None, tuple(empty)


def _source(folder: FilePath, manifest: Manifest) -> Source:
    parts = [read_footer(file) for file in part_files(folder)]
    if not parts:
        raise NoRowsError(folder, f"expected Parquet files in {folder / PARTS}")
    if not sum(part.rows for part in parts):
        raise NoRowsError(folder, "its parts are empty")
    digests, tolerance = manifest.code_digests, manifest.gap_tolerance
    return Source(manifest.experiment.name, digests, tolerance, parts)


def _checked_rows(files: Sequence[FilePath]) -> pa.Table:
    """The rows of all parts, checked; with part (the file's number) and place (the row's in it)."""
    tables = []
    for number, file in enumerate(files):
        part = pa.concat_tables(printable_batches(file, _COLUMNS))
        places = {"part": np.full(len(part), number), "place": np.arange(len(part))}
        for name, values in places.items():
            part = part.append_column(name, pa.array(values))
        tables.append(part)
    return pa.concat_tables(tables)
