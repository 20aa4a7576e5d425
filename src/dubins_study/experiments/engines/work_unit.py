"""Chains of cells and their rows as they travel between machines: JSON there, Arrow back."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import pyarrow as pa

from dubins_study.experiments.plan.cells import Cell, Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, rows_table
from dubins_study.study.rows.schema import SCENARIO, Key, names
from dubins_study.study.scenario import Pose, Scenario


class Chunk(NamedTuple):
    """What one task is asked: chains of cells, and the paths before them (see `solve_chains`)."""

    run: RunSettings
    chains: list[Chain]
    before: Mapping[Key, Path]

    @property
    def cells(self) -> int:
        return sum(map(len, self.chains))


class Returned(NamedTuple):
    """What a Dask worker returns of a chunk.

    Args:
        rows: of the chunk's first cells, as an Arrow stream.
        refusal: why there can be no more, if so.
        machine: the name of the worker's machine.
        probes: seconds that the calibration's piece of work took there.
    """

    rows: bytes
    refusal: str
    machine: str
    probes: list[float]


def encoded(chunk: Chunk) -> bytes:
    """A chunk as JSON, which keeps every double to the last bit."""
    chains = [[_cell(cell) for cell in chain] for chain in chunk.chains]
    firsts = [chunk.before.get(chain[0].key) for chain in chunk.chains]
    paths = [path and _path(path) for path in firsts]
    return json.dumps([[*chunk.run], chains, paths]).encode()


def decoded(sent: bytes) -> Chunk:
    """The chunk again."""
    run, listed, paths = json.loads(sent)
    chains = [tuple(_read_cell(*cell) for cell in chain) for chain in listed]
    before = {
        chain[0].key: Path(Pose(*path[0]), path[1], path[2])
        for chain, path in zip(chains, paths, strict=True)
        if path is not None
    }
    return Chunk(RunSettings(*run), chains, before)


def _cell(cell: Cell) -> list[object]:
    return [*cell.key, [getattr(cell.scenario, name) for name in names(SCENARIO)]]


def _read_cell(
    name: str,
    solver: str,
    profile: str,
    branch: str,
    initial_guess: str,
    repeat: int,
    code_digest: str,
    scenario: list[float | str],
) -> Cell:
    fields = dict(zip(names(SCENARIO), scenario, strict=True))
    asked = Scenario(**fields)  # type: ignore[arg-type]
    return Cell(name, solver, profile, branch, initial_guess, repeat, code_digest, asked)


def _path(path: Path) -> list[list[float]]:
    return [list(path.start), path.curvature.tolist(), path.length.tolist()]


def rows_sent(rows: Iterable[Row]) -> bytes:
    """Rows as an Arrow stream: nothing in it that a plug-in could have made."""
    table = rows_table(rows)
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as stream:
        stream.write_table(table)
    sent: bytes = sink.getvalue().to_pybytes()
    return sent


def rows_received(sent: bytes) -> list[Row]:
    """The rows again."""
    with pa.ipc.open_stream(sent) as stream:
        rows: list[Row] = stream.read_all().to_pylist()
    return rows


def first_cells(chains: Iterable[Chain], most: int) -> list[Chain]:
    """So many cells from the beginning; a chain may be cut short."""
    taken: list[Chain] = []
    for chain in chains:
        if most <= 0:
            break
        taken.append(chain[:most])
        most -= len(chain)
    return taken
