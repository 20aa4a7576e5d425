"""The runs behind the rows: where, how long, and how steady the machine was."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Folder
from dubins_study.study.rows.machine_noise import Probe, by_machine
from dubins_study.study.rows.manifest import RunEntry

COLUMNS = (
    *("experiment", "run", "started", "seconds", "state", "engine", "jobs"),
    *("machine", "governor", "load", "probes", "spread"),
)


def runs(folders: Iterable[Folder]) -> pd.DataFrame:
    """One row per run, in the folders' order.

    Returns:
        Columns experiment, run, started, seconds (NaN if it does not say), state, engine, jobs,
        machine and governor (texts), load (of the last minute, at its start and its end), probes
        (a list of `study.rows.machine_noise.Probe`), spread (a share, NaN if unknown).
    """
    rows = [_row(folder.name, run) for folder in folders for run in folder.manifest.runs]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def probe_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """The calibration probe's durations in each run of `runs`, relative to the run's median.

    For a run on several machines, only the machine that varied most.

    Returns:
        One row per probe, or per `MOST_MARKS`-th of the run's length if it has more probes than
        that: name (experiment, run, and machine if there are several), when (s), ratio (of the
        median probe), low and high (of the fastest and the slowest).
    """
    parts = []
    for line in table.to_dict("records"):
        machine, group = next(iter(by_machine(line["probes"]).items()))
        frame = pd.DataFrame(group, columns=list(Probe._fields))
        frame["ratio"] = frame["took"] / frame["took"].median()
        parts.append(_marks(frame).assign(name=_name(line, machine)))
    return pd.concat(parts, ignore_index=True)


# More marks of a run would run into each other.
MOST_MARKS = 90


def _marks(probes: pd.DataFrame) -> pd.DataFrame:
    if len(probes) > MOST_MARKS:
        width = (probes["when"].max() - probes["when"].min()) / MOST_MARKS
        place = ((probes["when"] - probes["when"].min()) / width).clip(upper=MOST_MARKS - 1)
        groups = probes.groupby(place.astype(int))
    else:
        groups = probes.groupby(probes.index)
    columns = {"when": ("when", "mean"), "ratio": ("ratio", "median")}
    return groups.agg(**columns, low=("ratio", "min"), high=("ratio", "max"))


def _name(line: Mapping[Hashable, Any], machine: int) -> str:
    text = f"{str(line['experiment'])[:24]}, run {str(line['run'])[:24]}"
    return text + (f", machine {machine}" if machine else "")


def _row(experiment: str, run: RunEntry) -> dict[str, Any]:
    share = run.spread
    return {
        "experiment": experiment,
        "run": run.run_id,
        "started": run.started,
        "seconds": float("nan") if run.seconds is None else run.seconds,
        # The entry of a killed run stays `running`.
        "state": "running, or killed" if run.state == "running" else run.state,
        "engine": run.engine,
        "jobs": str(run.jobs),
        "machine": _machine(run.machine),
        "governor": run.governor,
        "load": f"{_load(run.load_start)} to {_load(run.load_end)}",
        "probes": run.probes,
        "spread": float("nan") if share is None else share,
    }


def _machine(machine: Mapping[str, Any]) -> str:
    texts = [str(machine[key]) for key in ("processor", "system", "memory") if key in machine]
    if "cores" in machine:
        texts.append(f"{machine.get('usable_cores', machine['cores'])} of {machine['cores']} cores")
    return ", ".join(texts)


def _load(averages: Sequence[float] | None) -> str:
    """The average over the last minute."""
    return f"{averages[0]:.2f}" if averages else "?"
