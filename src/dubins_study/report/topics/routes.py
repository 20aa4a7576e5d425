"""The section on routes; the drawing of one route.

The section shows who finds the shortest route as the number of legs increases.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from dubins_study.report.data.attempts import ENOUGH_ASKED, EXACT, TRIAL, is_true, legs_of, own
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    General,
    Picture,
    Place,
    Section,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, sentences, shortened
from dubins_study.report.elements.identity import questions
from dubins_study.report.elements.looks import Look, Names, Palette, in_page_order, short_labels
from dubins_study.report.elements.plots import HIGHEST, Mark, share_curves
from dubins_study.report.elements.style import (
    BLUE,
    HALF,
    INK,
    MAP_PAPER,
    ON_MAP,
    RULE,
    VERMILION,
    WIDE,
    Style,
    log_axis,
    mark_limit,
    new_figure,
)
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import best_methods, methods_of, stratum_order
from dubins_study.report.statistics.metrics import success, upper_quantile
from dubins_study.report.topics.maps import draw_kinds
from dubins_study.report.topics.paper_figures import draw_turning_circle, plot_start_and_target
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.check.verdict import visits_of
from dubins_study.study.path import RIPPLE, Path, outline
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import Order

TITLE = "Routes of many legs"
# The largest median gap of each class -> its mark, from light to dark.
GAPS = {
    1e-6: Mark("up to 1e-6", colour="#eef4f9"),
    1e-4: Mark("up to 1e-4", colour="#cfe2f0"),
    1e-2: Mark("up to 1e-2", colour="#a3c7e0"),
    1e300: Mark("more", colour="#6a9cc4"),
    math.inf: Mark("most do not arrive", colour="#2f4c69"),
}
_APART = 1.3  # times as large, so that the names of two sizes do not touch
_ALL_BUT_SAMPLES = 0.95  # share of the rows; the others may be a sample
_TITLE_CHARS = 13  # of a line of a title
_NARROWEST = 4  # columns of sizes that a panel has room for, at least
_PER_CENT = 10  # questions from which a cell has per cent
_DARK = 3  # classes from this one on carry light text
_LINES = 20  # of more, only the best supported of each formulation and kind of guess


def with_legs(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with columns legs (their number) and right."""
    return rows.assign(legs=legs_of(rows), right=success(rows))


def by_size(rows: pd.DataFrame, size: str = "legs", success: str = "right") -> pd.DataFrame:
    """Successes, gaps and times of each solver by size.

    One row per solver, stratum and size; the size is a column such as the number of legs. Columns:
    solver, label and the size; those of `scenario_shares`, without open routes; left_open (number
    of open routes); gap (median over attempts, infinite if most do not arrive; of an open route an
    upper bound); wall_s (median of all attempts, s).
    """
    cell = ["solver", "label", size]
    groups = rows.fillna({"gap": np.inf}).groupby(cell)
    frame = pd.DataFrame({"wall_s": groups["wall_s"].median()})
    frame["gap"] = groups["gap"].agg(upper_quantile, q=0.5)
    left_open = rows["left_open"]
    frame["left_open"] = rows[left_open].groupby(cell)["scenario_id"].nunique()
    frame = frame.join(scenario_shares(rows[~left_open], by=cell, success=success, scenario=TRIAL))
    return frame.fillna({"successes": 0, "trials": 0, "left_open": 0}).reset_index()


def routes_section(results: Results) -> Section | None:
    """The section on routes.

    It has success and gap by legs and spacing, and times.
    """
    if results.rows.empty:
        return None
    rows = with_legs(results.rows)
    cells = in_page_order(by_size(rows), results)
    strata = stratum_order(results, cells["label"])
    lead = (
        "Each row is a method. To the right routes have more legs; from panel to panel legs are "
        "shorter; fields are points as in practice."
    )
    engines = solver_summary(results.attempts)
    engines = engines[engines["solver"] != EXACT]
    # times are drawn of plug-ins' solvers, the search, and the best method of each formulation
    best = best_methods(engines, ["formulation"])
    timed = {*own(engines["solver"]), EXACT, *best["solver"]}
    blocks = (
        _picture(cells, strata, results, engines, timed),
        _profiles(rows, results, timed),
    )
    return Section("routes", TITLE, _text(rows), blocks, lead)


