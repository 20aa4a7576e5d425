"""The target plane counted in cells: any number of attempts, merged part by part."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.report.data.spread import FloatArray, IntArray

# the map shows targets so many radii around the start, seen from the vehicle, in square cells
REACH, CELLS = 4.0, 160
WORDS = ("LS", "RS", "RL", "LR", "others")
_PLACES = ("x", "y", "heading", "target_x", "target_y", "radius")


@dataclass(frozen=True, eq=False)
class PlaneMap:
    """Shortest paths by their target in the vehicle's frame, in radii.

    Args:
        counts: shape (words, cells, cells): attempts by word, by Y, by X.
        least, largest: shape (cells, cells): of the lengths over R; infinite, or minus infinite,
            where there are none.
    """

    counts: IntArray
    least: FloatArray
    largest: FloatArray

    @classmethod
    def of(cls, rows: pd.DataFrame) -> Self:
        """Count rows with a path: the closed form's answers to the branch best."""
        columns = (rows[name].to_numpy(np.float64) for name in _PLACES)
        x, y, heading, target_x, target_y, radius = columns
        dx, dy = (target_x - x) / radius, (target_y - y) / radius
        cos, sin = np.cos(heading), np.sin(heading)
        ahead, left = _cell(dx * cos + dy * sin), _cell(dy * cos - dx * sin)
        inside = (ahead >= 0) & (ahead < CELLS) & (left >= 0) & (left < CELLS)
        inside &= rows["length"].notna().to_numpy()
        places = (left * CELLS + ahead)[inside]
        lengths = (rows["length"].to_numpy(np.float64) / radius)[inside]
        known = {word: place for place, word in enumerate(WORDS)}
        word = rows["word"].astype(object).map(known).fillna(len(WORDS) - 1).to_numpy(np.int64)
        least, largest = np.full(CELLS**2, np.inf), np.full(CELLS**2, -np.inf)
        np.minimum.at(least, places, lengths)
        np.maximum.at(largest, places, lengths)
        cells = len(WORDS) * CELLS**2
        counts = np.bincount(word[inside] * CELLS**2 + places, minlength=cells).astype(np.int64)
        shape = (CELLS, CELLS)
        return cls(counts.reshape(-1, *shape), least.reshape(shape), largest.reshape(shape))

    @classmethod
    def merged(cls, maps: Iterable[Self]) -> Self:
        """All of them counted together."""
        given = list(maps)
        return cls(
            np.sum([one.counts for one in given], axis=0),
            np.min([one.least for one in given], axis=0),
            np.max([one.largest for one in given], axis=0),
        )

    @property
    def centres(self) -> FloatArray:
        """Of the cells along either axis, shape (cells,)."""
        width = 2 * REACH / CELLS
        return np.linspace(-REACH + width / 2, REACH - width / 2, CELLS)


def _cell(place: FloatArray) -> NDArray[np.int64]:
    cell = np.clip(np.floor((place + REACH) * (CELLS / (2 * REACH))), -1, CELLS)
    cell[np.isnan(cell)] = -1
    return cell.astype(np.int64)
