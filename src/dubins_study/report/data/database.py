"""A DuckDB connection that can read only the parts of results folders."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import Any

import duckdb
import pandas as pd
import pyarrow as pa

from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.validation import printable_rows

# DuckDB writes data beyond this limit to a temporary folder.
_MEMORY_LIMIT = "600MB"
# A second thread would cost memory and save no time: most of the work is checking the parts.
_THREADS = 1

_SETTINGS: dict[str, str | bool | int | float | list[str]] = {
    "memory_limit": _MEMORY_LIMIT,
    "threads": _THREADS,
    "autoinstall_known_extensions": False,
    "autoload_known_extensions": False,
    "allow_community_extensions": False,
    "python_enable_replacements": False,  # a name in a query is never a variable of Python
}


class Database:
    """The view `stored`: all rows of some parts, in the types of the schema, NaN as null.

    A column that a part lacks, since it was declared later, is null; of an empty table of the
    schema DuckDB takes its type.

    Two columns are added: `part`, the number of the file, and `place`, the row's number in it.

    A query never contains a file's name, because DuckDB would read a name such as `[a]` as a
    pattern. Each part is read through a link with a name that we choose, and DuckDB may open no
    other file. DuckDB does not compare the checksums of pages: the caller must have checked the
    parts with `study.rows.validation.checked_batches`.
    """

    def __init__(self, files: Sequence[FilePath]) -> None:
        self._folder = FilePath(tempfile.mkdtemp(prefix="dubins-study-"))
        self._answers: dict[tuple[str, str], pd.DataFrame] = {}
        spill = str(self._folder / "spill")
        self._connection = duckdb.connect(config=_SETTINGS | {"temp_directory": spill})
        weakref.finalize(self, _close, self._connection, self._folder)
        links = []
        for number, file in enumerate(files):
            link = self._folder / f"{number:08d}.parquet"
            link.symlink_to(file.absolute())
            links.append(str(link))
        self._connection.execute("SET allowed_paths = ?", [links])
        # The cache would keep all parts in memory, up to the limit.
        self._connection.execute("SET enable_external_file_cache = false")
        self._connection.execute("SET enable_external_access = false")
        self._connection.execute("SET lock_configuration = true")
        self.add_table("row", ARROW_SCHEMA.empty_table())
        self._guarded(lambda: self._connection.sql(_STORED, params=[links]).create_view("stored"))

    def run(self, statement: str) -> None:
        """Run a statement that returns nothing."""
        self._guarded(lambda: self._connection.execute(statement))

    def add_table(self, name: str, table: pa.Table) -> None:
        """Copy a table into the database."""
        self._connection.register("given", table)
        self.run(f'CREATE TABLE "{name}" AS SELECT * FROM given')
        self._connection.unregister("given")

    def table(self, query: str, parameters: Sequence[Any] = ()) -> pa.Table:
        """The result of a query, with unchanged values.

        Raises:
            ResultsError: if a part cannot be read any more.
        """
        table: pa.Table = self._guarded(
            lambda: self._connection.sql(query, params=list(parameters)).to_arrow_table()
        )
        return table

    def frame(self, query: str, parameters: Sequence[Any] = ()) -> pd.DataFrame:
        """The result of a query, with printable texts; the result of a repeated query is cached.

        Raises:
            ResultsError: if a part cannot be read any more.
        """
        key = query, repr(parameters)
        if key not in self._answers:
            self._answers[key] = printable_rows(self.table(query, parameters)).to_pandas()
        return self._answers[key]

    def _guarded(self, act: Callable[[], Any]) -> Any:
        try:
            return act()
        except duckdb.Error as error:
            reason = str(error).partition("\n")[0].replace(f"{self._folder}/", "part ")
            raise ResultsError(
                f"the parts cannot be read as one table: {reason}; if a run is writing to them, "
                "try again when it is done"
            ) from None


def _close(connection: duckdb.DuckDBPyConnection, folder: FilePath) -> None:
    connection.close()
    shutil.rmtree(folder, ignore_errors=True)


def _typed(field: pa.Field[Any]) -> str:
    if pa.types.is_floating(field.type):
        return f'nullif(CAST("{field.name}" AS DOUBLE), \'nan\'::DOUBLE) AS "{field.name}"'
    types = {pa.string(): "VARCHAR", pa.int64(): "BIGINT", pa.bool_(): "BOOLEAN"}
    return f'CAST("{field.name}" AS {types.get(field.type, "DOUBLE[]")}) AS "{field.name}"'


_STORED = f"""
    SELECT part, place, {", ".join(map(_typed, ARROW_SCHEMA))}
    FROM (SELECT *, file_index AS part, file_row_number AS place
        FROM read_parquet(?, union_by_name = true, hive_partitioning = false)
        UNION ALL BY NAME FROM row)
"""
