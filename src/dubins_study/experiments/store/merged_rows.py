"""Merge several folders into one table with one row per cell; refuse contradictions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa

from dubins_study.study.rows.attempts import JUDGED, compare_attempts, differences
from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.schema import KEY, names

# The columns that decide which rows are kept.
COLUMNS = [*names(KEY), *JUDGED, "gap", "run_id", "started"]
_MAX_LISTED = 5


class MergedRows(NamedTuple):
    """The result of `merged_rows`.

    Args:
        table: one row per cell.
        agreeing_repeats: number of other attempts that agreed; copies of the same attempt are not
            counted.
    """

    table: pa.Table
    agreeing_repeats: int


def merged_rows(
    tables: Sequence[pa.Table], folders: Sequence[FilePath], tolerance: float
) -> MergedRows:
    """Unite the rows of folders; of several attempts at a cell, the earliest is kept.

    Args:
        tables: one table per folder, with at least the columns of `COLUMNS`.
        folders: the folders of the tables.
        tolerance: largest difference between the gaps of two attempts that still count as equal.

    Raises:
        ResultsError: naming the cells whose attempts contradict each other.
    """
    table = pa.concat_tables(tables)
    rows = table.select(COLUMNS).to_pandas()
    rows["folder"] = np.repeat([str(folder) for folder in folders], [len(each) for each in tables])
    rows = rows.sort_values("started", kind="stable")
    kept, pairs = compare_attempts(rows, names(KEY))
    if pairs.empty:
        return MergedRows(table, 0)
    _refuse_contradictions(pairs, differences(pairs, tolerance))
    copies = (pairs["run_id"] == pairs["run_id_kept"]) & (pairs["started"] == pairs["started_kept"])
    positions = np.sort(rows.index.to_numpy()[kept])
    return MergedRows(table.take(pa.array(positions)), int((~copies).sum()))


def _refuse_contradictions(pairs: pd.DataFrame, differ: pd.DataFrame) -> None:
    cells = pairs.index[differ.any(axis=1)]
    if cells.empty:
        return
    lines = [_contradiction(pairs.loc[i], differ.loc[i]) for i in cells[:_MAX_LISTED]]
    if len(cells) > _MAX_LISTED:
        lines.append(f"and {len(cells) - _MAX_LISTED} more")
    raise ResultsError(
        f"the folders contradict each other in {len(cells)} "
        f"cell{'' if len(cells) == 1 else 's'}; nothing was merged:\n  " + "\n  ".join(lines)
    )


def _contradiction(pair: pd.Series[str], differ: pd.Series[bool]) -> str:
    cell = ", ".join(str(pair[name]) for name in names(KEY))
    values = "; ".join(
        f"{name} is {_shown(pair[f'{name}_kept'])} in {pair['folder_kept']} and "
        f"{_shown(pair[name])} in {pair['folder']}"
        for name in differ.index[differ]
    )
    return f"{cell}: {values}"


def _shown(value: object) -> str:
    if isinstance(value, str):
        return repr(value)
    return "missing" if pd.isna(value) else f"{value:g}"  # type: ignore[call-overload]
