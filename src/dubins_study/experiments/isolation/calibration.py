"""A small fixed piece of work, timed now and then: it takes as long on a machine at rest."""

from __future__ import annotations

import math
from time import perf_counter

import numpy as np

_LOOPS, _ARRAYS, _REPEATS = 9000, 300, 3


def probe() -> float:
    """Seconds that the work takes in this process: the least of 3, about a millisecond each.

    Half of it is plain Python, half numpy on arrays of a few dozen numbers, as in these solvers.
    """
    return min(_timed() for _ in range(_REPEATS))


def _timed() -> float:
    matrix = np.linspace(0.0, 1.0, 36 * 36).reshape(36, 36)
    vector = np.linspace(-1.0, 1.0, 36)
    began = perf_counter()
    total = 0.0
    for i in range(_LOOPS):
        total += math.sin(i) * 0.5
    for _ in range(_ARRAYS):
        vector = matrix @ vector
        vector /= float(np.abs(vector).max()) or 1.0
    return perf_counter() - began
