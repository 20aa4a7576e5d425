"""The target plane in square cells, as counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The map shows targets up to so many radii from the start, seen from the vehicle.
REACH, CELLS = 4.0, 160
WORDS = ("LS", "RS", "RL", "LR", "others")


@dataclass(frozen=True, eq=False)
class PlaneMap:
    """Shortest paths by their target in the vehicle's frame, in radii.

    Args:
        counts: shape (words, cells, cells): attempts by word, by Y, by X.
        least, largest: shape (cells, cells): of the lengths over R; infinite, or minus infinite,
            where there are none.
    """

    counts: NDArray[np.int64]
    least: FloatArray
    largest: FloatArray

    @classmethod
    def of(cls, cells: pd.DataFrame) -> Self:
        """Sum rows up, of which each counts the answers of one word in one cell.

        Columns: word, ahead and left (the cell's numbers from 0, ahead of the vehicle and to its
        left), attempts, least and largest (length over radius).
        """
        known = {word: place for place, word in enumerate(WORDS)}
        word = cells["word"].map(known).fillna(len(WORDS) - 1).to_numpy(np.int64)
        place = cells["left"].to_numpy(), cells["ahead"].to_numpy()
        counts = np.zeros((len(WORDS), CELLS, CELLS), np.int64)
        least, largest = (np.full((CELLS, CELLS), end) for end in (np.inf, -np.inf))
        np.add.at(counts, (word, *place), cells["attempts"].to_numpy())
        np.minimum.at(least, place, cells["least"].to_numpy())
        np.maximum.at(largest, place, cells["largest"].to_numpy())
        return cls(counts, least, largest)

    @property
    def centres(self) -> FloatArray:
        """Of the cells along either axis, shape (cells,)."""
        width = 2 * REACH / CELLS
        return np.linspace(-REACH + width / 2, REACH - width / 2, CELLS)
