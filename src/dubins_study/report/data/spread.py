"""How often each value occurs: quantiles of any number of rows, counted part by part."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# up to so many different values are kept as they are
MOST_EXACT = 2**16
# bits of the mantissa that are kept of more
BITS = 12
# relative: a value counts as the middle of the values that share its kept bits
ERROR = 2.0 ** -(BITS + 1)

_DROPPED = np.int64(52 - BITS)
_MIDDLE = np.int64(1) << np.int64(52 - BITS - 1)


@dataclass(frozen=True, eq=False)
class Spread:
    """Values and how often each occurs.

    Exact up to `MOST_EXACT` different values; of more, each is replaced by one that is off by at
    most `ERROR` of it. Zero, infinity, the least and the largest stay exact. Whatever the parts
    and their order, merging them gives the same as counting all at once.

    Args:
        values: different, ascending, shape (m,).
        counts: how often each occurs, shape (m,).
        least, largest: exact; NaN if there is nothing.
        cut: whether the values are not exact.
    """

    values: FloatArray
    counts: IntArray
    least: float = float("nan")
    largest: float = float("nan")
    cut: bool = False

    @classmethod
    def of(cls, values: ArrayLike) -> Self:
        """Count values of any shape; NaN is left out."""
        given = np.asarray(values, dtype=np.float64).ravel()
        kept, counts = np.unique(given[~np.isnan(given)] + 0.0, return_counts=True)
        return cls._bounded(kept, counts.astype(np.int64), kept[:1], kept[-1:], False)

    @classmethod
    def merged(cls, spreads: Iterable[Self]) -> Self:
        """All of them counted together."""
        given = list(spreads)
        if len(given) == 1:
            return given[0]
        cut = any(spread.cut for spread in given)
        values = [_cut(spread.values) if cut else spread.values for spread in given]
        counts = np.concatenate([np.empty(0, np.int64), *(spread.counts for spread in given)])
        least = np.array([spread.least for spread in given if spread.counts.size])
        largest = np.array([spread.largest for spread in given if spread.counts.size])
        joined = _joined(np.concatenate([np.empty(0), *values]), counts)
        return cls._bounded(*joined, np.sort(least), np.sort(largest), cut)

    @classmethod
    def _bounded(
        cls,
        values: FloatArray,
        counts: IntArray,
        least: FloatArray,
        largest: FloatArray,
        cut: bool,
    ) -> Self:
        if values.size > MOST_EXACT and not cut:
            values, counts = _joined(_cut(values), counts)
            cut = True
        ends = (float(least[0]), float(largest[-1])) if values.size else (np.nan, np.nan)
        return cls(values, counts, *ends, cut)

    @property
    def size(self) -> int:
        """How many values were counted."""
        return int(self.counts.sum())

    @property
    def finite(self) -> int:
        """How many of them are finite."""
        return int(self.counts[np.isfinite(self.values)].sum())

    def upper(self, q: float) -> float:
        """The least value that a share `q` of all does not exceed; no interpolation.

        Interpolating towards an infinite gap would make every quantile infinite.
        """
        place = int(np.ceil(q * self.size - 1e-9)) - 1
        return self._at(max(0, place))

    def quantile(self, q: float) -> float:
        """Between two neighbours in proportion, as numpy and pandas do by default."""
        at = (self.size - 1) * q
        low = self._at(int(np.floor(at)))
        high = self._at(int(np.ceil(at)))
        return low if low == high else low + (high - low) * (at - np.floor(at))

    @property
    def median(self) -> float:
        return (self._at((self.size - 1) // 2) + self._at(self.size // 2)) / 2

    def shares(self) -> tuple[FloatArray, FloatArray]:
        """Finite values and the share of all that each of them is not below; both shape (m,)."""
        finite = np.isfinite(self.values)
        return self.values[finite], np.cumsum(self.counts)[finite] / max(1, self.size)

    def _at(self, place: int) -> float:
        """The value at a place counted from 0 in ascending order; NaN if there is nothing."""
        if not self.counts.size:
            return float("nan")
        if place <= 0:
            return self.least
        if place >= self.size - 1:
            return self.largest
        index = np.searchsorted(np.cumsum(self.counts), place, side="right")
        return float(self.values[index])


def _cut(values: FloatArray) -> FloatArray:
    """Values with the last bits of their mantissas set to the middle; its own fixed point."""
    bits = np.ascontiguousarray(values).view(np.int64)
    middle = ((bits >> _DROPPED << _DROPPED) | _MIDDLE).view(np.float64)
    return np.where(np.isfinite(values) & (values != 0), middle, values)


def _joined(values: FloatArray, counts: IntArray) -> tuple[FloatArray, IntArray]:
    """Equal values counted together."""
    kept, place = np.unique(values, return_inverse=True)
    summed = np.zeros(kept.size, np.int64)
    np.add.at(summed, place, counts)
    return kept, summed
