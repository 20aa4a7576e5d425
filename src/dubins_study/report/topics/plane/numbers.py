"""The target plane as grids, and the lengths along a turning circle."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.report.data.attempts import EXACT

# Largest number of cells in a grid: scattered targets would give one cell per pair of coordinates.
_MOST_CELLS = 4_000_000
_FEWEST_LINES = 5  # grid lines along x and along y; fewer do not give a map


def exact_answers(rows: pd.DataFrame) -> pd.DataFrame:
    """The closed form's answer to each target; empty if the targets do not form a grid."""
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
    """Targets within one grid step of a turning circle, with their position along the circle.

    Columns: angle (arc angle from the start, deg), side (`inside`, `outside`), length.
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
