"""How much slower the machine of one run was than that of another."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.statistics.intervals import bootstrap, medians


class MachineSpeed(NamedTuple):
    """How many times as long the same work took in the new run; 2: a machine half as fast.

    `ratio`, the range from `low` to `high` that it may have, and `evidence`: what says so.
    """

    ratio: float
    low: float
    high: float
    evidence: str


_FEWEST = 5  # probes of a run: the median of fewer has no interval worth the name


def unchanged_solvers(base: Results, new: Results) -> list[str]:
    """The solvers whose code, settings and packages are the same in both runs."""
    before, after = (results.folders[0].manifest.code_digests for results in (base, new))
    return [spec for spec, digest in before.items() if after.get(spec) == digest]


def machine_speed(
    base: Results, new: Results, ratios: pd.DataFrame, unchanged: Collection[str]
) -> MachineSpeed | None:
    """The machine's speed, from solvers that cannot have changed, else from calibration probes.

    A solver of the same code took as many times as long as its machine did: the geometric mean of
    their ratios, and the range of their intervals, since a load slows some work more than other.
    The probe, a short piece of work that is timed every two seconds, notices less of a load; it
    stands in where no solver is unchanged: the medians' ratio, the ends of their 95 % intervals
    divided crosswise.

    Args:
        base, new: the runs.
        ratios: indexed by solver; columns estimate, low, high: time in the new run by the base's.
        unchanged: the solvers of the same code.
    Returns:
        None if no solver is unchanged and a run has fewer than five probes.
    """
    known = ratios[ratios.index.isin(list(unchanged))].dropna()
    known = known[(known.gt(0) & known.lt(np.inf)).all(axis=1)]
    if len(known):
        mean = float(np.exp(np.log(known["estimate"]).mean()))
        low, high = float(known["low"].min()), float(known["high"].max())
        plural = "" if len(known) == 1 else "s"
        return MachineSpeed(mean, low, high, f"{len(known)} solver{plural} of the same code")
    return _from_probes(base, new)


def _from_probes(base: Results, new: Results) -> MachineSpeed | None:
    took = [_probe_seconds(results) for results in (base, new)]
    if min(map(len, took)) < _FEWEST:
        return None
    before, after = (bootstrap(pd.DataFrame({"probe": each}), medians).iloc[0] for each in took)
    return MachineSpeed(
        float(after["estimate"] / before["estimate"]),
        float(after["low"] / before["high"]),
        float(after["high"] / before["low"]),
        f"{len(took[0])} and {len(took[1])} calibration probes",
    )


def _probe_seconds(results: Results) -> list[float]:
    runs = [run for folder in results.folders for run in folder.manifest.runs]
    return [probe.took for run in runs for probe in run.probes]
