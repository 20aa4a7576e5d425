"""The section on the runs: what ran, where, and whether the machine's speed was steady."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from itertools import cycle
from typing import Any

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import Picture, Section, Table, picture
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
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.topics.runs.numbers import MOST_MARKS, probe_ratios, runs
from dubins_study.study.rows.machine_noise import NOISY

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
    """Draw the calibration probe's durations, relative to their median, against time.

    Nothing joins the marks: between them nobody measured.

    Columns of `numbers.probe_ratios`. Returns the legend's entries.
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


TOPIC = Topic("the runs and their machines", runs_section, General.EVERY, counted=True)
