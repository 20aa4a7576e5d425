"""How steady a machine was while a run was going on, from a small piece of work timed now and then.

`experiments.engines.calibration` times it; a run's entry in the manifest holds what it took.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

# a run whose speed varied by more says so
NOISY = 0.05
_FEWEST = 5


class Probe(NamedTuple):
    """One look at how fast a machine is.

    Args:
        when: seconds since the run began.
        took: seconds that the work took.
        machine: which of several it was, from 1; 0 where there is but one.
    """

    when: float
    took: float
    machine: int = 0


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


def by_machine(probes: Sequence[Probe]) -> dict[int, list[Probe]]:
    """The probes of each machine, the one that varied most first; those of few probes last."""
    found: dict[int, list[Probe]] = {}
    for probe in probes:
        found.setdefault(probe.machine, []).append(probe)
    shares = {machine: _varied(own) for machine, own in found.items()}
    order = sorted(found, key=lambda one: -1.0 if (v := shares[one]) is None else v, reverse=True)
    return {machine: found[machine] for machine in order}


def varied(probes: Sequence[Probe]) -> float | None:
    """The spread of the machine that varied most: machines are not compared with each other.

    Returns:
        As `spread`; None if no machine has enough probes.
    """
    return next(map(_varied, by_machine(probes).values()), None)


def _varied(probes: Sequence[Probe]) -> float | None:
    return spread([probe.took for probe in probes])


def probes_of(entry: Mapping[str, Any]) -> list[Probe]:
    """The probes of a run's entry in a manifest, whoever wrote that, as they were made."""
    listed = entry.get("probes")
    known = [held for held in listed if _is_probe(held)] if isinstance(listed, list) else []
    found = [Probe(float(held[0]), float(held[1]), *map(int, held[2:])) for held in known]
    return [probe for probe in found if probe.when >= 0 and probe.took > 0]


def _is_probe(value: Any) -> bool:
    return isinstance(value, list) and len(value) in (2, 3) and all(map(is_number, value))


def is_number(value: Any) -> bool:
    """Whether a value from outside is a number that can be reckoned with."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e15
