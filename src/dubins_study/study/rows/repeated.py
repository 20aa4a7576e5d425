"""Compare repeated attempts at a cell.

They may come from one folder or several. One attempt is kept, and the others may contradict it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from dubins_study.study.arrays import IntArray

# The columns in which two attempts at a cell, made by the same code, must agree; their gaps must
# agree to a tolerance.
JUDGED = ("outcome", "claim", "verdict", "word")


def compare_attempts(rows: pd.DataFrame, cell: Sequence[str]) -> tuple[IntArray, pd.DataFrame]:
    """Keep the first row of each cell.

    `cell` are the columns that name a cell.

    Returns:
        The ascending positions of the rows that are kept, and a frame with a row for every other
        attempt. It has the attempt's columns, and the kept attempt's with the suffix `_kept`; the
        cell's columns stand once.
    """
    is_first = ~rows.duplicated(list(cell)).to_numpy()
    pairs = rows[~is_first].merge(rows[is_first], on=list(cell), suffixes=("", "_kept"))
    return np.flatnonzero(is_first), pairs


def differences(pairs: pd.DataFrame, tolerance: float) -> pd.DataFrame:
    """Mask of the columns in which pairs differ.

    The pairs are those of `compare_attempts`; the columns are those of `JUDGED` and `gap`. Gaps
    that differ by up to `tolerance` agree, and so do two missing values.
    """
    differ = {}
    for name in (*JUDGED, "gap"):
        one = pairs[name]
        other = pairs[f"{name}_kept"]
        agree = one.astype(object) == other.astype(object)
        if name == "gap":
            agree = (one - other).abs() <= tolerance
        differ[name] = ~agree & ~(one.isna() & other.isna())
    return pd.DataFrame(differ, index=pairs.index)
