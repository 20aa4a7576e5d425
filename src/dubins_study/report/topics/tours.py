"""Tours: what is proved by size and density, and what a grid of headings costs."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from dubins_study.report.data.attempts import EXACT, TRIAL, is_true, legs_of
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import (
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
    picture,
)
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.identity import with_share
from dubins_study.report.elements.looks import distinct, in_page_order
from dubins_study.report.elements.plots import Mark
from dubins_study.report.elements.style import (
    BLUE,
    GREEN,
    INK,
    VERMILION,
    Style,
    percent_axis,
)
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import stratum_order
from dubins_study.report.statistics.metrics import upper_quantile
from dubins_study.report.topics.routes import by_size, palette_of, plot_sizes
from dubins_study.study.words import Claim

TITLE = "Tours: the order free"
# The largest median gap of each class -> its mark, from light to dark.
GAPS = {
    1e-6: Mark("up to 1e-6", colour="#eef4f9"),
    1e-2: Mark("up to 1 %", colour="#cfe2f0"),
    1e-1: Mark("up to 10 %", colour="#a3c7e0"),
    1e300: Mark("more", colour="#6a9cc4"),
    math.inf: Mark("most have no tour", colour="#2f4c69"),
}
_PROVING = ("tour MILP", "tour circuit")  # formulations of which an engine proves an optimum
_STRAIGHT_FIRST = "order then headings"  # the formulation of both orders by straight lines
# What proved tours are compared with.
_STRAIGHT = "order by straight lines, best headings"
_ALTERNATING = "that order, every other leg straight"
_LOOKS = (
    Mark("", colour=BLUE, marker="o"),
    Mark("", colour=VERMILION, marker="s"),
    Mark("", colour=GREEN, marker="^"),
    Mark("", colour=INK, marker="D"),
)
# how the engines' words for an optimum of their program end, in small letters
_OPTIMAL = ("optimal", "gaplimit", "glp_opt", "glp_emipgap")
_FLOOR = 1e-6  # a smaller gap is drawn there: as long as the proved tour


def with_points(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with columns points (their number), closes and bound_gap.

    Closes: the search has proved the tour to be shortest, or an engine has solved its own program
    to the optimum. The bound's gap is how far the solver's bound of the shortest length lies below
    it, relative to it; NaN without a bound.
    """
    points = legs_of(rows) - is_true(rows["closed"])
    solved = rows["native_status"].fillna("").str.lower().str.endswith(_OPTIMAL)
    proved = rows["claim"].eq(Claim.OPTIMAL) & rows["verdict"].eq("optimal")
    ended = proved.where(rows["solver"].eq(EXACT), solved & rows["formulation"].isin(_PROVING))
    high = rows["reference_high"]
    below = (high - rows["lower_bound"]).clip(lower=0.0) / high
    return rows.assign(points=points, closes=ended & ~is_true(rows["late"]), bound_gap=below)


def by_points(rows: pd.DataFrame) -> pd.DataFrame:
    """The table of `by_size` by the number of points: questions that are closed, of those asked.

    Of a method that proves nothing they are 0 of 0. The gap is an upper bound where the shortest
    length is not proved.
    """
    cells = by_size(rows.assign(undecided=False), "points", "closes")
    proves = cells["solver"].isin(provers(rows))
    numbers = ["successes", "trials"]
    return cells.assign(**{name: cells[name].where(proves, 0) for name in numbers})


def provers(rows: pd.DataFrame) -> set[str]:
    """The solvers that prove anything."""
    proving = rows["solver"].eq(EXACT) | rows["formulation"].isin(_PROVING)
    return set(rows["solver"][proving])


def asked_of_most(rows: pd.DataFrame) -> pd.DataFrame:
    """The attempts at the questions that most solvers were asked: all, if any were."""
    solvers = rows.groupby("scenario_id")["solver"].transform("nunique")
    asked: pd.DataFrame = rows[solvers == solvers.max()]
    return asked


