"""Results folders in, one frame of judged attempts out. Nothing is ever unpickled."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.report.data.parts import (
    CONTROLS,
    LIGHT,
    MOST_ROWS,
    ReportError,
    Seen,
    count,
    drawn,
    parts_of,
    pieces,
    plain,
    refuse_link,
)
from dubins_study.report.data.reduction import NEEDED, Reduction, merged, of
from dubins_study.report.data.visible import visible_values
from dubins_study.study.check.verdict import Tolerances
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import VERSION
from dubins_study.study.scenario import Pose

_GAP = Tolerances().gap  # of a manifest that tells none

__all__ = ["Manifest", "ReportError", "Results", "load", "load_results", "read_manifest"]


@dataclass(frozen=True)
class Manifest:
    """What a run says of itself, and what of its rows was left out.

    Args:
        section: the report's section that is about this experiment, if it names one.
        solvers: every spec's settings.
        codes: every spec's code; rows of another were made by something else.
        runs: an entry a run, as the run wrote it.
        stale: rows of another code in the folder.
        replaced: cells left out since an earlier folder holds them, made by another code.
        contradicting: cells left out where the same code found something else in an earlier folder.
    """

    name: str
    title: str
    question: str
    text: str
    command: str
    section: str | None = None
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
    contradicting: int = 0


@dataclass(frozen=True, eq=False)
class Results:
    """The attempts of one or more folders.

    Args:
        manifests: one per folder, in the order given.
        reduction: what the numbers over all attempts need.
        rows: one row an attempt, index 0, 1, ...: the scalar columns of `study.rows.schema` that a
            report needs, and `experiment`, the manifest's name. Of more attempts than
            `parts.MOST_ROWS` only those at some scenarios, chosen by their names.
        controls: the columns `curvatures` and `lengths`, left in Arrow because most sections draw
            no path; a row's index is its position here, also where `rows` is a selection.
        solvers: every spec in the folders, also where `rows` is a selection.
    """

    manifests: tuple[Manifest, ...]
    reduction: Reduction
    rows: pd.DataFrame
    controls: pa.Table
    solvers: tuple[str, ...] = ()

    @property
    def sampled(self) -> bool:
        """Whether `rows` leaves attempts out."""
        return len(self.rows) < self.reduction.total.attempts

    @property
    def settings(self) -> dict[str, dict[str, Any]]:
        """Every spec's settings, as the manifests hold them."""
        return {spec: own for run in self.manifests for spec, own in run.solvers.items()}

    def only(self, experiments: Collection[str]) -> Results:
        """The attempts of some experiments, and their manifests."""
        names = set(experiments)
        return replace(
            self,
            manifests=tuple(run for run in self.manifests if run.name in names),
            reduction=self.reduction.only(names),
            rows=self.rows[self.rows["experiment"].isin(names)],
        )

    def path(self, index: int) -> Path | None:
        """The path of the row with this index, or None if no path came back."""
        curvature = self.controls.column("curvatures")[index].as_py()
        length = self.controls.column("lengths")[index].as_py()
        if curvature is None or length is None:
            return None
        start = self.rows.loc[index, list(Pose._fields)].to_numpy(dtype=np.float64)
        return Path(Pose(*start), curvature, length)


def load_results(folders: str | FilePath | Iterable[str | FilePath]) -> pd.DataFrame:
    """The judged rows of one or more results folders, read as the report reads them.

    Args:
        folders: a results folder, or several; of a cell that two of them hold, the first is kept.

    Returns:
        One row an attempt, index 0, 1, ...: `experiment`, the columns of `study.rows.schema` but
        `versions`, `machine` and `run_id`, with `curvatures` and `lengths` as Arrow lists. Rows of
        earlier code are left out. Missing numbers are null.

    Raises:
        ReportError: naming the folder and what is wrong with it.
    """
    several = [folders] if isinstance(folders, str | FilePath) else folders
    results = load(several, most_rows=None)
    controls = {name: pd.arrays.ArrowExtensionArray(results.controls[name]) for name in CONTROLS}
    return results.rows.assign(**controls)


