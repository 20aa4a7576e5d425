"""What two runs differ in besides their answers: the machine's speed, limits, packages, code."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.statistics.intervals import bootstrap, medians
from dubins_study.study.rows.manifest import Manifest


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
    divided crosswise. None if no solver is unchanged and a run has fewer than five probes.
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


_NOTHING = "–"


def differences(base: Results, new: Results) -> pd.DataFrame:
    """What the manifests of two runs do not share: what, base, new (as text), and solvers.

    `solvers` is how many of the solvers in both runs it is about; NaN if it is about the run.
    """
    sides = [results.folders[0].manifest for results in (base, new)]
    lines = [*_of_runs(*sides), *_of_solvers(*sides)]
    return pd.DataFrame(lines, columns=["what", "base", "new", "solvers"])


def _of_runs(base: Manifest, new: Manifest) -> Iterator[tuple[str, str, str, float]]:
    plain = ("profile", "time_limit_s", "memory_limit_gib", "gap_tolerance")
    before, after = (
        {name.replace("_", " "): getattr(each, name) for name in plain}
        | {f"machine: {key}": value for key, value in each.machine.items()}
        | {f"version of {key}": value for key, value in each.versions.items()}
        | {"git commit": each.git.get("commit"), "jobs": _jobs(each)}
        for each in (base, new)
    )
    for what in dict.fromkeys([*before, *after]):
        if before.get(what) != after.get(what):
            yield what, _text(before.get(what)), _text(after.get(what)), float("nan")


def _jobs(manifest: Manifest) -> str:
    return ", ".join(map(str, sorted({run.jobs for run in manifest.runs})))


def _of_solvers(base: Manifest, new: Manifest) -> Iterator[tuple[str, str, str, float]]:
    """Packages with their versions, one line each; code and settings, one line for all solvers."""
    both = [spec for spec in base.solvers if spec in new.solvers]
    changed: dict[tuple[str, str, str], int] = {}
    for spec in both:
        before, after = base.solvers[spec], new.solvers[spec]
        pairs = [
            (f"package {name}", before.packages.get(name), after.packages.get(name))
            for name in dict.fromkeys([*before.packages, *after.packages])
        ]
        if before.settings != after.settings:
            pairs.append((f"settings of {spec}", before.settings, after.settings))
        for what, old, newer in pairs:
            if old != newer:
                line = (what, _text(old), _text(newer))
                changed[line] = changed.get(line, 0) + 1
    for line, number in changed.items():
        yield *line, float(number)
    code = sum(base.solvers[spec].code_digest != new.solvers[spec].code_digest for spec in both)
    if code:
        yield "code of solvers, settings or packages", "one digest", "another", float(code)


def _text(value: Any) -> str:
    return _NOTHING if value is None or value == "" else str(value)
