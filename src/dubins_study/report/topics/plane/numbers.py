"""The target plane as grids, and the lengths along a turning circle."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.report.data.attempts import EXACT

# of a grid; scattered targets have one for every pair of coordinates
_MOST_CELLS = 4_000_000
_FEWEST_LINES = 5  # along x and along y; fewer make no map


def exact_answers(rows: pd.DataFrame) -> pd.DataFrame:
    """The closed form's answer to each target; none where the targets make no map."""
    exact = rows[(rows["solver"] == EXACT) & rows["length"].notna()]
    exact = exact.drop_duplicates(["target_x", "target_y"])
    columns, lines = exact["target_x"].nunique(), exact["target_y"].nunique()
    is_grid = min(columns, lines) >= _FEWEST_LINES and columns * lines <= _MOST_CELLS
    return exact if is_grid else exact.iloc[:0]


def grid_of(rows: pd.DataFrame, column: str) -> tuple[NDArray[np.float64], ...]:
    """x of shape (n,), y of shape (m,) and the column's values of shape (m, n); NaN where none."""
    table = rows.pivot_table(index="target_y", columns="target_x", values=column, aggfunc="first")
    x = table.columns.to_numpy(dtype=np.float64)
    y = table.index.to_numpy(dtype=np.float64)
    return x, y, table.to_numpy(dtype=np.float64)


def along_circle(rows: pd.DataFrame) -> pd.DataFrame:
    """Targets within one grid step of a turning circle, by where on it they lie.

    Columns: angle (arc angle from the start to there, deg), side (`inside`, `outside`), length.
    """
    xs = np.sort(rows["target_x"].unique())
    near = rows[rows["margin"] <= np.diff(xs).min()]
    angle = np.arctan2(near["target_x"], 1 - near["target_y"].abs())
    disc = near["region"].isin(["left disc", "right disc"])
    return pd.DataFrame(
        {
            "angle": np.degrees(angle) % 360,
            "side": np.where(disc, "inside", "outside"),
            "length": near["length"],
        }
    ).sort_values("angle")
