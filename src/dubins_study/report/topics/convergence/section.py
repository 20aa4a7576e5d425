"""The section on the order of convergence."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, sentences, slug
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.names import labels_of
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.report.topics.convergence.figures import plot_cost, plot_orders
from dubins_study.report.topics.convergence.numbers import (
    PLACES,
    medians,
    orders,
    refined,
    series_names,
)

_WHERE = {"outside": "outside the discs", "in a disc": "in a disc"}


def convergence_section(results: Results) -> Section | None:
    """Gap against size with the fitted order, gap against time, and the table of orders."""
    attempts = refined(results.rows, results.settings)
    if attempts.empty:
        return None
    table, fits = medians(attempts), orders(attempts)
    names = series_names(attempts, labels_of(results))
    fits = fits.assign(label=fits["series"].map(names["label"]))
    pictures = _pictures(table, fits, names, Palette.of_page(results))
    blocks: tuple[Picture | Table, ...] = (*pictures, _table(fits))
    text = (
        "A held turn rate costs the integral of |ν₃ Δu| over the steps in which it should have "
        "switched. ν₃ leaves zero quadratically where an arc meets a straight and linearly where "
        "two arcs meet, so steps of 1/N should cost 1/N³ outside the discs and 1/N² inside; a "
        "grid of headings should cost 1/N² in both."
    )
    text = sentences(text, _falling(fits), _cheapest(fits), _collocated(fits))
    lead = (
        "Read the slope of a line: with twice the steps the gap falls by 2 to the power p, outside "
        "the turning circles faster than inside."
    )
    return Section("convergence", "Order of convergence", text, blocks, lead)


def _falling(fits: pd.DataFrame) -> str:
    parts = []
    for place in PLACES:
        group = fits[(fits["measure"] == "gap") & (fits["place"] == place) & fits["order"].notna()]
        if len(group):
            items = ", ".join(
                f"{row['label']} {digits(3)(row['order'])}" for row in group.to_dict("records")
            )
            parts.append(f"{_WHERE[place]} {items}")
    return f"The median gap falls with the orders: {'; '.join(parts)}." if parts else ""


def _cheapest(fits: pd.DataFrame) -> str:
    parts = []
    for place in PLACES:
        group = fits[(fits["measure"] == "gap") & (fits["place"] == place)]
        there = group.dropna(subset=["goal_s"]).sort_values("goal_s")
        if group.empty:
            continue
        if there.empty:
            parts.append(f"{_WHERE[place]} none of them does")
            continue
        first = there.iloc[0]
        part = f"{_WHERE[place]} {first['label']} is first, in {seconds(first['goal_s'])}"
        if len(there) < len(group):
            part += f", and {len(group) - len(there)} of {len(group)} never is"
        parts.append(part)
    return f"At a median gap of 1e-4 {'; '.join(parts)}." if parts else ""


def _collocated(fits: pd.DataFrame) -> str:
    raw = fits[(fits["measure"] == "miss") & fits["order"].notna()]
    parts = []
    for place in PLACES:
        group = raw[raw["place"] == place]
        items = [
            f"{_points(name)}: {digits(3)(p)}"
            for name, p in zip(group["series"], group["order"], strict=True)
        ]
        if items:
            parts.append(f"{_WHERE[place]} {', '.join(items)}")
    if not parts:
        return ""
    return (
        "Left uncorrected, collocation at p of Radau's points should miss the target by 1/N to "
        f"the power 2p − 1; the fitted powers are: {'; '.join(parts)}."
    )


def _points(series: str) -> str:
    """A name for an uncorrected collocation: its number of points, if the spec gives it."""
    points = parse_spec(series)[1].get("points")
    return series if points is None else f"p = {points}"


_ORDERS = {
    "gap": (
        "convergence",
        "median gap",
        "median gap against the number of steps, headings or elements, and the order p fitted as "
        "far as it falls. Steeper is better; marks inside each other are lines that coincide.",
    ),
    "miss": (
        "convergence-miss",
        "median miss / R",
        "by how much collocation misses if nothing corrects it. Nothing is fitted below 1e-9, "
        "Ipopt's own tolerance.",
    ),
}
_COST = (
    "the same gaps against what they cost. Lower left is better; along each line N doubles from "
    "mark to mark."
)


def _pictures(
    table: pd.DataFrame, fits: pd.DataFrame, names: pd.DataFrame, palette: Palette
) -> list[Picture]:
    table = table[np.isfinite(table["value"]) & (table["value"] > 0)]
    pictures = []
    for measure, place in product(_ORDERS, PLACES):
        group = table[(table["measure"] == measure) & (table["place"] == place)]
        if group.empty:
            continue
        fitted = fits[(fits["measure"] == measure) & (fits["place"] == place)]
        orders = fitted.set_index("series")["order"].astype(float)
        known = names[names.index.isin(group["series"])].join(orders)
        name, ylabel, text = _ORDERS[measure]
        data = group, known, palette, ylabel
        pictures.append(_picture(f"{name}-{slug(place)}", place, text, text, plot_orders, *data))
        if measure == "gap":
            name, alt = f"convergence-time-{slug(place)}", "Median gap against median time"
            pictures.append(_picture(name, place, _COST, alt, plot_cost, group, known, palette))
    return pictures


def _picture(
    name: str, place: str, text: str, alt: str, plot: Callable[..., None], *data: object
) -> Picture:
    caption = f"Targets {_WHERE[place]}: {text}"
    return picture(name, plot, *data, caption=caption, alt=alt, height=3.7, legend=1)


def _table(fits: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="text", label="method"),
        *columns(kind="text", place="where", measure="of the"),
        *columns(count, scenarios="targets"),
        *columns(digits(3), order="order p", least="least", most="most"),
        *columns(count, wrong="wrong basins", finest="finest N"),
        *columns(digits(3), value="median there"),
        *columns(seconds, wall_s="median time", goal_s="time to 1e-4"),
    )
    caption = (
        "Order p of median ~ 1/N^p, and the least and largest order of single targets over the "
        "same N: where a switch falls between two steps moves every single gap. Answers in a "
        "wrong basin, counted for all N, measure no order and only enter the medians."
    )
    return Table("convergence", caption, fits, shown, numbers=("series",))


TOPIC = Topic("the order of convergence", convergence_section, "convergence")
