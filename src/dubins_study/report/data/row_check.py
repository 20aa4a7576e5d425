"""Rows that no run writes, refused before numbers are made of them."""

from __future__ import annotations

import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.study.rows.schema import KEY, names
from dubins_study.study.scenario import NUMBERS

_POSITIVE = ("radius", "speed")
_TIMES = ("build_s", "solve_s", "wall_s")
_COUNTS = ("repeat", "threads", "jobs", "iterations", "evaluations")
_ALWAYS = (*names(KEY), *NUMBERS)
_LONGEST = 1e9  # s; thirty years
_CONTROLS = ("curvatures", "lengths")


def impossible(table: pa.Table) -> str | None:
    """The first thing wrong with rows of the schema, or None.

    Args:
        table: columns of the schema's types, of which any may be missing.
    """
    for name in table.column_names:
        column = table[name]
        if name in _ALWAYS and column.null_count:
            return f"{name} is missing in a row; expected a value in every row"
        if name in _CONTROLS:
            values = pc.list_flatten(column)
            if values.null_count or not _are_finite(values):
                return f"{name} holds what is no finite number; expected the controls of a path"
        elif pa.types.is_floating(column.type) and not _are_finite(column, name not in NUMBERS):
            return f"{name} is not finite in a row; expected a number or nothing"
        if problem := _outside(name, column):
            return problem
    if all(name in table.column_names for name in _CONTROLS):
        sizes = [pc.fill_null(pc.list_value_length(table[name]), -1) for name in _CONTROLS]
        if not pc.all(pc.equal(*sizes), min_count=0).as_py():
            return "curvatures and lengths of a row differ in number; expected a length for each"
    return None


def _are_finite(column: pa.ChunkedArray, nan: bool = False) -> bool:
    """Whether none is infinite; NaN counts as missing where something may be missing."""
    infinite = pc.any(pc.is_inf(column)).as_py()
    return not (infinite or (not nan and pc.any(pc.is_nan(column)).as_py()))


def _outside(name: str, column: pa.ChunkedArray) -> str | None:
    if name in _POSITIVE:
        least = pc.min(column).as_py()
        return None if least is None or least > 0 else f"{name} is {least}; expected above 0"
    most = _LONGEST if name in _TIMES else 2**53 if name in _COUNTS else None
    if most is None:
        return None
    low, high = pc.min_max(column).as_py().values()
    if low is None or (low >= 0 and high <= most):
        return None
    return f"{name} is {low if low < 0 else high}; expected a number from 0 to {most:g}"