def load(folders: Iterable[str | FilePath], most_rows: int | None = MOST_ROWS) -> Results:
    """Read results folders and join them; of a cell that two folders hold, the first is kept.

    Read piece by piece: memory does not grow with the number of streamed rows.

    Args:
        folders: at least one.
        most_rows: of more attempts a sample of the rows is kept; None keeps all rows.

    Raises:
        ReportError: naming the folder and what is wrong with it.
    """
    paths = [FilePath(folder) for folder in folders]
    if not paths:
        raise ReportError("no results folder given; expected at least one")
    manifests = [read_manifest(path) for path in paths]
    parts = [parts_of(path) for path in paths]
    attempts = sum(count(part) for own in parts for part in own)
    seen, kept, reduced = Seen(), [], [Reduction()]
    for number, (path, manifest) in enumerate(zip(paths, manifests, strict=True)):
        stale = replaced = contradicting = current = 0
        for part in parts[number]:
            chunk, replaces = seen.is_new(manifest.name, part, manifest.codes)
            for piece in pieces(part):
                table = _current(manifest, piece)
                stale += len(piece) - len(table)
                current += len(table)
                if chunk is False:
                    replaced += len(table) * replaces
                    continue
                if chunk is None:
                    new = seen.new(manifest.name, table, manifest.gap_tolerance or _GAP)
                    table = new.table
                    replaced += new.other_code
                    contradicting += new.contradicting
                name = pa.repeat(pa.scalar(manifest.name), len(table)).dictionary_encode()
                table = table.append_column("experiment", name)
                reduced.append(of(table.select(list(NEEDED)).to_pandas()))
                whole = most_rows is None or attempts <= most_rows
                kept.append(table if whole else drawn(table, attempts))
            reduced = [merged(reduced)]
        if not current:
            raise ReportError(f"{path} has no rows but of earlier code: run it again")
        manifests[number] = replace(
            manifest, stale=stale, replaced=replaced, contradicting=contradicting
        )
    table = pa.concat_tables([plain(table) for table in kept])
    rows = table.select(["experiment", *LIGHT]).to_pandas()
    controls = table.select(CONTROLS).combine_chunks()
    return Results(tuple(manifests), reduced[0], rows, controls, tuple(reduced[0].solvers))


def _current(manifest: Manifest, table: pa.Table) -> pa.Table:
    """The rows of the code that the manifest names; of a solver that it does not name, all."""
    solver, code = (table[name].to_pandas().astype(object) for name in ("solver", "code_digest"))
    named = solver.map(manifest.codes)
    stale = named.notna() & (named != code)
    return table.filter(pa.array(~stale)) if stale.any() else table


def read_manifest(folder: FilePath) -> Manifest:
    """The manifest of a results folder.

    Raises:
        ReportError: if there is none, or it is not one of this schema version.
    """
    file = folder / "manifest.json"
    try:
        there = folder.is_dir()
    except OSError as error:  # a name that is too long
        raise ReportError(f"{folder} cannot be read: {error.strerror}") from None
    if not there:
        raise ReportError(f"{folder} is not a folder; expected a results folder")
    refuse_link(file)
    if not file.is_file():
        raise ReportError(f"{folder} has no manifest.json; expected a results folder")
    try:
        data = visible_values(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError, RecursionError) as error:
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
        section=text(experiment.get("section")) or None,
        versions=mapping(data.get("versions")),
        machine=mapping(data.get("machine")),
        git=mapping(data.get("git")),
        solvers={spec: mapping(mapping(own).get("settings")) for spec, own in solvers.items()},
        codes={spec: text(mapping(own).get("code_digest")) for spec, own in solvers.items()},
        runs=tuple(run for run in runs if isinstance(run, dict)) if isinstance(runs, list) else (),
        gap_tolerance=tolerance if isinstance(tolerance, float) and tolerance > 0 else None,
        created=text(data.get("created")),
        finished=text(data.get("finished")),
    )
