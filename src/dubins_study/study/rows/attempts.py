"""Attempts at the same cell from several folders: which are kept, and which contradict them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

# The columns in which two attempts at a cell, made by the same code, must agree; their gaps must
# agree to a tolerance.
JUDGED = ("outcome", "claim", "verdict", "word")


def compare_attempts(
    rows: pd.DataFrame, cell: Sequence[str]
) -> tuple[NDArray[np.intp], pd.DataFrame]:
    """Keep the first row of each cell, and put every other one beside it.

    Args:
        rows: in the order of preference.
        cell: the columns that name a cell.

    Returns:
        The positions of the rows that are kept, ascending, and a row for every other attempt: its
        columns, and the kept attempt's with the suffix `_kept`; the columns of the cell stand once.
    """
    kept = ~rows.duplicated(list(cell)).to_numpy()
    pairs = rows[~kept].merge(rows[kept], on=list(cell), suffixes=("", "_kept"))
    return np.flatnonzero(kept), pairs


def differences(pairs: pd.DataFrame, tolerance: float) -> pd.DataFrame:
    """Where attempts contradict the kept attempt at their cell.

    Args:
        pairs: columns of `JUDGED` and `gap`, each also with the suffix `_kept`.
        tolerance: by how much the gaps of two attempts that agree may differ.

    Returns:
        The columns of `JUDGED` and `gap`, true where they differ; a value that is missing in both
        attempts does not differ. The index is that of `pairs`.
    """
    differ = {}
    for name in (*JUDGED, "gap"):
        one, other = pairs[name], pairs[f"{name}_kept"]
        if name == "gap":
            agree = (one - other).abs() <= tolerance
        else:
            agree = one.astype(object) == other.astype(object)
        differ[name] = ~agree & ~(one.isna() & other.isna())
    return pd.DataFrame(differ, index=pairs.index)
