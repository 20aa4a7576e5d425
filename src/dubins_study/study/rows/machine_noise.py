"""How steady a machine was during a run, from a small piece of work timed now and then.

`experiments.isolation.worker` times the work; the run's entry in the manifest holds the times.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

# A run whose speed varied by more is reported as noisy.
NOISY = 0.05
_MIN_PROBES = 5
_MAX_S = 1e15


class Probe(NamedTuple):
    """One measurement of a machine's speed: seconds since the run began, and seconds it took."""

    when: Annotated[float, Field(ge=0, le=_MAX_S)]
    took: Annotated[float, Field(gt=0, le=_MAX_S)]
    machine: int = 0  # which of several machines, from 1; 0 where there is only one


def spread(probes: Sequence[float]) -> float | None:
    """How much a machine's speed varied: from the 5th to the 95th percentile, over the median.

    Of probes in seconds, a share: 0.05 for 5 %; None of fewer than 5 probes, which say nothing.
    """
    if len(probes) < _MIN_PROBES:
        return None
    low, middle, high = np.percentile(np.asarray(probes, np.float64), [5, 50, 95])
    return float((high - low) / middle)


def by_machine(probes: Sequence[Probe]) -> dict[int, list[Probe]]:
    """The probes of each machine: the machine that varied most first, those of few probes last."""
    machines: dict[int, list[Probe]] = {}
    for probe in probes:
        machines.setdefault(probe.machine, []).append(probe)

    def share(machine: int) -> float:
        return -1.0 if (value := _spread(machines[machine])) is None else value

    return {machine: machines[machine] for machine in sorted(machines, key=share, reverse=True)}


def varied(probes: Sequence[Probe]) -> float | None:
    """The spread of the machine that varied most; None if no machine has enough probes."""
    return next(map(_spread, by_machine(probes).values()), None)


def _spread(probes: Sequence[Probe]) -> float | None:
    return spread([probe.took for probe in probes])