# The targets of data profiles: gaps of up to 10 to the power of minus these numbers.
TARGETS = (2, 4, 8)
_TIMES = np.geomspace(1e-4, 1e2, 121)  # s, twenty to a decade


def data_profiles(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Data profiles: title of a panel -> table.

    There is a panel for each of `TARGETS`. A table has a row per time (s) and a column per solver,
    the best first. A value is the share of attempts that reached the target within the time.
    Reached is an answer in time whose proven gap is at most the target. Of an open route the gap is
    an upper bound. (Moré and Wild 2009, SIAM J. Optim. 20, with targets of the truth.)
    """
    in_time = rows["wall_s"].mask(is_true(rows["late"]))
    panels = {}
    for power in TARGETS:
        reached = in_time.where(rows["gap"] <= 10.0**-power, np.inf)
        groups = reached.groupby(rows["solver"], observed=True)
        shares = {
            str(name): np.searchsorted(np.sort(times), _TIMES, "right") / len(times)
            for name, times in groups
        }
        best = sorted(shares, key=lambda name: -shares[name][-1])
        panels[f"gap up to 1e-{power}"] = pd.DataFrame(shares, pd.Index(_TIMES, name="s"))[best]
    return panels


def _profiles(rows: pd.DataFrame, results: Results, timed: set[str]) -> Picture:
    """The picture of data profiles of the timed methods."""
    # a sample of easier routes would look better than the whole
    routes_asked = rows.groupby("solver", observed=True)["scenario_id"].nunique()
    whole = routes_asked.index[routes_asked >= ENOUGH_ASKED * routes_asked.max()]
    chosen = rows[rows["solver"].isin(timed.intersection(whole))]
    panels = data_profiles(chosen)
    palette = palette_of(results, short_labels(methods_of(results.rows)))
    return panels_picture(
        "routes-profile",
        "The share of routes that a method answers within a time, for three largest gaps, of "
        "methods that were asked nearly all. Higher: "
        "more routes; further left: faster. An open route counts if its proven interval is narrow "
        "enough.",
        share_curves,
        "Share of routes against time, for three largest gaps",
        panels,
        {str(name): palette.label(str(name)) for name in chosen["solver"].unique()},
        palette,
        "time",
        "share of routes",
    )


def _text(rows: pd.DataFrame) -> str:
    """The section's text.

    It says how many routes are open, and how many attempts the search proves.
    """
    routes = rows.groupby("scenario_id")["left_open"].any()
    left_open = ""
    if routes.any():
        left_open = (
            f"{count(routes.sum())} of {count(len(routes))} routes are open: their shortest length "
            "is not known well enough, and no share counts them."
        )
    proved = ""
    search = rows[rows["solver"] == EXACT]
    closed = search["claim"].eq("optimal") & ~is_true(search["late"])
    if len(closed):
        proved = (
            f"The search with a proof closes {count(closed.sum())} of its {count(len(closed))} "
            "attempts within its limit."
        )
    return sentences(
        "Right: the path passes all points in order, and the check proves that it is within the "
        "tolerance of the shortest. Best supported: the method whose 95 % interval has the highest "
        "lower end.",
        left_open,
        proved,
        second_opinion(rows),
    )


# of a length: the tolerance to which gdip tells words apart
_GDIP_TOLERANCE = 1e-5


def second_opinion(rows: pd.DataFrame) -> str:
    """A sentence that compares an independent program's bounds.

    The bounds are in the file `gdip.csv`, which also says how they were made. The text is empty if
    it has no bound of these routes.
    """
    proven = rows.dropna(subset=["reference_high"]).drop_duplicates("scenario_id")
    with (files(__package__) / "gdip.csv").open(encoding="utf-8") as file:
        bounded = proven.merge(pd.read_csv(file, comment="#"), on="scenario_id")
    if bounded.empty:
        return ""
    high = bounded["reference_high"] / bounded["radius"]
    above = bounded["low"] > high * (1.0 + _GDIP_TOLERANCE)
    below = ((high - bounded["low"]) / high).clip(lower=0.0)
    return (
        "An independent program (gdip, Váňa and Faigl 2020) gives lower bounds of "
        f"{count(len(bounded))} of these routes; {count(above.sum())} of them contradict the "
        f"check. Their median is {digits(2)(below.median())} of a length below the shortest paths."
    )


def _picture(
    cells: pd.DataFrame,
    strata: list[str],
    results: Results,
    engines: pd.DataFrame,
    timed: set[str],
) -> Picture:
    """The picture of success, gap and time.

    It has a map for each stratum, and below it the times of some methods. `engines` is the frame of
    `solver_summary` without the search. Of more than `_LINES` solvers only the best supported are
    shown.
    """
    if cells["solver"].nunique() > _LINES:
        guess_of = results.rows.groupby("solver", observed=True)["guesses"].first()
        kinds = engines.assign(guesses=engines["solver"].map(guess_of).fillna(""))
        shown = {*timed, *best_methods(kinds, ["formulation", "guesses"])["solver"]}
        cells = cells[cells["solver"].isin(shown)]
    return panels_picture(
        "routes",
        "Above: 5/6 means right on five of six routes, 85 on 85 % of ten or more (?: others are "
        "open). Darker: a larger median gap. One row per formulation and guess, with its "
        "best-supported engine. Below: median times of these engines, failures included; dotted: "
        "the limit.",
        plot_sizes,
        "Success, gap and time against the number of legs",
        cells,
        strata,
        timed,
        palette_of(results, short_labels(methods_of(results.rows))),
        usual_limit(results.rows),
    )


def palette_of(results: Results, labels: Names) -> Palette:
    """The page's palette with other names of solvers.

    `labels` tell the methods of these results apart, and the closed form is called the search with
    a proof.
    """
    return replace(Palette.of_page(results), labels={**labels, EXACT: "search with a proof"})


def usual_limit(rows: pd.DataFrame) -> float:
    """The largest usual time limit (s).

    A limit that only a sample of the rows has is not usual. NaN if no limit is stated.
    """
    return float(rows["limit_s"].quantile(_ALL_BUT_SAMPLES, interpolation="lower"))


def plot_sizes(
    cells: pd.DataFrame,
    strata: list[str],
    timed: set[str],
    palette: Palette,
    limit: float,
    *,
    size: str = "legs",
    gaps: Mapping[float, Mark] = GAPS,
    narrow: bool,
) -> Figure:
    """Draw maps of success, and times below, by stratum.

    The strata stand side by side, or one below the other if `narrow`. `cells` is the table of
    `by_size`, and `timed` are the solvers whose times are drawn. `limit` is in s, NaN if there is
    none. `gaps` maps the largest gap of each class to the mark of the class.
    """
    number = len(strata)
    solvers = list(dict.fromkeys(cells["solver"]))
    map_height = 0.14 * len(solvers)
    if narrow:
        heights = (map_height, 1.1)
        gaps_across = 3
        lines_across = 2
        figure = new_figure(HALF, number * (sum(heights) + 0.7) + 1.2)
        panels = figure.subplots(2 * number, height_ratios=heights * number)
        pairs = panels.reshape(number, 2)
    else:
        heights = (map_height, 1.45)
        gaps_across = 5
        lines_across = 3
        figure = new_figure(WIDE, min(HIGHEST, sum(heights) + 1.3))
        counts = cells.groupby("label")[size].nunique()
        panels = figure.subplots(
            2,
            number,
            sharey="row",
            squeeze=False,
            height_ratios=heights,
            width_ratios=[max(counts[label], _NARROWEST) for label in strata],
        )
        pairs = panels.T
    timed_solvers = [solver for solver in solvers if solver in timed]
    looks = palette.looks(timed_solvers)
    names = palette.names(timed_solvers)
    lines: dict[str, Line2D] = {}  # by solver: a panel may lack some
    for place, ((above, below), label) in enumerate(zip(pairs, strata, strict=True)):
        chosen = cells[cells["label"] == label]
        plot_success(above, chosen, solvers, size, gaps)
        above.set_title(textwrap.fill(label, _TITLE_CHARS), fontsize=7.5, pad=3)
        lines |= plot_times(below, chosen[chosen["solver"].isin(timed)], looks, names, size)
        if limit > 0:
            mark_limit(below, limit, "y")
        if narrow or place == 0:
            above.set_yticks(range(len(solvers)), map(palette.label, solvers), fontsize=6.5)
            below.set_ylabel("median time")
        if narrow or place == number // 2:
            below.set_xlabel(size)
    marks = gaps.values()
    patches = [Patch(facecolor=mark.colour, edgecolor=RULE, label=mark.key) for mark in marks]
    style: Style = {"fontsize": 7, "columnspacing": 1.2}
    figure.legend(
        handles=patches,
        title="median gap",
        alignment="left",
        loc="outside upper left",
        ncols=gaps_across,
        **style,
    )
    figure.legend(handles=[*lines.values()], loc="outside lower left", ncols=lines_across, **style)
    return figure


def plot_success(
    ax: Axes,
    cells: pd.DataFrame,
    solvers: list[str],
    size: str,
    gaps: Mapping[float, Mark],
) -> None:
    """Draw a map of success for one stratum.

    It has a line for each solver, the first on top, and a column for each size. `cells` are rows of
    `by_size`.
    """
    sizes = sorted(cells[size].unique())
    marks = [*gaps.values()]
    classes = np.searchsorted([*gaps], cells["gap"])
    placed = cells.assign(
        x=cells[size].map(sizes.index),
        y=cells["solver"].map(solvers.index),
        kind=[marks[place].key for place in classes],
        colour=np.where(classes >= _DARK, MAP_PAPER, ON_MAP),
    )
    whole = pd.MultiIndex.from_product((range(len(sizes)), range(len(solvers))), names=["x", "y"])
    draw_kinds(ax, placed.set_index(["x", "y"]).reindex(whole).reset_index(), marks)
    for cell in placed.to_dict("records"):
        ax.text(
            cell["x"],
            cell["y"],
            _cell_text(cell),
            ha="center",
            va="center",
            fontsize=5,
            color=cell["colour"],
        )
    ax.hlines(np.arange(len(solvers)) - 0.5, *ax.get_xlim(), color=MAP_PAPER, linewidth=0.6)
    ax.vlines(np.arange(len(sizes)) - 0.5, *ax.get_ylim(), color=MAP_PAPER, linewidth=0.6)
    ax.set_ylim(len(solvers) - 0.5, -0.5)
    ax.set_xticks(range(len(sizes)), map(str, sizes), fontsize=6)
    ax.tick_params(length=0)


def _cell_text(cell: dict[Hashable, Any]) -> str:
    """The share right as the text of a cell.

    Few questions give a fraction (`5/6`), others per cent (`85`). A question mark follows if some
    questions are open.
    """
    left_open = ""
    if cell["left_open"]:
        left_open = "?"
    if not cell["trials"]:
        return left_open
    if cell["trials"] >= _PER_CENT:
        return f"{100 * cell['successes'] / cell['trials']:.0f}{left_open}"
    return f"{questions(cell['successes'])}/{questions(cell['trials'])}{left_open}"


def plot_times(
    ax: Axes, cells: pd.DataFrame, looks: Mapping[str, Look], names: Names, size: str
) -> dict[str, Line2D]:
    """Draw median times (s) over the size.

    There is a line for each solver, and both axes are logarithmic. `cells` are rows of `by_size`,
    of one stratum. The lines come back by solver.
    """
    lines = {}
    for solver, rows in cells.groupby("solver", sort=False):
        look = looks[str(solver)]
        [line] = ax.plot(
            rows[size],
            rows["wall_s"],
            marker=look.marker,
            markersize=3,
            linewidth=1.0,
            label=names[str(solver)],
            **look.lines,
        )
        lines[str(solver)] = line
    size_axes(ax, cells[size], cells["wall_s"])
    return lines


def size_axes(ax: Axes, sizes: pd.Series[int], times: pd.Series[float]) -> None:
    """Make both axes logarithmic: times (s) over sizes.

    Where sizes are close together, only some have a label.
    """
    ax.set_xscale("log")
    if (times > 0).any():
        ax.set_yscale("log")
        log_axis(ax.yaxis, "s")
    ticks = sorted(sizes.unique())
    # A size has a label if it is at least `_APART` times the last one that has.
    names: dict[float, str] = {}
    last = 0
    for size in ticks:
        if size >= _APART * last:
            names[size] = f"{size:g}"
            last = size
    ax.set_xticks(ticks, minor=False)
    ax.xaxis.set_major_formatter(lambda size, _: names.get(size, ""))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.tick_params(labelsize=7)


_SMALL_TURN = 0.1  # rad; the circle of an arc up to it is not drawn
_MOST_CIRCLES = 100  # legs; the circles of more would hide the path
_MOST_NUMBERS = 60
_MOST_NAMED = 12  # points with their names beside them; of more the names are below the plot
_NAME_CHARS = 24  # of a name
_LINE_CHARS = 80  # of a line of names
_DIGIT = 4.8  # pt; the width of a digit of a number
_EIGHTHS = np.arange(8) * np.pi / 4
_AROUND = np.column_stack((np.cos(_EIGHTHS), np.sin(_EIGHTHS)))  # a point, where its text may stand
_CROSSINGS = 2_000  # places on the path that a text should not cover
_WIDE_LEG = 12.0  # pt of the median leg; shorter ones have thinner lines and smaller dots
_THINNEST_LINE = 0.5  # share of the full width
_SMALLEST_DOT = 0.2  # share of the full size
_MARGIN = 0.07  # around the drawing, as a share of its size
_SIDES = {"L": 1, "S": 0, "R": -1}  # sign of the curvature
# Colour, line and width of each kind of piece: three shades and three lines in grey print.
_TURNS: dict[str, tuple[str, Style]] = {
    "L": ("left", {"color": BLUE, "linestyle": "-", "linewidth": 2.4}),
    "S": ("straight", {"color": INK, "linestyle": "-", "linewidth": 0.9}),
    "R": ("right", {"color": VERMILION, "linestyle": (0, (2.2, 0.7)), "linewidth": 2.4}),
}


def _unit(step: FloatArray) -> FloatArray:
    """The unit vector in the direction of a step."""
    direction: FloatArray = step / np.hypot(*step)
    return direction


def _points_per_unit(ax: Axes) -> float:
    """Points (pt) on paper for a length unit.

    Both axes have this scale, and a margin is left around the drawing.
    """
    sizes = [np.ptp(box.get_points(), axis=0) for box in (ax.bbox, ax.dataLim)]
    unit = sizes[0] / np.maximum(sizes[1], 1e-300) / (1 + 2 * _MARGIN)
    return float(unit.min()) * 72 / ax.figure.dpi


def _runs(points: FloatArray, inside: BoolArray) -> FloatArray:
    """The points of the inside parts, for one line.

    `points` are the ends of the parts in order, and `inside` is a mask of the parts. The result has
    the shape (m, 2), with a row of NaN between two runs of parts, where the line breaks.
    """
    parts = np.flatnonzero(inside)
    ends = points[np.column_stack((parts, parts + 1)).ravel()]
    return np.insert(ends, 2 * np.flatnonzero(np.diff(parts) > 1) + 2, np.nan, axis=0)


def _texts(scenario: Scenario, order: Sequence[int], names: Sequence[str]) -> list[str]:
    """The texts beside the start and the stops.

    The start's comes first, then one for each place in `order`. A via point has the number of its
    visit. Of many via points only every tenth has one, or every hundredth. If points are few, their
    names follow the numbers. The target has no number.
    """
    last = len(order)
    step = 1
    while last > step * _MOST_NUMBERS:
        step *= 10
    texts = ["start"]
    for number, stop in enumerate(order, 1):
        text = ""
        if stop < len(scenario.via) and number % step == 0:
            text = str(number)
        if last <= _MOST_NAMED and stop < len(names):
            text = f"{text} {shortened(names[stop], _NAME_CHARS)}".strip()
        texts.append(text)
    return texts


def _write(
    ax: Axes, points: FloatArray, texts: Sequence[str], unit: float, along: FloatArray
) -> None:
    """Write texts beside points, without overlaps.

    Each text stands at the best of eight places around its point. The best place crosses no piece
    of the path and no edge of the plot, and lies outside the bend of the path. A text that would
    overlap an earlier one at each place loses its name, or is left out. `unit` is the size of a
    length unit (pt). `along` are places on the path and the arrows, shape (m, 2).
    """
    last = len(points) - 1
    dots = points
    if last > _MOST_NAMED:
        dots = points[[0, -1]]
    places = unit * dots  # of dots and texts, pt
    sizes = np.zeros(places.shape)  # half of the widths and heights of texts
    margin = _MARGIN * np.asarray(ax.dataLim.size)
    edge = unit * (ax.dataLim.get_points() + np.array((-margin, margin)))

    def cost_of(at: FloatArray, size: FloatArray, number: int) -> FloatArray:
        """The cost of each place for a text."""
        beside = np.abs(unit * along - at[:, None]) < size + 1
        crossed = np.any(beside.all(axis=2), axis=1)
        beyond = np.any((at - size < edge[0]) | (at + size > edge[1]), axis=1)
        away = np.linalg.norm(unit * points - at[:, None], axis=2)
        another = away.min(axis=1) < away[:, number] - 1e-6  # is nearer than its own
        # The last term prefers places out of the bend, by at most 1.
        cost: FloatArray = (
            4 * crossed + 3 * beyond + 2 * another - _AROUND @ _outside(points, number)
        )
        return cost

    for number, text in enumerate(texts):
        point = points[number]
        gap = 6.0  # beside the ring of the target
        if 0 < number < last:
            gap = 4.0
        # The whole text is tried first, then its number alone.
        for label in filter(None, (text, text.partition(" ")[0])):
            size = np.array((_DIGIT * len(label) / 2, 4.5))
            lifts = _AROUND * gap + np.sign(_AROUND.round(9)) * size
            at = unit * point + lifts
            # 2 pt apart: a dot is as large, and two numbers side by side would be read as one
            free = ~(np.abs(places - at[:, None]) < sizes + size + 2).all(axis=2).any(axis=1)
            if free.any():
                # the least cost wins
                best = int(np.where(free, cost_of(at, size, number), np.inf).argmin())
                places = np.vstack((places, at[best]))
                sizes = np.vstack((sizes, size))
                ax.annotate(
                    label,
                    point,
                    tuple(lifts[best]),
                    textcoords="offset points",
                    ha="center",
                    va="center",
                    fontsize=7.5,
                    zorder=6,
                )
                break


def _outside(points: FloatArray, number: int) -> FloatArray:
    """The unit vector out of the path's bend.

    The path bends at the point with the place `number` in `points`.
    """
    point = points[number]
    outside = np.zeros(2)
    if number:
        outside += _unit(point - points[number - 1])
    if number < len(points) - 1:
        outside -= _unit(points[number + 1] - point)
    if np.hypot(*outside) < 1e-3:  # beside a straight
        along = _unit(points[number + 1] - points[number - 1])
        outside = along[::-1] * (-1, 1)
    return _unit(outside)


def _legend_of_names(order: Sequence[int], names: Sequence[str]) -> str:
    """A text with numbers of visits and names.

    The text stands below the plot, where names beside points would overlap. It is empty if the
    points are so few that the names stand beside them, or too many.
    """
    if not _MOST_NAMED < len(order) <= _MOST_NUMBERS:
        return ""
    named = [
        f"{number} {shortened(names[stop], _NAME_CHARS)}"
        for number, stop in enumerate(order, 1)
        if stop < len(names) and names[stop]
    ]
    whole = [text.replace(" ", "\u00a0") for text in named]  # are not broken
    return textwrap.fill(", ".join(whole), _LINE_CHARS)


def _as_passed(path: Path, scenario: Scenario) -> list[int]:
    """The stops in the order of the path.

    A number is a stop's place in the scenario.
    """
    via: Sequence[int] = range(len(scenario.via))
    if scenario.order is Order.FREE:
        via = visits_of(scenario, path, ARRIVES * scenario.radius).order
    return [*via, *range(len(via), scenario.legs)]


def plot_route(
    ax: Axes,
    path: Path,
    scenario: Scenario,
    name: str,
    names: Sequence[str],
    status: str,
) -> None:
    """Draw a path by its turns, with its points.

    The points are the start, the via points and the target. `name` begins the title and `status`
    ends it. `names` are those of the stops, in the order of the scenario.

    Lines and points are thinner where points lie close, and of many points some have numbers. Faint
    circles are those that the path drives on, for few points; arrows are headings, that at the
    target only if it is given. The legend has the length and the kinds of pieces.
    """
    if scenario.legs <= _MOST_CIRCLES:
        _draw_driven_circles(ax, path, scenario.radius)
    ax.update_datalim(np.vstack((outline(path)[0][:, :2], scenario.points)))
    unit = _points_per_unit(ax)
    legs = np.hypot(*np.diff(scenario.points, axis=0).T)
    room = min(unit * float(np.median(legs)) / _WIDE_LEG, 1.0)
    dot = 3.5 * max(room, _SMALLEST_DOT)
    lines = _draw_pieces(ax, path, max(room, _THINNEST_LINE))
    via = scenario.points[1 : len(scenario.via) + 1]
    ax.plot(*via.T, "o", color=INK, markersize=dot, markeredgewidth=0, zorder=5)
    order = _as_passed(path, scenario)
    points = np.vstack((scenario.points[:1], scenario.points[1:][order]))
    target = (float(points[-1, 0]), float(points[-1, 1]))
    final = None
    if scenario.target is not None:
        final = scenario.stops[-1].heading
    drawn_places = [path.sample(_CROSSINGS)[:, :2]]
    reach = np.linspace(0, 1, 50)[:, None] * max(ax.dataLim.size) / 9  # of both arrows
    for place, heading in ((path.start[:2], path.start.heading), (target, final)):
        if heading is not None:
            drawn_places.append(place + reach * (math.cos(heading), math.sin(heading)))
    _write(ax, points, _texts(scenario, order, names), unit, np.concatenate(drawn_places))
    plot_start_and_target(ax, path.start, target, final)
    if names_below := _legend_of_names(order, names):
        ax.set_xlabel(f"x\n\n{names_below}")
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(_MARGIN)
    ax.legend(
        handles=lines,
        loc="lower left",
        bbox_to_anchor=(0, 1.0),
        borderaxespad=0.2,
        ncols=len(_TURNS),
        title=f"{name}: length {digits(6)(path.length)}{status}",
        alignment="left",
    )


def _draw_driven_circles(ax: Axes, path: Path, radius: float) -> None:
    """Draw the turning circles that a path drives on."""
    bend = np.abs(path.curvatures)
    driven = (bend * radius > 1 - RIPPLE) & (bend * path.lengths > _SMALL_TURN)
    begins = path.poses[:-1][driven]
    for (x, y, heading), curvature in zip(begins, path.curvatures[driven], strict=True):
        centre = (x - math.sin(heading) / curvature, y + math.cos(heading) / curvature)
        draw_turning_circle(ax, centre, 1 / abs(curvature))


def _draw_pieces(ax: Axes, path: Path, thin: float) -> list[Line2D]:
    """Draw a path's left turns, straights and right turns.

    `thin` times the full width is the width of their lines. One line comes back for each kind that
    the path has.
    """
    poses, curvatures = outline(path)
    straight = RIPPLE * float(np.abs(path.curvatures).max(initial=0.0))
    sides = np.where(np.abs(curvatures) <= straight, 0, np.sign(curvatures)).astype(int)
    lines = []
    for letter, (kind, look) in _TURNS.items():
        runs = _runs(poses[:, :2], sides == _SIDES[letter])
        if len(runs):
            thinned = look | {"linewidth": thin * look["linewidth"]}
            [line] = ax.plot(*runs.T, zorder=3, label=kind, **thinned)
            lines.append(line)
    return lines


TOPIC = Topic("routes", routes_section, "routes", (General.BENCHMARKED,), place=Place.FRONT)
