"""A small fixed piece of work, timed now and then: it takes as long on a machine at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from time import perf_counter

import numpy as np

# above this a run says so
NOISY = 0.05
_LOOPS, _ARRAYS, _LEAST_OF = 9000, 300, 3


def probe() -> float:
    """Seconds that the work takes in this process: the least of 3, about a millisecond each.

    Half of it is plain Python, half numpy on arrays of a few dozen numbers, as in these solvers.
    """
    return min(_timed() for _ in range(_LEAST_OF))


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


def spread(probes: Sequence[float]) -> float | None:
    """How much the machine's speed varied: from the 5th to the 95th percentile, over the median.

    Args:
        probes: seconds.

    Returns:
        A share, 0.05 for 5 %; None of fewer than 5 probes, which say nothing.
    """
    if len(probes) < 5:
        return None
    low, middle, high = np.percentile(np.asarray(probes, np.float64), [5, 50, 95])
    return float((high - low) / middle) if middle > 0 else None
