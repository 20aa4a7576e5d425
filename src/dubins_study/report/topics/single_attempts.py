"""The section of single attempts.

It has a plot from which to choose an attempt, the attempt's path, and the worst attempts of each
solver. The page embeds a sample as JSON: the worst attempts of each solver, and some of every
stratum.
"""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from dubins_study.report.data.attempts import PRESOLVED, SUCCESSES, own_name
from dubins_study.report.data.command import ROUTE
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import General, Section, Topic, Widget
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette, names_of
from dubins_study.report.elements.style import VARIABLES
from dubins_study.study.rows.schema import MEASURED_TIMES, METHOD, ROW, names
from dubins_study.study.scenario import DEFAULTS, NUMBERS

# The embedded attempts take at most this many bytes of the page, as base64 of gzip. More points
# than these would also be slow to draw.
_MOST_BYTES = 1_500_000
_SIZES = (30_000, 20_000, 10_000, 3_000, 1_000)
_BASE64 = 4 / 3

# Marker of a figure -> marker of Bokeh, and the angle of its rotation (rad, counter-clockwise).
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


# The error message for the page's address; a script writes it.
_PROBLEM = '<p class="bad" id="attempt-problem" role="status"></p>'


def attempts_section(results: Results) -> Section | None:
    """The section on single attempts.

    Each embedded attempt is a point. The point leads to the attempt's path and to the command that
    repeats it.
    """
    rows, content = _fitting(results)
    libraries = {name: _library(name) for name in ("bokeh", "bokeh-api")}
    scripts = '<p class="unscripted">This part needs scripts; the page holds them itself.</p>'
    widgets = (
        Widget(
            "worst",
            f"The {WORST} worst wrong attempts of a solver, at different questions: false claims "
            "first, then longer paths, then paths that miss the target, then no path. Solid: the "
            "solver's path; dashed: the shortest path, or on a route a right answer.",
            Markup(scripts + '<div id="attempts-worst"></div>'),
        ),
        Widget(
            "attempts",
            "Each point is one attempt. At most ten solvers have a colour, with their engine's "
            "colour and marker. Solvers of one engine differ in the fill of the marker.",
            Markup(scripts + _PROBLEM + '<div id="attempts-plot"></div>'),
            packed=libraries | {"attempts": content},
        ),
    )
    lead = "Choose a solver. Click an attempt to see its path and the command that repeats it."
    return Section("attempts", "Single attempts", _text(rows, results), widgets, lead)


def _text(rows: pd.DataFrame, results: Results) -> str:
    embedded = len(rows)
    total = len(results.rows)
    if embedded == total:
        return f"All {count(total)} attempts are shown."
    return (
        f"{count(embedded)} of the {count(total)} attempts are shown: the {WORST} worst of each "
        "solver, and a random sample for every solver, region and verdict. The sample has the same "
        "scenarios for all solvers where possible."
    )


def _fitting(results: Results) -> tuple[pd.DataFrame, bytes]:
    """The largest sample that fits, and its JSON.

    It fits if the compressed JSON has at most `_MOST_BYTES`. If none fits, the smallest sample
    comes back.
    """
    for most in _SIZES:
        rows = sample(results, most)
        content = packed(rows, {"solvers": _solvers(rows["solver"], results)})
        if _BASE64 * len(gzip.compress(content, 6)) <= _MOST_BYTES:
            break
    return rows, content


def _solvers(specs: Iterable[str], results: Results) -> list[dict[str, Any]]:
    """The names and marks of solvers.

    They are sorted by spec: the codes in the packed attempts are their places.
    """
    names = names_of(results)
    palette = Palette.of_page(results)
    solvers = []
    for spec in sorted(set(specs)):
        row = names.loc[spec]
        colour, marker = palette.hues[palette.engines[spec]]
        shape, angle = _MARKERS.get(marker, _MARKERS["o"])
        mark = {"colour": VARIABLES.get(colour, "--ink"), "marker": shape, "angle": angle}
        method = {name: str(row[name]) for name in ("label", "formulation", "engine")}
        solvers.append({"spec": spec, "own": bool(own_name(spec))} | method | mark)
    return solvers


