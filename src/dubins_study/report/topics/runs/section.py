"""What ran, where, and whether the machine was quiet enough for the times to be quoted."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    digits,
    seconds,
    share,
)
from dubins_study.report.elements.style import WIDE, new_figure
from dubins_study.report.topics.runs.figures import plot_probes
from dubins_study.report.topics.runs.numbers import probe_ratios, runs
from dubins_study.study.rows.machine_noise import NOISY

_MOST_DRAWN = 6


def runs_section(results: Results) -> Section | None:
    """The runs' table; what the calibration probe took, where it varied; a sentence of each."""
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
    return Section("runs", "The runs and their machines", text, blocks)


def _sentence(run: Mapping[Hashable, Any]) -> str:
    return (
        f"Run {run['run']} of {run['experiment']} varied by {share(run['spread'])}: its machine "
        "was not quiet, and times of it that differ by less say nothing."
    )


def _table(frame: pd.DataFrame) -> Table:
    columns = (
        Column("experiment", "experiment", kind="code"),
        Column("run", "run", kind="code"),
        Column("started", "started (UTC)", _minute, kind="text"),
        Column("seconds", "took", seconds),
        Column("state", "state", kind="text"),
        Column("engine", "engine", kind="text"),
        Column("jobs", "jobs"),
        Column("spread", "varied by", share),
        Column("load", "load", kind="text"),
        Column("where", "machine", kind="prose"),
    )
    where = frame["machine"] + "; governor " + frame["governor"]
    caption = (
        "Every run that wrote into these folders. Load is how many processes wanted a core in the "
        "last minute, at the start and at the end; the governor sets the cores' clock; varied by "
        f"more than {share(NOISY)} is marked."
    )
    rows = enumerate(frame["spread"])
    marks = {(place, "spread"): "bad" for place, varied in rows if varied > NOISY}
    return Table("runs", caption, frame.drop(columns="probes").assign(where=where), columns, marks)


def _minute(started: Any) -> str:
    """2026-01-31 12:34 of a time as ISO 8601 has it; any other text as it is."""
    match = re.fullmatch(r"(\d{4}-\d\d-\d\d)T(\d\d:\d\d)[\d:.+Z]*", str(started))
    return f"{match[1]} {match[2]}" if match else str(started)


def _picture(noisy: pd.DataFrame) -> Picture:
    figure = new_figure(WIDE, 2.4)
    plot_probes(figure.add_subplot(), probe_ratios(noisy))
    figure.legend(loc="outside right upper", fontsize=7.5)
    caption = (
        "The calibration probe in the runs that varied most, relative to its median: 1 is the "
        f"usual speed, above is slower; the band is {digits(1)(100 * NOISY)} % wide."
    )
    return Picture("probes", caption, figure, "Probe times against time, one line a run")
