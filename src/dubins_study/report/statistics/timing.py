"""Means of times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def shifted_geometric_mean(values: Sequence[float], shift: float) -> float:
    """exp(mean(log(t + shift))) - shift, in the unit of the values."""
    logs = np.log(np.asarray(values, dtype=np.float64) + shift)
    return float(np.exp(logs.mean()) - shift)
