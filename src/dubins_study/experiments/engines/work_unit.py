"""Chains of cells and their rows as they travel between machines: JSON there, Arrow back."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import pyarrow as pa

from dubins_study.experiments.plan.cells import Cell, Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, rows_table
from dubins_study.study.rows.schema import SCENARIO, Key, names
from dubins_study.study.scenario import Pose, Scenario


class WorkUnit(NamedTuple):
    """The cells of one Dask task.

    Args:
        settings: of the run.
        chains: single cells, and sweeps or the rest of them.
        before: the path before the first cell of a chain, by that cell's key.
    """

    settings: RunSettings
    chains: list[Chain]
    before: Mapping[Key, Path]

    @property
    def cells(self) -> int:
        return sum(map(len, self.chains))


class UnitReply(NamedTuple):
    """What a Dask worker returns of a work unit.

    Args:
        rows: of the unit's first cells, as an Arrow stream; empty if there are none.
        refusal: why this worker solves no more of the unit; empty if it does.
        machine: the name of the worker's machine.
        probes_s: seconds that the calibration's piece of work took there.
    """

    rows: bytes
    refusal: str
    machine: str
    probes_s: list[float]


def encoded(unit: WorkUnit) -> bytes:
    """A work unit as JSON, which keeps every double to the last bit."""
    chains = [[_encoded_cell(cell) for cell in chain] for chain in unit.chains]
    firsts = [unit.before.get(chain[0].key) for chain in unit.chains]
    paths = [path and _encoded_path(path) for path in firsts]
    return json.dumps([[*unit.settings], chains, paths]).encode()


def decoded(message: bytes) -> WorkUnit:
    """The work unit that `encoded` made a message of."""
    settings, listed, paths = json.loads(message)
    chains = [tuple(_decoded_cell(cell) for cell in chain) for chain in listed]
    before = {
        chain[0].key: Path(Pose(*path[0]), path[1], path[2])
        for chain, path in zip(chains, paths, strict=True)
        if path is not None
    }
    return WorkUnit(RunSettings(*settings), chains, before)


def _encoded_cell(cell: Cell) -> list[object]:
    return [*cell.key, [getattr(cell.scenario, name) for name in names(SCENARIO)]]


def _decoded_cell(values: list[Any]) -> Cell:
    """A cell from the values of its key and those of its scenario."""
    *key, numbers = values
    scenario = Scenario(**dict(zip(names(SCENARIO), numbers, strict=True)))
    return Cell._make([*key, scenario])


def _encoded_path(path: Path) -> list[list[float]]:
    return [list(path.start), path.curvature.tolist(), path.length.tolist()]


def encoded_rows(rows: Iterable[Row]) -> bytes:
    """Rows as an Arrow stream, which holds plain values and no object of a plug-in."""
    table = rows_table(rows)
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as stream:
        stream.write_table(table)
    message: bytes = sink.getvalue().to_pybytes()
    return message


def decoded_rows(message: bytes) -> list[Row]:
    """The rows that `encoded_rows` made a message of."""
    with pa.ipc.open_stream(message) as stream:
        rows: list[Row] = stream.read_all().to_pylist()
    return rows


def first_cells(chains: Iterable[Chain], most: int) -> list[Chain]:
    """The first `most` cells of chains, at most; the last chain may be cut short."""
    taken: list[Chain] = []
    for chain in chains:
        if most <= 0:
            break
        taken.append(chain[:most])
        most -= len(chain)
    return taken
