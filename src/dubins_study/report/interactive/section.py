"""The section of single attempts: a plot to choose from, a path, and the worst of each solver."""

from __future__ import annotations

import gzip
from functools import cache
from importlib.util import find_spec
from pathlib import Path as FilePath

import pandas as pd
from markupsafe import Markup

from dubins_study.report.data.attempts import Attempts
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Section, Widget
from dubins_study.report.elements.formats import count
from dubins_study.report.interactive.packing import Packed, pack
from dubins_study.report.interactive.sample import WORST, long_controls, sample

# The page stays below 5 MB; the embedded attempts take at most so many bytes of it, as base64 of
# gzip. More points than these would also be slow to draw.
_MOST_BYTES, _MOST_POINTS = 1_500_000, 30_000
_FEWEST_POINTS = 1_000
_BASE64 = 4 / 3


def attempts_section(results: Results) -> Section | None:
    """Single attempts: every embedded one as a point, with its path and the command for it."""
    rows, packed = _fitting(results.attempts)
    if not len(rows):
        return None
    libraries = {name: _library(name) for name in ("bokeh", "bokeh-api")}
    body = Markup(
        '<p class="unscripted">The plot, the paths and the list need scripts, which this page '
        'holds itself.</p><div id="attempts-plot"></div>'
    )
    content = {"attempts": packed.arrays, "attempts-header": packed.header}
    widget = Widget("attempts", _caption(), body, packed=libraries | content)
    lead = "Choose solvers and axes, then click a point to see the path behind it."
    return Section("attempts", "Single attempts", _text(rows, results.attempts), (widget,), lead)


def _caption() -> str:
    return "Each point is one attempt."


def _text(rows: pd.DataFrame, attempts: Attempts) -> str:
    shown, every = len(rows), attempts.count
    if shown == every:
        return f"All {count(every)} attempts are shown."
    return (
        f"Shown are {count(shown)} of the {count(every)} attempts: the {WORST} worst of each "
        "solver (false claims first, then longer paths, then paths that miss), and for every "
        "solver, region and verdict the first repeats at the same scenarios, drawn by the hashes "
        "that name them."
    )


def _fitting(attempts: Attempts) -> tuple[pd.DataFrame, Packed]:
    """A sample of attempts that takes no more than `_MOST_BYTES`, or that is of the least size."""
    most = _MOST_POINTS
    while True:
        rows = sample(attempts, most)
        packed = pack(rows, long_controls(attempts, rows))
        size = sum(_BASE64 * len(gzip.compress(each, 6)) for each in packed)
        if size <= _MOST_BYTES or most <= _FEWEST_POINTS:
            return rows, packed
        most = max(_FEWEST_POINTS, int(0.9 * most * _MOST_BYTES / size))


@cache
def _library(name: str) -> bytes:
    """A script of the installed Bokeh, found without importing the package."""
    spec = find_spec("bokeh")
    if spec is None or spec.origin is None:  # a dependency: only a broken installation lacks it
        raise FileNotFoundError("package bokeh is not installed; install dubins-study again")
    scripts = FilePath(spec.origin).parent / "server" / "static" / "js"
    return (scripts / f"{name}.min.js").read_bytes()
