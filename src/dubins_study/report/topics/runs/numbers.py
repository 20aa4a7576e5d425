"""The runs behind the rows: where, how long, and how steady the machine was."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.load import Manifest
from dubins_study.study.rows.machine_noise import Probe, by_machine, is_number, probes_of, varied

COLUMNS = (
    *("experiment", "run", "started", "seconds", "state", "engine", "jobs"),
    *("machine", "governor", "load", "probes", "spread"),
)


def runs(manifests: Iterable[Manifest]) -> pd.DataFrame:
    """One row a run, in the manifests' order.

    Returns:
        Columns experiment, run, started, seconds (NaN if it does not say), state, engine, jobs,
        machine and governor (texts), load (of the last minute, at its start and its end), probes
        (a list as `study.rows.machine_noise.probes_of` has it), spread (a share, NaN if unknown).
    """
    rows = [_row(manifest, entry) for manifest in manifests for entry in manifest.runs]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def probe_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """What the calibration probe took in each run of `runs`, relative to its median there.

    Of a run on several machines, the one that varied most.

    Returns:
        Columns run (with the machine's name if there are several), when (s), ratio.
    """
    parts = []
    for run, probes in zip(table["run"], table["probes"], strict=True):
        machine, own = next(iter(by_machine(probes).items()))
        frame = pd.DataFrame(own, columns=list(Probe._fields))
        name = str(run)[:24] + (f", machine {machine}" if machine else "")
        ratio = frame["took"] / frame["took"].median()
        parts.append(pd.DataFrame({"run": name, "when": frame["when"], "ratio": ratio}))
    return pd.concat(parts, ignore_index=True)


def _row(manifest: Manifest, entry: Mapping[str, Any]) -> dict[str, Any]:
    probes, jobs = probes_of(entry), entry.get("jobs")
    seconds: Any = entry.get("seconds")
    state = str(entry.get("state", "unknown"))
    share = varied(probes)
    return {
        "experiment": manifest.name,
        "run": str(entry.get("run_id", "")),
        "started": str(entry.get("started", "")),
        "seconds": float(seconds) if is_number(seconds) else float("nan"),
        # a run that is killed cannot say so
        "state": "running, or killed" if state == "running" else state,
        "engine": str(entry.get("engine", "")),
        "jobs": "" if jobs is None else str(jobs),
        "machine": _machine(entry.get("machine")),
        "governor": str(entry.get("governor", "unknown")),
        "load": f"{_load(entry.get('load_start'))} to {_load(entry.get('load_end'))}",
        "probes": probes,
        "spread": float("nan") if share is None else share,
    }


def _machine(machine: Any) -> str:
    if not isinstance(machine, Mapping):
        return ""
    parts = [str(machine[key]) for key in ("processor", "system", "memory") if key in machine]
    if "cores" in machine:
        parts.append(f"{machine.get('usable_cores', machine['cores'])} of {machine['cores']} cores")
    return ", ".join(parts)


def _load(averages: Any) -> str:
    """The average over the last minute."""
    known = isinstance(averages, list) and averages and is_number(averages[0])
    return f"{averages[0]:.2f}" if known else "?"
