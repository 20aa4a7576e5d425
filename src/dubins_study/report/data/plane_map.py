"""Counts of shortest paths in square cells of the target plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Reach of the map in radii from the start, in the vehicle's frame; number of cells per axis.
REACH, CELLS = 4.0, 160
WORDS = ("LS", "RS", "RL", "LR", "others")


@dataclass(frozen=True, eq=False)
class PlaneMap:
    """Shortest paths, counted by their target in the vehicle's frame, in radii.

    Args:
        counts: number of attempts by word, Y and X; shape (words, cells, cells).
        least, largest: smallest and largest length / R per cell, shape (cells, cells); +infinity
            and -infinity in an empty cell.
    """

    counts: NDArray[np.int64]
    least: FloatArray
    largest: FloatArray

    @classmethod
    def of(cls, cells: pd.DataFrame) -> Self:
        """Build the map from rows; each row counts the answers of one word in one cell.

        Columns: word, ahead and left (index of the cell from 0, along the vehicle's heading and to
        its left), attempts, least and largest (length / radius).
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
        """Centres of the cells along either axis, in radii; shape (cells,)."""
        width = 2 * REACH / CELLS
        return np.linspace(-REACH + width / 2, REACH - width / 2, CELLS)
