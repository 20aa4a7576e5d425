"""The values that a map of counted attempts shows in each cell."""

from __future__ import annotations

import numpy as np

from dubins_study.report.data.plane_map import FloatArray, PlaneMap


def frequent_words(plane: PlaneMap) -> FloatArray:
    """Index in `WORDS` of each cell's most frequent word, shape (cells, cells); NaN if empty."""
    return np.where(plane.counts.sum(axis=0) > 0, plane.counts.argmax(axis=0), np.nan)


def length_ranges(plane: PlaneMap) -> FloatArray:
    """(Largest - smallest length) / R per cell, shape (cells, cells); NaN below two attempts."""
    known = plane.counts.sum(axis=0) > 1
    empty = np.full(known.shape, np.nan)
    return np.subtract(plane.largest, plane.least, where=known, out=empty)
