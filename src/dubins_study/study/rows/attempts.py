"""Attempts at the same cell from several folders: which are kept, and which contradict them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

# The columns in which two attempts at a cell, made by the same code, must agree; their gaps must
# agree to a tolerance.
JUDGED = ("outcome", "claim", "verdict", "word")


class Attempts(NamedTuple):
    """Rows by cell.

    Args:
        kept: the positions of the rows that are kept, one a cell, ascending.
        repeated: a row for every other attempt: its columns, the kept attempt's columns with the
            suffix `_kept`; the columns that name the cell stand once.
    """

    kept: NDArray[np.intp]
    repeated: pd.DataFrame


def compare_attempts(rows: pd.DataFrame, cell: Sequence[str]) -> Attempts:
    """Keep the first row of each cell, and put every other one beside it.

    Args:
        rows: in the order of preference.
        cell: the columns that name a cell.
    """
    kept = ~rows.duplicated(list(cell)).to_numpy()
    pairs = rows[~kept].merge(rows[kept], on=list(cell), suffixes=("", "_kept"))
    return Attempts(np.flatnonzero(kept), pairs)


def differences(pairs: pd.DataFrame, tolerance: float) -> pd.DataFrame:
    """Where attempts contradict the kept attempt at their cell.

    Args:
        pairs: columns of `JUDGED` and `gap`, each also with the suffix `_kept`.
        tolerance: by how much the gaps of two attempts that agree may differ.

    Returns:
        The columns of `JUDGED` and `gap`, true where they differ; a value that is missing in both
        attempts does not differ. The index is that of `pairs`.
    """
    differ = {name: _differs(pairs[name], pairs[f"{name}_kept"]) for name in JUDGED}
    near = (pairs["gap"] - pairs["gap_kept"]).abs() <= tolerance
    differ["gap"] = ~near & ~(pairs["gap"].isna() & pairs["gap_kept"].isna())
    return pd.DataFrame(differ, index=pairs.index)


def _differs(one: pd.Series, other: pd.Series) -> pd.Series[bool]:
    one, other = one.astype(object), other.astype(object)
    return (one != other) & ~(one.isna() & other.isna())
