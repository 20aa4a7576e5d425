"""Rows as tables of the schema."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import pyarrow as pa

from dubins_study.study.path import Path
from dubins_study.study.rows.schema import KEY, Key, arrow_schema, names
from dubins_study.study.scenario import Pose

Row = dict[str, Any]

ARROW_SCHEMA = arrow_schema()


def rows_table(rows: Iterable[Mapping[str, Any]]) -> pa.Table:
    """Rows as a table of the schema; what no file can hold is null, or a question mark in a text.

    Their values are of the schema's types: `Solution` has refused others of a solver.
    """
    rows = list(rows)
    columns = [_column([row[field.name] for row in rows], field.type) for field in ARROW_SCHEMA]
    return pa.Table.from_arrays(columns, schema=ARROW_SCHEMA)


def _column(values: list[Any], kind: pa.DataType) -> Any:
    if pa.types.is_string(kind):  # lone surrogates cannot be encoded as UTF-8
        values = [text and text.encode("utf-8", "replace").decode() for text in values]
    elif pa.types.is_floating(kind):
        values = _finite(values)
    elif pa.types.is_list(kind):
        values = [numbers and _finite(numbers) for numbers in values]
    return pa.array(values, type=kind)


def _finite(numbers: list[Any]) -> list[Any]:
    return [x if x is None or math.isfinite(x) else None for x in numbers]


def row_key(row: Mapping[str, Any]) -> Key:
    """The values of the key columns."""
    key: Any = tuple(row[name] for name in names(KEY))
    return key  # type: ignore[no-any-return]


def row_path(row: Mapping[str, Any]) -> Path | None:
    """The path of a row, if it arrived."""
    if row["gap"] is None:
        return None
    return Path(Pose(row["x"], row["y"], row["heading"]), row["curvatures"], row["lengths"])
