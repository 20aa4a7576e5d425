"""Results folders in, one frame of judged attempts out. Nothing is ever unpickled."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from study.path import Path
from study.scenario import Pose
from study.schema import CELL, ROW, VERSION, VERSION_KEY, arrow_schema, names

_CONTROLS = ["curvatures", "lengths"]
# what a run writes beside its rows; the page shows it from the manifest, so the rows need not
_UNREAD = {"versions", "host", "run_id"}
_LIGHT = [name for name in names(ROW) if name not in _UNREAD and name not in _CONTROLS]
_SCHEMA = arrow_schema()


class ReportError(ValueError):
    """A results folder that cannot be read, or a place that cannot be written."""


@dataclass(frozen=True)
class Manifest:
    """What a run says of itself, and what of its rows was left out.

    Args:
        solvers: every spec's settings.
        codes: every spec's code; rows of another were made by something else.
        runs: an entry a run, as the run wrote it.
        stale: rows of another code in the folder.
        replaced: cells left out since an earlier folder holds them, made by another code.
    """

    name: str
    title: str
    question: str
    text: str
    command: str
    versions: dict[str, Any] = field(default_factory=dict)
    machine: dict[str, Any] = field(default_factory=dict)
    git: dict[str, Any] = field(default_factory=dict)
    solvers: dict[str, dict[str, Any]] = field(default_factory=dict)
    codes: dict[str, str] = field(default_factory=dict)
    runs: tuple[dict[str, Any], ...] = ()
    gap_tolerance: float | None = None
    schema: int = VERSION
    created: str = ""
    finished: str = ""
    stale: int = 0
    replaced: int = 0


@dataclass(frozen=True, eq=False)
class Results:
    """The attempts of one or more folders.

    Args:
        manifests: one per folder, in the order given.
        rows: one row an attempt, index 0, 1, ...: the scalar columns of `study.schema` that a
            report needs, and `experiment`, the manifest's name.
        controls: the columns `curvatures` and `lengths` of the same rows, left in Arrow because
            most sections draw no path.
    """

    manifests: tuple[Manifest, ...]
    rows: pd.DataFrame
    controls: pa.Table

    def path(self, index: int) -> Path | None:
        """The path of the row with this index, or None if no path came back."""
        curvature = self.controls.column("curvatures")[index].as_py()
        length = self.controls.column("lengths")[index].as_py()
        if curvature is None or length is None:
            return None
        at = [self.rows[key].to_numpy(dtype=np.float64)[index] for key in Pose._fields]
        return Path(Pose(*at), curvature, length)


def load(folders: Iterable[str | FilePath]) -> Results:
    """Read results folders and join them; of a cell that two folders hold, the first is kept.

    Raises:
        ReportError: naming the folder and what is wrong with it.
    """
    paths = [FilePath(folder) for folder in folders]
    if not paths:
        raise ReportError("no results folder given; expected at least one")
    manifests, tables = [], []
    for number, path in enumerate(paths):
        manifest, table = _current(path, read_manifest(path), _read_parts(path))
        manifests.append(manifest)
        for name, value in (("experiment", pa.scalar(manifest.name)), ("folder", number)):
            table = table.append_column(name, pa.repeat(value, table.num_rows))
        tables.append(table)
    return _joined(manifests, pa.concat_tables(tables))


def _current(path: FilePath, manifest: Manifest, table: pa.Table) -> tuple[Manifest, pa.Table]:
    """The rows of the code that the manifest names, and how many others there are."""
    solver, code = (table[name].to_pandas() for name in ("solver", "code"))
    stale = solver.map(manifest.codes).notna() & (solver.map(manifest.codes) != code)
    if stale.all():
        raise ReportError(f"{path} has no rows but of earlier code: run it again")
    if stale.any():
        table = table.filter(pa.array(~stale))
    return replace(manifest, stale=int(stale.sum())), table


def _joined(manifests: Sequence[Manifest], table: pa.Table) -> Results:
    rows = table.select(["experiment", "folder", *_LIGHT]).to_pandas()
    cell = ["experiment", *names(CELL)]
    first = ~rows.duplicated(cell)
    if not first.all():
        others = ~first & ~rows.duplicated([*cell, "code"])
        count = rows.loc[others, "folder"].value_counts()
        manifests = [
            replace(manifest, replaced=int(count.get(i, 0))) for i, manifest in enumerate(manifests)
        ]
        rows, table = rows[first].reset_index(drop=True), table.filter(pa.array(first))
    rows = rows.drop(columns="folder")
    return Results(tuple(manifests), rows, table.select(_CONTROLS).combine_chunks())


def read_manifest(folder: FilePath) -> Manifest:
    """The manifest of a results folder.

    Raises:
        ReportError: if there is none, or it is not one of this schema version.
    """
    file = folder / "manifest.json"
    if not folder.is_dir():
        raise ReportError(f"{folder} is not a folder; expected a results folder")
    _refuse_link(file)
    if not file.is_file():
        raise ReportError(f"{folder} has no manifest.json; expected a results folder")
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ReportError(f"{file} cannot be read as JSON: {error}") from None
    if not isinstance(data, dict):
        raise ReportError(f"{file} holds {type(data).__name__}; expected an object")
    if data.get("schema") != VERSION:
        raise ReportError(
            f"{file}: schema is {data.get('schema')!r}; expected {VERSION}: run it again"
        )
    experiment = data.get("experiment")
    if not isinstance(experiment, dict) or not isinstance(experiment.get("name"), str):
        raise ReportError(f"{file}: experiment has no name; expected an object with one")
    return _manifest(experiment, data)


def _manifest(experiment: dict[str, Any], data: dict[str, Any]) -> Manifest:
    def text(value: Any) -> str:
        return "" if value is None else str(value)

    def mapping(value: Any) -> dict[str, Any]:
        return value if isinstance(value, dict) else {}

    solvers, runs = mapping(data.get("solvers")), data.get("runs")
    command, tolerance = data.get("command"), data.get("gap_tolerance")
    return Manifest(
        name=experiment["name"],
        title=text(experiment.get("title")) or experiment["name"],
        question=text(experiment.get("question")),
        text=text(experiment.get("text")),
        command=" ".join(map(str, command)) if isinstance(command, list) else text(command),
        versions=mapping(data.get("versions")),
        machine=mapping(data.get("machine")),
        git=mapping(data.get("git")),
        solvers={spec: mapping(mapping(own).get("settings")) for spec, own in solvers.items()},
        codes={spec: text(mapping(own).get("code")) for spec, own in solvers.items()},
        runs=tuple(run for run in runs if isinstance(run, dict)) if isinstance(runs, list) else (),
        gap_tolerance=tolerance if isinstance(tolerance, float) and tolerance > 0 else None,
        created=text(data.get("created")),
        finished=text(data.get("finished")),
    )


def _read_parts(folder: FilePath) -> pa.Table:
    _refuse_link(folder / "parts")
    parts = sorted((folder / "parts").glob("*.parquet"))
    if not parts:
        raise ReportError(f"{folder} has no rows: expected Parquet files in {folder / 'parts'}")
    table = pa.concat_tables([_read_part(part) for part in parts])
    if not table.num_rows:
        raise ReportError(f"{folder} has no rows: its parts are empty")
    return table


def _refuse_link(place: FilePath) -> None:
    if place.is_symlink():
        raise ReportError(
            f"{place} is a link; expected a file or folder of its own, since nothing outside a "
            "results folder is read: put a copy in its place"
        )


def _read_part(part: FilePath) -> pa.Table:
    _refuse_link(part)
    try:
        # a file object, or Arrow would read hive-style column names out of the folder's name
        with part.open("rb") as stream:
            file = pq.ParquetFile(stream, page_checksum_verification=True)
            said = (file.metadata.metadata or {}).get(VERSION_KEY.encode(), str(VERSION).encode())
            problem = _difference(file.schema_arrow.names)
            if said != str(VERSION).encode():
                problem = f"schema is {said!r:.60}"
            if problem:
                raise ReportError(f"{part}: {problem}; expected the columns of schema {VERSION}")
            table = file.read(columns=[*_LIGHT, *_CONTROLS])
        return table.cast(pa.schema([_SCHEMA.field(name) for name in table.column_names]))
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        if not isinstance(error, OSError) or error.errno is None:
            reason += "; if it is damaged, run it again into this folder for its rows"
        raise ReportError(f"{part} cannot be read: {reason}") from None


def _difference(found: Sequence[str]) -> str | None:
    wanted = set(_SCHEMA.names)
    if missing := [name for name in _SCHEMA.names if name not in found]:
        return f"missing column {missing[0]!r}"
    if unknown := [name for name in found if name not in wanted]:
        return f"unknown column {unknown[0]!r}"
    return None if len(found) == len(wanted) else "a column twice"
