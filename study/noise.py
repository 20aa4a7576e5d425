"""How steady a machine was while a run was going on, from a small piece of work timed now and then.

`experiments.calibration` times it; a run's entry in the manifest holds what it took.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

# a run whose speed varied by more says so
NOISY = 0.05
_FEWEST = 5


def spread(probes: Sequence[float]) -> float | None:
    """How much the machine's speed varied: from the 5th to the 95th percentile, over the median.

    Args:
        probes: seconds, above 0.

    Returns:
        A share, 0.05 for 5 %; None of fewer than 5 probes, which say nothing.
    """
    if len(probes) < _FEWEST:
        return None
    low, middle, high = np.percentile(np.asarray(probes, np.float64), [5, 50, 95])
    return float((high - low) / middle)


def probes_of(entry: Mapping[str, Any]) -> list[tuple[float, float]]:
    """The probes of a run's entry in a manifest, whoever wrote that.

    Returns:
        (seconds since the run began, seconds that the work took), as they were made.
    """
    listed = entry.get("probes")
    pairs = [pair for pair in listed if _is_pair(pair)] if isinstance(listed, list) else []
    return [(float(when), float(took)) for when, took in pairs if when >= 0 and took > 0]


def _is_pair(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(is_number, value))


def is_number(value: Any) -> bool:
    """Whether a value from outside is a number that can be reckoned with."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15
