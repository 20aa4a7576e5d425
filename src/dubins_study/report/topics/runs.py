"""The section on the runs: what ran, where, and whether the machine's speed was steady."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Mapping, Sequence
from itertools import cycle
from typing import Any

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from dubins_study.report.data.results import Folder, Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import General, Picture, Section, Table, Topic, picture
from dubins_study.report.elements.formats import digits, seconds, share
from dubins_study.report.elements.style import (
    BLUE,
    BROWN,
    GREEN,
    INK,
    PURPLE,
    VERMILION,
    WIDE,
    Style,
)
from dubins_study.study.rows.machine_noise import NOISY, Probe, by_machine
from dubins_study.study.rows.manifest import RunEntry

COLUMNS = (
    *("experiment", "run", "started", "seconds", "state", "engine", "jobs"),
    *("machine", "governor", "load", "probes", "spread"),
)


def runs(folders: Iterable[Folder]) -> pd.DataFrame:
    """One row per run, in the folders' order; the columns are `COLUMNS`.

    The load is that of the last minute, at the run's start and its end; probes is a list of
    `study.rows.machine_noise.Probe`, spread a share. Unknown seconds or spread are NaN.
    """
    rows = [_row(folder.name, run) for folder in folders for run in folder.manifest.runs]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def probe_ratios(table: pd.DataFrame) -> pd.DataFrame:
    """The calibration probe's durations in each run of `runs`, relative to the run's median.

    For a run on several machines, only the machine that varied most. One row per probe, or per
    `MOST_MARKS`-th of the run's length if it has more probes than that: name (experiment, run, and
    machine if there are several), when (s), ratio (of the median probe), low and high.
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
        "spread": float("nan") if run.spread is None else run.spread,
    }


def _machine(machine: Mapping[str, Any]) -> str:
    texts = [str(machine[key]) for key in ("processor", "system", "memory") if key in machine]
    if "cores" in machine:
        texts.append(f"{machine.get('usable_cores', machine['cores'])} of {machine['cores']} cores")
    return ", ".join(texts)


def _load(averages: Sequence[float] | None) -> str:
    """The average over the last minute."""
    return f"{averages[0]:.2f}" if averages else "?"


_MOST_DRAWN = 6


def runs_section(results: Results) -> Section | None:
    """The table of runs; the probe's durations and a sentence for each run that varied."""
    frame = runs(results.folders)
    if frame.empty:
        return None
    noisy = frame[frame["spread"] > NOISY]
    text = (
        "While a run goes on, a small fixed piece of work is timed in its worker processes every "
        "couple of seconds. How much that varied, from its 5th to its 95th percentile over the "
        "median, bounds what differences in time mean. "
    )
    blocks: tuple[Picture | Table, ...] = (_table(frame),)
    if len(noisy):
        blocks = (*blocks, _picture(noisy.head(_MOST_DRAWN)))
        text += " ".join(_sentence(row) for row in noisy.to_dict("records"))
    elif frame["spread"].notna().any():
        text += f"No run varied by more than {share(NOISY)}."
    else:
        text += "No run here was long enough to tell."
    lead = "Look here, before you quote a time, whether the machine that took it was steady."
    return Section("runs", "The runs and their machines", text, blocks, lead)


def _sentence(run: Mapping[Hashable, Any]) -> str:
    return (
        f"Run {run['run']} of {run['experiment']} varied by {share(run['spread'])}: its machine "
        "was not quiet, and times of it that differ by less say nothing."
    )


def _table(frame: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="code", experiment="experiment", run="run"),
        *columns(_minute, kind="text", started="started (UTC)"),
        *columns(seconds, seconds="took"),
        *columns(kind="text", state="state", engine="engine"),
        *columns(jobs="jobs"),
        *columns(share, spread="varied by"),
        *columns(kind="text", load="load"),
        *columns(kind="prose", where="machine"),
    )
    where = frame["machine"] + "; governor " + frame["governor"]
    caption = (
        "Every run that wrote into these folders. Load is how many processes wanted a core in the "
        "last minute, at the start and at the end; the governor sets the cores' clock; varied by "
        f"more than {share(NOISY)} is marked."
    )
    noisy = marks(frame[["spread"]] > NOISY, "spread")
    return Table("runs", caption, frame.assign(where=where), shown, noisy)


def _minute(started: Any) -> str:
    """A time in ISO 8601 as `2026-01-31 12:34`; any other text is returned unchanged."""
    match = re.fullmatch(r"(\d{4}-\d\d-\d\d)T(\d\d:\d\d)[\d:.+Z]*", str(started))
    return f"{match[1]} {match[2]}" if match else str(started)


def _picture(noisy: pd.DataFrame) -> Picture:
    return picture(
        "probes",
        plot_probes,
        probe_ratios(noisy),
        legend=3,
        caption="The calibration probe in the runs that varied most, relative to its median: 1 is "
        "the usual speed, above is slower. A mark is a probe, or the median of those in a "
        f"{MOST_MARKS}th of a long run, with a bar from the fastest to the slowest; the band is "
        f"{digits(1)(100 * NOISY)} % wide.",
        alt="Probe times against time, marks of each run",
        height=2.6,
        width=WIDE,
    )


# Of at most `_MOST_DRAWN` runs: hues that differ in lightness, and markers.
_MARKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (BROWN, "D"), (PURPLE, "v"), (INK, "x"))


def plot_probes(ax: Axes, ratios: pd.DataFrame) -> list[Artist]:
    """Draw the `probe_ratios` against time; returns the legend's entries.

    Nothing joins the marks: between them nobody measured.
    """
    entries: list[Artist] = []
    groups = ratios.groupby("name", sort=False)
    for (name, group), (colour, marker) in zip(groups, cycle(_MARKS)):
        ax.vlines(group["when"], group["low"], group["high"], color=colour, lw=0.7, alpha=0.6)
        dots: Style = {"color": colour, "marker": marker, "linestyle": "none", "markersize": 3}
        entries += ax.plot(group["when"], group["ratio"], label=str(name), **dots)
    ax.axhspan(1 - NOISY / 2, 1 + NOISY / 2, color=BLUE, alpha=0.15, lw=0)
    ax.set(xlabel="time since the run began (s)", ylabel="probe / its median")
    return entries


TOPIC = Topic("the runs and their machines", runs_section, General.EVERY)
