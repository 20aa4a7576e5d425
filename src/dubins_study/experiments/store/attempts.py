"""Attempts at the same cell from several folders: one, agreeing, or a contradiction."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.experiments.store.disk import StoreError
from dubins_study.study.rows.schema import KEY, names

_WORDS = ("outcome", "claim", "verdict", "word")
JUDGED = (*_WORDS, "gap", "run_id", "started")
_MOST_LISTED = 5


class Merged(NamedTuple):
    """Rows, each cell once, and how many further attempts at a cell agreed with the one kept."""

    table: pa.Table
    again: int


def merged_rows(tables: Sequence[pa.Table], folders: Sequence[FilePath], gap: float) -> Merged:
    """The union of the folders' rows; of the attempts at a cell the earliest is kept.

    Args:
        tables: rows of the schema, a table a folder.
        folders: where they are from.
        gap: how far the gaps of two attempts that agree may differ.

    Raises:
        StoreError: naming the cells whose attempts contradict each other.
    """
    table = pa.concat_tables(tables)
    frame = table.select([*names(KEY), *JUDGED]).to_pandas()
    frame["folder"] = np.repeat([str(folder) for folder in folders], [len(own) for own in tables])
    ordered = frame.sort_values("started", kind="stable")
    kept = ~ordered.duplicated(names(KEY))
    if kept.all():
        return Merged(table, 0)
    pairs = ordered[~kept].merge(ordered[kept], on=names(KEY), suffixes=("", "_kept"))
    _refuse_contradictions(pairs, gap)
    same = (pairs["run_id"] == pairs["run_id_kept"]) & (pairs["started"] == pairs["started_kept"])
    rows = np.sort(ordered.index[kept].to_numpy())
    return Merged(table.take(pa.array(rows)), int((~same).sum()))


def _refuse_contradictions(pairs: pd.DataFrame, gap: float) -> None:
    differing = {name: _differ(pairs, name) for name in _WORDS}
    near = (pairs["gap"] - pairs["gap_kept"]).abs() <= gap
    differing["gap"] = ~near & ~(pairs["gap"].isna() & pairs["gap_kept"].isna())
    wrong = pd.DataFrame(differing)
    found = pairs[wrong.any(axis=1)]
    if found.empty:
        return
    lines = [_told(pairs.loc[i], wrong.loc[i]) for i in found.index[:_MOST_LISTED]]
    if len(found) > _MOST_LISTED:
        lines.append(f"and {len(found) - _MOST_LISTED} more")
    raise StoreError(
        f"the folders contradict each other in {len(found)} "
        f"cell{'' if len(found) == 1 else 's'}; nothing was merged:\n  " + "\n  ".join(lines)
    )


def _differ(pairs: pd.DataFrame, name: str) -> pd.Series[bool]:
    one, other = pairs[name], pairs[f"{name}_kept"]
    return (one != other) & ~(one.isna() & other.isna())


def _told(pair: pd.Series[str], wrong: pd.Series[bool]) -> str:
    cell = ", ".join(str(pair[name]) for name in names(KEY))
    values = "; ".join(
        f"{name} is {_shown(pair[f'{name}_kept'])} in {pair['folder_kept']} and "
        f"{_shown(pair[name])} in {pair['folder']}"
        for name in wrong.index[wrong]
    )
    return f"{cell}: {values}"


def _shown(value: object) -> str:
    if isinstance(value, str):
        return repr(value)
    return "missing" if pd.isna(value) else f"{value:g}"  # type: ignore[call-overload]