def by_engine(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: what it closes, and medians over its attempts.

    Columns solver; those of `with_share` for closes; nodes (of attempts that count some); gap
    (infinite without an answer); bound_gap (1 without a bound, NaN of solvers that give none);
    wall_s.
    """
    bounded = rows.groupby("solver")["bound_gap"].transform("count") > 0
    counted = rows.assign(
        gap=rows["gap"].fillna(np.inf), bound_gap=rows["bound_gap"].fillna(1.0).where(bounded)
    )
    medians = {"iterations": "nodes", "gap": "gap", "bound_gap": "bound_gap", "wall_s": "wall_s"}
    groups = counted.groupby("solver", sort=False)[[*medians]]
    frame = groups.agg(upper_quantile, q=0.5).rename(columns=medians)
    proving = rows[rows["solver"].isin(provers(rows))]
    shares = scenario_shares(proving, by=["solver"], success="closes", scenario=TRIAL)
    shares = shares.reindex(frame.index).fillna({"successes": 0, "trials": 0})
    return with_share(frame, "closes", shares["successes"], shares["trials"]).reset_index()


def against_proof(rows: pd.DataFrame, settings: dict[str, dict[str, Any]]) -> pd.DataFrame:
    """Answers to questions whose shortest tour is proved, one of each kind.

    The kinds are the best tour of a grid, found by whichever engine has proved it, and both orders
    by straight lines. Columns: those of the rows; kind; other_order, whether it passes the points
    in another order than the proved tour. A closed tour may be driven either way.
    """
    proved = rows[rows["solver"].eq(EXACT) & rows["closes"]].drop_duplicates("scenario_id")
    orders = proved.set_index("scenario_id")["visit_order"]
    tried = rows.assign(kind=[_kind_of(row, settings) for row in rows.to_dict("records")])
    known = tried["scenario_id"].isin(orders.index) & tried["gap"].notna() & tried["kind"].ne("")
    chosen = tried[known].drop_duplicates(["kind", "scenario_id"])
    other = [
        not _same_order(row["visit_order"], orders[row["scenario_id"]], row["closed"] is True)
        for row in chosen.to_dict("records")
    ]
    return chosen.assign(other_order=np.array(other, dtype=bool))


def _kind_of(row: dict[Hashable, Any], settings: dict[str, dict[str, Any]]) -> str:
    """What a proved tour is compared with; empty if nothing is compared."""
    own = settings.get(row["solver"], {})
    if row["formulation"] == _STRAIGHT_FIRST:
        return _ALTERNATING if own.get("order") == "alternating" else _STRAIGHT
    if row["closes"] and own.get("costs") == "lengths" and not own.get("polish"):
        return f"best tour of {own['headings']} headings"
    return ""


def _same_order(one: Any, other: Any, round_trip: bool) -> bool:
    order, proved = (np.atleast_1d(each).tolist() for each in (one, other))
    return order == proved or (round_trip and order[::-1] == proved)


def tours_section(results: Results) -> Section | None:
    """What closes, and proved tours against those of a grid and of straight lines."""
    if results.rows.empty:
        return None
    rows = with_points(results.rows)
    cells = in_page_order(by_points(rows), results)
    strata = stratum_order(results, cells["label"])
    compared = against_proof(rows, results.settings)
    blocks: list[Picture | Table] = [_closed_picture(cells, strata, results)]
    if len(compared):
        blocks += _grid_pictures(compared, strata)
    blocks.append(_engines(in_page_order(by_engine(asked_of_most(rows)), results)))
    lead = (
        "Read along a line up to how many points a method closes what it solves. Then see below "
        "what its answer is worth beside the proved tour."
    )
    return Section("tours", TITLE, _text(rows, compared), tuple(blocks), lead)


def _text(rows: pd.DataFrame, compared: pd.DataFrame) -> str:
    """What the search proves, and what is told of the shortest tours by other methods."""
    search = rows[rows["solver"] == EXACT]
    proved = ""
    if len(search):
        proved = (
            f"The search proves {count(search['closes'].sum())} of {count(len(search))} tours "
            "within its limit."
        )
    told = []
    for kind, answers in compared.groupby("kind", sort=False):
        worst = answers.groupby("label", sort=False)["gap"].median().max()
        told.append(
            f"{str(kind).capitalize()}: up to {share(worst)} longer at the median of a density, "
            f"and of another order in {count(answers['other_order'].sum())} of "
            f"{count(len(answers))}."
        )
    return sentences(
        "Closed: the search has proved its tour to be shortest, or an engine has solved its own "
        "program to the optimum. An optimum on a grid of headings is none of the question.",
        proved,
        *told,
    )


def _closed_picture(cells: pd.DataFrame, strata: list[str], results: Results) -> Picture:
    methods = results.methods.set_index("solver")
    names = [_name(methods.loc[spec], results.settings.get(spec, {})) for spec in methods.index]
    labels = dict(zip(methods.index, distinct(names), strict=True))
    return panels_picture(
        "tours",
        "Above, in each cell the questions that are closed of those asked (no number: a method "
        "that proves nothing), and as colour the median gap of the answers to the proven lower end "
        "of the shortest length. Below, median times of those that prove, failures included; "
        "dotted: the limit. A panel for each density: the square's side.",
        plot_sizes,
        "Questions closed, gaps and times, by solver, number of points and density",
        cells,
        strata,
        provers(results.rows),
        palette_of(results, labels),
        results.rows["limit_s"].max(),
        size="points",
        gaps=GAPS,
    )


def _name(method: pd.Series, settings: dict[str, Any]) -> str:
    """A method's name in the figure: the engine, and the settings that tell models apart."""
    if method["formulation"] == _STRAIGHT_FIRST:
        return f"{settings.get('order', '')} order".strip()
    bounds = "bounds" if settings.get("costs") == "bounds" else ""
    return ", ".join(filter(None, [method["engine"], settings.get("model", ""), bounds]))


def _grid_pictures(compared: pd.DataFrame, strata: list[str]) -> list[Picture]:
    excess = picture(
        *("tours-excess", plot_excess, compared, strata),
        caption="How much longer each answer is than the proved tour (small marks; at the lower "
        "edge: as long), and the median, by density. The best tour of a grid is one that an engine "
        "has proved to be its optimum.",
        alt="Excess lengths by density",
        height=3.1,
        legend=1,
    )
    orders = picture(
        *("tours-orders", plot_orders, compared, strata),
        caption="Share of the same answers that pass the points in another order than the proved "
        "tour, with its 95 % interval.",
        alt="Shares of other orders by density",
        height=3.1,
        legend=1,
    )
    return [excess, orders]


def _beside(compared: pd.DataFrame, strata: list[str]) -> Iterator[tuple[Mark, pd.DataFrame]]:
    """Each kind's mark, and its rows with their place x."""
    kinds = list(dict.fromkeys(compared["kind"]))
    for number, kind in enumerate(kinds):
        rows = compared[compared["kind"] == kind]
        shift = 0.2 * (number - (len(kinds) - 1) / 2)
        mark = _LOOKS[number % len(_LOOKS)]
        yield replace(mark, label=kind), rows.assign(x=rows["label"].map(strata.index) + shift)


def plot_excess(ax: Axes, compared: pd.DataFrame, strata: list[str]) -> None:
    """Excess lengths over densities, and their medians; columns of `against_proof`."""
    for mark, rows in _beside(compared, strata):
        gaps = rows["gap"].clip(lower=_FLOOR)
        ax.plot(rows["x"], gaps, **mark.dots() | {"markersize": 2.5, "alpha": 0.6}, clip_on=False)
        middle = gaps.groupby(rows["x"]).median()
        bar: Style = {"linestyle": "none", "color": mark.colour, "markersize": 15}
        ax.plot(middle.index, middle, marker="_", markeredgewidth=2, **bar)
        ax.plot([], [], label=mark.label, **mark.dots())
    ax.set(yscale="log", ylim=(_FLOOR, max(1.0, 1.2 * float(compared["gap"].max()))))
    ax.set_yticks([1e-6, 1e-4, 1e-2, 1e-1, 1], ["≤ 1e-6", "0.01 %", "1 %", "10 %", "100 %"])
    ax.yaxis.set_minor_locator(NullLocator())
    _density_axis(ax, strata)


def plot_orders(ax: Axes, compared: pd.DataFrame, strata: list[str]) -> None:
    """Shares of other orders over densities, with intervals; columns of `against_proof`."""
    for mark, rows in _beside(compared, strata):
        shares = scenario_shares(rows, by=["x"], success="other_order", scenario=TRIAL)
        middle = shares["share"]
        ends = np.maximum([middle - shares["low"], shares["high"] - middle], 0.0)
        style: Style = mark.dots() | {"markersize": 5, "linewidth": 1.0, "label": mark.label}
        ax.errorbar(shares.index, middle, yerr=ends, **style)
    ax.set_ylim(-0.03, 1.03)
    percent_axis(ax.yaxis)
    _density_axis(ax, strata)


def _density_axis(ax: Axes, strata: list[str]) -> None:
    ax.set_xticks(range(len(strata)), strata)
    ax.set_xlim(-0.6, len(strata) - 0.4)
    ax.grid(False, axis="x")


def _gap(value: float) -> str:
    return share(value) if np.isfinite(value) else "no tour"


def _engines(frame: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(kind="cell", closes_text="closed"),
        *columns(digits(3), nodes="nodes"),
        *columns(_gap, gap="gap of the answer", bound_gap="gap of the bound"),
        *columns(seconds, wall_s="time"),
    )
    caption = (
        "Medians over attempts at the questions that all were asked. Gaps at the limit: the "
        "answer's to the proven lower end of the shortest length, the bound's to its upper end. "
        "Only a bound of the question has a gap, and only an engine that branches has nodes."
    )
    return Table("tours-engines", caption, frame, shown)


TOPIC = Topic("tours", tours_section, "tours")
