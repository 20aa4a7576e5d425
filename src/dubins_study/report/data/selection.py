"""The rows of several results folders that count: current code, without duplicates; by DuckDB."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import duckdb
import pandas as pd
import pyarrow as pa

from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.rows.attempts import JUDGED, compare_attempts, differences
from dubins_study.study.rows.parts import Part
from dubins_study.study.rows.schema import CELL, names
from dubins_study.study.scenario import COLUMNS, Scenario

_CELL = ("experiment", *names(CELL))


class Database:
    """The rows of some folders as DuckDB's table `stored`, with NaN as null.

    Its columns are those of the schema, `part` (number of the file) and `place` (the row's in it).
    """

    def __init__(self, rows: pa.Table) -> None:
        self._answers: dict[tuple[str, str], pd.DataFrame] = {}
        self._connection = duckdb.connect(config={"threads": 1})
        self.add_table("stored", rows)
        for field in rows.schema:
            if pa.types.is_floating(field.type):
                name = f'"{field.name}"'
                self.run(f"UPDATE stored SET {name} = NULL WHERE isnan({name})")

    def run(self, statement: str) -> None:
        """Run a statement that returns nothing."""
        self._connection.execute(statement)

    def add_table(self, name: str, table: pa.Table) -> None:
        """Copy a table into the database."""
        self._connection.register("given", table)
        self.run(f'CREATE TABLE "{name}" AS SELECT * FROM given')
        self._connection.unregister("given")

    def table(self, query: str) -> pa.Table:
        """The result of a query."""
        table: pa.Table = self._connection.sql(query).to_arrow_table()
        return table

    def frame(self, query: str, parameters: Sequence[Any] = ()) -> pd.DataFrame:
        """The result of a query; that of a repeated query is cached."""
        key = query, repr(parameters)
        if key not in self._answers:
            result = self._connection.sql(query, params=list(parameters))
            self._answers[key] = result.to_arrow_table().to_pandas()
        return self._answers[key]


class Source(NamedTuple):
    """One results folder, with the values that decide which of its rows count."""

    experiment: str  # its name
    # solver -> digest of the code whose rows count; for a solver that is not listed, all rows count
    code_digests: Mapping[str, str]
    gap_tolerance: float  # attempts whose gaps differ by more contradict each other
    parts: Sequence[Part]


class RowCounts(NamedTuple):
    """Numbers of rows of a folder."""

    current: int  # of the current code, counted in the report or not
    stale: int  # of earlier code
    replaced: int  # of cells that an earlier folder holds with other code
    contradicting: int  # of cells that an earlier folder holds with this code and another result


def select_attempts(database: Database, sources: Sequence[Source]) -> list[RowCounts]:
    """Add the view `attempts` to a database, and count the rows of each source.

    The view has the columns of `stored`, `experiment`, and `answerable`: whether the question has
    an answer, so that a gap can be measured. The database has the sources' parts in the same order;
    if two sources hold the same cell, the earlier one's attempt counts.
    """
    blocks = _blocks(database, sources)
    columns = ["part", "solver", "code_digest", "experiment"]
    _add(database, "blocks", blocks.loc[blocks["current"], columns])
    database.run(_CURRENT)
    pairs = _leave_out_repeats(database)
    pairs["source"] = pairs["part"].map(dict(enumerate(_source_of_part(sources))))
    _mark_answerable(database)
    return [
        _row_counts(blocks[blocks["source"] == n], pairs[pairs["source"] == n], s.gap_tolerance)
        for n, s in enumerate(sources)
    ]


def _row_counts(blocks: pd.DataFrame, pairs: pd.DataFrame, gap_tolerance: float) -> RowCounts:
    rows, current = blocks["rows"], blocks["current"]
    other_code = pairs["code_digest"] != pairs["code_digest_kept"]
    differ = differences(pairs, gap_tolerance).any(axis="columns")
    return RowCounts(
        current=int(rows[current].sum()),
        stale=int(rows[~current].sum()),
        replaced=int(other_code.sum()),
        contradicting=int((differ & ~other_code).sum()),
    )


def _source_of_part(sources: Sequence[Source]) -> list[int]:
    """Index of each part's source, in the order of the parts."""
    return [number for number, source in enumerate(sources) for _ in source.parts]


def _blocks(database: Database, sources: Sequence[Source]) -> pd.DataFrame:
    """Number of rows per part, solver and code, and whether they count.

    Columns: source, part, solver, code_digest, experiment, rows, current (whether the code is
    current).
    """
    source_of = _source_of_part(sources)
    records = []
    for block in database.table(_BLOCKS).to_pylist():
        number = source_of[block["part"]]
        source = sources[number]
        digest = block["code_digest"]
        current = source.code_digests.get(block["solver"], digest) == digest
        derived = {"source": number, "experiment": source.experiment, "current": current}
        records.append(block | derived)
    return pd.DataFrame.from_records(records)


def _leave_out_repeats(database: Database) -> pd.DataFrame:
    """Keep the first attempt at each cell; return the others (see `compare_attempts`)."""
    repeated = database.frame(_REPEATED)
    kept, pairs = compare_attempts(repeated, _CELL)
    _add(database, "repeats", repeated.drop(index=repeated.index[kept])[_ROW])
    database.run(_COUNTED)
    return pairs


def _mark_answerable(database: Database) -> None:
    """Add the view `attempts`.

    A judged row has a reference word if the question has an answer. For a row that was not judged,
    the closed form decides.
    """
    unjudged = database.frame(_UNJUDGED)
    answerable = [_has_answer(row) for row in unjudged.to_dict("records")]
    _add(database, "unjudged_answerable", unjudged.loc[answerable, _ROW])
    database.run(_ATTEMPTS)


def _has_answer(row: Mapping[Any, Any]) -> bool:
    scenario = Scenario(**{name: row[name] for name in COLUMNS})
    return shortest(scenario, row["branch"]) is not None


def _add(database: Database, name: str, frame: pd.DataFrame) -> None:
    numbers = {column: "int64" for column in _ROW if column in frame}
    database.add_table(name, pa.Table.from_pandas(frame.astype(numbers), preserve_index=False))


_ROW = ["part", "place"]
_BLOCKS = """
    SELECT part, solver, code_digest, count(*) AS rows
    FROM stored GROUP BY ALL ORDER BY ALL
"""
_CURRENT = """
    CREATE VIEW current AS
    SELECT stored.*, blocks.experiment FROM stored JOIN blocks USING (part, solver, code_digest)
"""
_REPEATED = f"""
    SELECT part, place, {", ".join(_CELL)}, code_digest, {", ".join(JUDGED)}, gap
    FROM current WHERE ({", ".join(_CELL)}) IN (
        SELECT ({", ".join(_CELL)}) FROM current
        GROUP BY {", ".join(_CELL)} HAVING count(*) > 1)
    ORDER BY part, place
"""
_COUNTED = "CREATE VIEW counted AS FROM current ANTI JOIN repeats USING (part, place)"
_UNJUDGED = f"""
    SELECT part, place, branch, {", ".join(COLUMNS)}
    FROM counted WHERE reference_word IS NULL AND region IS NULL ORDER BY part, place
"""
_ATTEMPTS = """
    CREATE VIEW attempts AS
    SELECT *, reference_word IS NOT NULL
        OR (part, place) IN (SELECT (part, place) FROM unjudged_answerable) AS answerable
    FROM counted
"""
