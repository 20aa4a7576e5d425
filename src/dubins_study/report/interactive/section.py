"""The section of single attempts: a plot to choose from, a path, and the worst of each solver."""

from __future__ import annotations

import gzip
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path as FilePath
from typing import Any

import pandas as pd
from markupsafe import Markup

from dubins_study.report.data.command import solve_command
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import General, Section, Table, Topic, Widget
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.elements.looks import Palette, names_of
from dubins_study.report.elements.style import VARIABLES
from dubins_study.report.interactive.sample import SCENARIO, WORST, packed, sample

# The page stays below 5 MB; the embedded attempts take at most so many bytes of it, as base64 of
# gzip. More points than these would also be slow to draw.
_MOST_BYTES, _MOST_POINTS = 1_500_000, 30_000
_FEWEST_POINTS = 1_000
_BASE64 = 4 / 3

# Marker of a figure -> marker of Bokeh, and by how much it is turned (rad, counter-clockwise).
_MARKERS = {
    "o": ("circle", 0.0),
    "^": ("triangle", 0.0),
    "s": ("square", 0.0),
    "D": ("diamond", 0.0),
    "v": ("inverted_triangle", 0.0),
    "P": ("plus", 0.0),
    "X": ("plus", 0.7853982),
    "p": ("square_pin", 0.0),
    "*": ("star", 0.0),
    "<": ("triangle", 1.5707963),
    ">": ("triangle", -1.5707963),
    "h": ("hex", 0.0),
}


# What is wrong with the page's address, said when a script writes it there.
_PROBLEM = '<p class="bad" id="attempt-problem" role="status"></p>'


def attempts_section(results: Results) -> Section | None:
    """Single attempts: every embedded one as a point, with its path and the command for it."""
    rows, content = _fitting(results)
    libraries = {name: _library(name) for name in ("bokeh", "bokeh-api")}
    scripts = '<p class="unscripted">This part needs scripts; the page holds them itself.</p>'
    widgets = (
        Widget(
            "worst",
            f"The {WORST} worst attempts of a solver at different questions: false claims first, "
            "then longer paths, then paths that miss the target or turn too sharply, then none. "
            "Solid: the solver's path; dashed: the shortest path.",
            Markup(scripts + '<div id="attempts-worst"></div>'),
        ),
        Widget(
            "attempts",
            "Each point is one attempt. At most ten solvers are coloured, in the colour and with "
            "the marker of their engine; solvers of one engine differ in what fills the marker.",
            Markup(scripts + _PROBLEM + '<div id="attempts-plot"></div>'),
            packed=libraries | {"attempts": content},
        ),
    )
    lead = "Choose a solver, and click an attempt to see its path and the command that repeats it."
    blocks = (*widgets, _worst_table(rows))
    return Section("attempts", "Single attempts", _text(rows, results), blocks, lead)


_WORST_COLUMNS = (
    SOLVER,
    Column("claim", "claim", kind="text"),
    Column("verdict", "verdict", kind="text"),
    *columns(digits(3), gap="gap", miss_R="miss (R)", beyond="too sharp by (1/R)"),
    Column("label", "scenario", kind="text"),
    Column("region", "region", kind="text"),
)


def _worst_table(rows: pd.DataFrame) -> Table:
    """The very worst attempt of each solver; the CSV file also holds its question and command."""
    worst = rows[rows["worst"] == 1]
    frame = worst.assign(
        miss_R=worst["miss"] / worst["radius"],
        beyond=worst["curvature_excess"],
        label=worst["label"].replace("", None),
        command=[solve_command(row) for row in worst.to_dict("records")],
    ).reset_index(drop=True)
    caption = (
        "The worst attempt of each solver; a false claim is red. Gaps are relative to the "
        "reference. The CSV file also holds the questions and the commands that repeat them."
    )
    more = (*SCENARIO, "branch", "false_claim", "command")
    marked = {(row, "verdict"): "bad" for row in frame.index[frame["false_claim"].eq(True)]}
    frame["verdict"] = frame["verdict"].where(
        ~frame["false_claim"].eq(True), frame["verdict"].astype(str) + ": a false claim"
    )
    return Table("worst-attempts", caption, frame, _WORST_COLUMNS, marked, more)


def _text(rows: pd.DataFrame, results: Results) -> str:
    shown, every = len(rows), results.attempts.count
    if shown == every:
        return f"All {count(every)} attempts are shown."
    return (
        f"Shown are {count(shown)} of the {count(every)} attempts: the {WORST} worst of each "
        "solver, and for every solver, region and verdict the first repeats at the same scenarios, "
        "drawn by the hashes that name them."
    )


def _fitting(results: Results) -> tuple[pd.DataFrame, bytes]:
    """A sample of attempts that takes no more than `_MOST_BYTES`, or that is of the least size."""
    most = _MOST_POINTS
    while True:
        rows = sample(results.attempts, most)
        more = {"solvers": _solvers(rows["solver"], results), "time_limits": _time_limits(results)}
        content = packed(rows, more)
        size = _BASE64 * len(gzip.compress(content, 6))
        if size <= _MOST_BYTES or most <= _FEWEST_POINTS:
            return rows, content
        most = max(_FEWEST_POINTS, int(0.9 * most * _MOST_BYTES / size))


def _solvers(specs: Iterable[str], results: Results) -> list[dict[str, Any]]:
    """Names and marks of the solvers, sorted by spec as the packed attempts count them."""
    names, palette = names_of(results), Palette.of_page(results)
    solvers = []
    for spec in sorted(set(specs)):
        row = names.loc[spec]
        colour, marker = palette.hues[palette.engines[spec]]
        shape, angle = _MARKERS.get(marker, _MARKERS["o"])
        mark = {"colour": VARIABLES.get(colour, "--ink"), "marker": shape, "angle": angle}
        method = {name: str(row[name]) for name in ("label", "formulation", "engine")}
        solvers.append({"spec": spec} | method | mark)
    return solvers


def _time_limits(results: Results) -> dict[str, float]:
    """Experiment -> the limit of each solve (s), where the manifest knows it."""
    limits = {folder.name: folder.manifest.time_limit_s for folder in results.folders}
    return {name: limit for name, limit in limits.items() if limit is not None}


@cache
def _library(name: str) -> bytes:
    """A script of the installed Bokeh, found without importing the package."""
    spec = find_spec("bokeh")
    if spec is None or spec.origin is None:  # a dependency: only a broken installation lacks it
        raise FileNotFoundError("package bokeh is not installed; install dubins-study again")
    scripts = FilePath(spec.origin).parent / "server" / "static" / "js"
    return (scripts / f"{name}.min.js").read_bytes()


TOPIC = Topic("single attempts", attempts_section, General.EVERY)
