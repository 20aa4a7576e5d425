"""Rows as tables of the schema, whatever values a plug-in put into them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from numbers import Real
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.study.path import Path
from dubins_study.study.rows.schema import KEY, NOT_SOLVERS, ROW, Key, arrow_schema, names
from dubins_study.study.scenario import Pose
from dubins_study.study.values import short

Row = dict[str, Any]

ARROW_SCHEMA = arrow_schema()


def rows_table(rows: Iterable[Mapping[str, Any]]) -> pa.Table:
    """Rows as a table of the schema; numbers that are not finite become null.

    A row that does not fit becomes one whose outcome is `raised`, so that it spoils no other.
    """
    rows = list(rows)
    try:
        return _table(rows)
    except Exception:  # `fitting` tells which row it was, and why
        return _table([fitting(row) for row in rows])


def _table(rows: list[Mapping[str, Any]]) -> pa.Table:
    columns = [_column([row[field.name] for row in rows], field.type) for field in ARROW_SCHEMA]
    return pa.Table.from_arrays(columns, schema=ARROW_SCHEMA)


def _column(values: list[Any], kind: pa.DataType) -> Any:
    column: Any = pa.array(values, type=kind, from_pandas=True)  # NaN becomes null
    numbers = column.values if pa.types.is_list(kind) else column
    if pa.types.is_floating(numbers.type) and pc.any(pc.invert(pc.is_finite(numbers))).as_py():
        return pa.array([_clean(value) for value in values], type=kind)
    return column


def fitting(row: Mapping[str, Any]) -> Row:
    """The row as plain values of the schema's types, or a row whose message says what misfits."""
    plain: Row = {}
    misfit = ""
    for field in ARROW_SCHEMA:
        value = row.get(field.name)
        try:
            plain[field.name] = pa.array([_clean(value)], type=field.type)[0].as_py()
        except Exception:  # a plug-in's value may fail in any way, even in its own repr
            misfit = misfit or f"{field.name} is {_clean(short(value))}; expected {field.type}"
    return raised_row(plain, f"TypeError: {misfit}") if misfit else plain


def raised_row(known: Mapping[str, Any], message: str) -> Row:
    """The row of an attempt that raised `message`; of the known columns, no solver's are kept."""
    kept = {name: known.get(name) for name in NOT_SOLVERS}
    ending = {"outcome": "raised", "claim": "none", "verdict": "none", "message": message}
    flags = {"false_claim": False, "wrong_basin": False, "native_status": ""}
    return dict.fromkeys(names(ROW)) | kept | flags | ending


def row_key(row: Mapping[str, Any]) -> Key:
    """The values of the key columns."""
    key: Any = tuple(row[name] for name in names(KEY))
    return key  # type: ignore[no-any-return]


def row_path(row: Mapping[str, Any]) -> Path | None:
    """The path of a row, if it arrived."""
    if row["gap"] is None:
        return None
    return Path(Pose(row["x"], row["y"], row["heading"]), row["curvatures"], row["lengths"])


def _clean(value: Any) -> Any:
    if isinstance(value, str):
        # a lone surrogate cannot be encoded as UTF-8
        return value if value.isascii() else value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, list):
        return [_clean(item) for item in value]
    if isinstance(value, Real) and not isinstance(value, int):
        return value if math.isfinite(value) else None
    return value