@cache
def _library(name: str) -> bytes:
    """A script of the installed Bokeh.

    It is located without importing the package.
    """
    spec = find_spec("bokeh")
    if spec is None or spec.origin is None:  # a dependency: only a broken installation lacks it
        raise FileNotFoundError("package bokeh is not installed; install dubins-study again")
    scripts = FilePath(spec.origin).parent / "server" / "static" / "js"
    return (scripts / f"{name}.min.js").read_bytes()


# Wrong attempts of each solver that are always embedded.
WORST = 10

_KINDS = {"string": "text", "bool": "flag"}
_PLOTTED = {c.name: _KINDS.get(c.type, "number") for c in ROW if c.plotted}
TEXTS = ("experiment", *(name for name, kind in _PLOTTED.items() if kind == "text"))
MEASURED = tuple(name for name, kind in _PLOTTED.items() if kind == "number")
FLAGS = tuple(name for name, kind in _PLOTTED.items() if kind == "flag")

_QUESTION = ["solver", "scenario_id", "branch", "experiment", "initial_guess", "profile"]
# of verdicts; a false claim has the level 4, whatever else is wrong has 1
_LEVELS = {"longer": 3, "misses": 2, **dict.fromkeys((*SUCCESSES, PRESOLVED), 0)}


def sample(results: Results, most: int) -> pd.DataFrame:
    """The worst attempts of each solver, and others.

    About `most` others are spread over the strata. A stratum is one solver's attempts in one region
    with one verdict. Of each stratum the first attempts by scenario are taken: a scenario's id is a
    hash, so they are a random sample, and two solvers have the same scenarios where possible. Only
    the first repeat of a question is taken.

    Returns:
        Columns: `TEXTS`, `NUMBERS`, `ROUTE`, `MEASURED`, `FLAGS`, repeat, curvatures and lengths
        (arrays), spread (whether it is one of a stratum), worst (rank among the solver's worst, 1
        to `WORST`; 0 for others). Sorted by solver and question.
    """
    names = [*TEXTS, *NUMBERS, *ROUTE, *MEASURED, *FLAGS, *_EXACT, "repeat"]
    rows = results.attempts[names].copy()
    rows.update(results.elsewhere[[name for name in MEASURED_TIMES if name in names]])
    rows = rows.sort_values([*_QUESTION, "repeat"], kind="stable")
    first = rows[rows["repeat"] == 0]
    strata = first.groupby(["solver", "region", "verdict"], dropna=False)
    spread = strata.head(max(1, most // max(1, strata.ngroups))).index
    rows = rows.assign(spread=rows.index.isin(spread), worst=_ranks(rows))
    rows = rows[rows["spread"] | (rows["worst"] > 0)]
    controls = results.controls.select(["curvatures", "lengths"]).take(rows.index.to_numpy())
    return rows.reset_index(drop=True).join(controls.to_pandas())


def _ranks(rows: pd.DataFrame) -> pd.Series[int]:
    """The rank of each row among the worst.

    The rank is 1 for the worst, up to `WORST`, and 0 for all others. Answers that are right have
    none, and a question has at most one row with a rank.

    The order, from the worst: a false claim, a longer path, a path that misses, no path.
    """
    level = rows["verdict"].map(_LEVELS).fillna(1).mask(rows["false_claim"].eq(True), 4)
    sizes = rows[["gap", "curvature_excess"]].assign(miss=rows["miss"] / rows["radius"])
    ranked = rows.assign(level=level, size=sizes.max(axis="columns").fillna(0.0).clip(lower=0.0))
    order = ["level", "size", "scenario_id", "branch", "repeat"]
    worst = ranked.sort_values(order, ascending=[False] * 4 + [True], kind="stable")
    wrong = worst[worst["level"] > 0]
    rank = wrong.drop_duplicates(_QUESTION).groupby("solver", sort=False).cumcount() + 1
    return rank[rank <= WORST].reindex(rows.index, fill_value=0)


_DIGITS = 4  # that are kept of measured numbers; the page shows three
_ARC_DIGITS = 7  # of controls, from which the page draws a path
_EXACT = ("start_heading",)  # with all digits: the page draws a path from it
_OF_SCENARIO = ("scenario_id", "label", "region", "margin", *NUMBERS)
_MEASURED = [name for name in MEASURED if name not in ("evaluations", *_OF_SCENARIO)]
# the header has the parts of a solver once
_CODED = [name for name in TEXTS if name not in (*_OF_SCENARIO, *names(METHOD))]


def packed(rows: pd.DataFrame, more: Mapping[str, Any]) -> bytes:
    """The attempts of `sample` as JSON, in bytes.

    Returns:
        An object with these keys, and those of `more`:

        count: number of attempts.
        columns: column -> a number for each attempt. For a column of texts, the number is a place
            in `texts`, from 1; 0 is null. For `scenario` it is a place in `scenarios`, from 0.
        texts: column -> its distinct texts.
        scenarios: column -> a value for each scenario, with all digits; columns of `ROUTE` only
            where they are not empty.
        paths: the arcs of each attempt (`arcs_of`).
    """
    texts: dict[str, list[str]] = {}
    columns: dict[str, list[Any]] = {}
    for name in _CODED:
        codes, values = pd.factorize(rows[name], sort=True)  # -1 for a missing text
        columns[name] = (codes + 1).tolist()
        texts[name] = [str(value) for value in values]
    for name in _MEASURED:
        columns[name] = [_rounded(value) for value in rows[name].astype("Float64")]
    for name in ("evaluations", *_EXACT):
        columns[name] = [_rounded(value, 17) for value in rows[name].astype("Float64")]
    columns |= {name: rows[name].eq(True).astype(int).tolist() for name in FLAGS}
    columns |= {name: rows[name].tolist() for name in ("repeat", "worst")}
    columns["scenario"], scenarios = _scenarios(rows)
    content: dict[str, Any] = {
        "count": len(rows),
        "texts": texts,
        "columns": columns,
        "scenarios": scenarios,
        "paths": [*map(arcs_of, rows["curvatures"], rows["lengths"], rows["radius"])],
        **more,
    }
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()


def _rounded(value: Any, digits: int = _DIGITS) -> float | str | None:
    """A number rounded to its first digits.

    A missing number is None. JSON has no infinity: it becomes a text that JavaScript reads.
    """
    if pd.isna(value):
        return None
    number = float(f"{value:.{digits}g}")
    if math.isfinite(number):
        return number
    return str(number).replace("inf", "Infinity")


def _scenarios(rows: pd.DataFrame) -> tuple[list[int], dict[str, list[Any]]]:
    """Each row's scenario, by number, and the scenarios.

    The first value has a number for each row: the place of its scenario in the second value, which
    is a table of distinct scenarios: column -> a value for each.
    """
    key = ["scenario_id", *NUMBERS]
    optional = []  # the columns that some scenario fills
    for name in ROUTE:
        filled = rows[name].notna() & rows[name].ne(DEFAULTS[name])
        if filled.any():
            optional.append(name)
    selected = [*_OF_SCENARIO, *optional]
    groups = rows.groupby(key, sort=False, dropna=False)
    # of attempts that are not judged the region is null: the first that is known
    first = groups[[name for name in selected if name not in key]].first()
    table = first.reset_index().astype(object)
    table = table.where(table.notna(), None)
    columns = {name: [*map(_plain, table[name])] for name in selected}
    return groups.ngroup().tolist(), columns


def _plain(value: Any) -> Any:
    """A value that JSON can hold.

    An array becomes a list, with None for NaN.
    """
    if isinstance(value, np.ndarray):
        return [_rounded(number, 17) for number in value]
    return value


def arcs_of(
    curvatures: Sequence[float] | None, lengths: Sequence[float], radius: float
) -> list[list[Any]] | None:
    """Pairs [curvature, length] of a path's arcs, in radii.

    None without a path.
    """
    if curvatures is None or not len(curvatures):
        return None
    return [
        [_rounded(curvature * radius, _ARC_DIGITS), _rounded(length / radius, _ARC_DIGITS)]
        for curvature, length in zip(curvatures, lengths, strict=True)
    ]


TOPIC = Topic("single attempts", attempts_section, General.EVERY)
