"""The section on the order of convergence."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    seconds,
    slug,
)
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import HALF, new_figure
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.report.topics.convergence.figures import plot_cost, plot_orders
from dubins_study.report.topics.convergence.numbers import (
    PLACES,
    medians,
    orders,
    refined,
)

_WHERE = {"outside": "outside the discs", "in a disc": "in a disc"}


def convergence_section(results: Results) -> Section | None:
    """Gap against size with the fitted order, gap against time, and the table of orders."""
    attempts = refined(results.rows, results.settings)
    if attempts.empty:
        return None
    table, fits = medians(attempts), orders(attempts)
    palette = Palette.of(results.solvers)
    blocks: tuple[Picture | Table, ...] = (*_pictures(table, fits, palette), _table(fits))
    text = (
        "A held turn rate costs the integral of |ν₃ Δu| over the steps in which it should have "
        "switched. ν₃ leaves zero quadratically where an arc meets a straight and linearly where "
        "two arcs meet, so steps of 1/N should cost 1/N³ outside the discs and 1/N² inside; a "
        f"grid of headings should cost 1/N² in both. {sentences(fits)}"
    )
    return Section("convergence", "Order of convergence", text, blocks)


def sentences(fits: pd.DataFrame) -> str:
    """What the orders say; `fits` is the frame of `orders`."""
    each = (_falling(fits), _cheapest(fits), _collocated(fits))
    return " ".join(sentence for sentence in each if sentence)


def _falling(fits: pd.DataFrame) -> str:
    parts = []
    for place in PLACES:
        group = fits[(fits["measure"] == "gap") & (fits["place"] == place) & fits["order"].notna()]
        if len(group):
            items = ", ".join(
                f"{row['series']} {digits(3)(row['order'])}" for row in group.to_dict("records")
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
        part = f"{_WHERE[place]} {first['series']} is first, in {seconds(first['goal_s'])}"
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
    """What tells one uncorrected collocation from another: its points, if its spec says them."""
    points = parse_spec(series)[1].get("points")
    return series if points is None else f"p = {points}"


def _pictures(table: pd.DataFrame, fits: pd.DataFrame, palette: Palette) -> list[Picture]:
    drawable = table[np.isfinite(table["value"]) & (table["value"] > 0)]
    gaps, misses = (drawable[drawable["measure"] == measure] for measure in ("gap", "miss"))
    pictures: list[Picture] = []
    for place in PLACES:
        group = gaps[gaps["place"] == place]
        if len(group):
            orders = _order_picture(group, _orders_of(fits, "gap", place), place, palette)
            pictures += [orders, _cost_picture(group, place, palette)]
    for place in PLACES:
        group = misses[misses["place"] == place]
        if len(group):
            fitted = _orders_of(fits, "miss", place)
            pictures.append(_miss_picture(group, fitted, place, palette))
    return pictures


def _orders_of(fits: pd.DataFrame, measure: str, place: str) -> dict[str, float]:
    group = fits[(fits["measure"] == measure) & (fits["place"] == place)]
    return dict(zip(group["series"], group["order"].astype(float), strict=True))


def _order_picture(
    table: pd.DataFrame, fitted: dict[str, float], place: str, palette: Palette
) -> Picture:
    figure = new_figure(HALF, 3.7)
    plot_orders(figure.add_subplot(), table, palette, fitted, "median gap")
    caption = (
        f"Targets {_WHERE[place]}: median gap against the number of steps, headings or elements, "
        "and the order p fitted as far as it falls. Steeper is better; marks inside each other are "
        "lines that coincide."
    )
    return _picture(f"convergence-{slug(place)}", figure, caption)


def _cost_picture(table: pd.DataFrame, place: str, palette: Palette) -> Picture:
    figure = new_figure(HALF, 3.7)
    plot_cost(figure.add_subplot(), table, palette)
    caption = (
        f"Targets {_WHERE[place]}: the same gaps against what they cost. Lower left is better; "
        "along each line N doubles from mark to mark."
    )
    name, alt = f"convergence-time-{slug(place)}", "Median gap against median time"
    return _picture(name, figure, caption, alt)


def _miss_picture(
    table: pd.DataFrame, fitted: dict[str, float], place: str, palette: Palette
) -> Picture:
    figure = new_figure(HALF, 3.7)
    plot_orders(figure.add_subplot(), table, palette, fitted, "median miss / R")
    caption = (
        f"Targets {_WHERE[place]}: by how much collocation misses if nothing corrects it. Nothing "
        "is fitted below 1e-9, Ipopt's own tolerance."
    )
    return _picture(f"convergence-miss-{slug(place)}", figure, caption)


def _picture(name: str, figure: Figure, caption: str, alt: str = "") -> Picture:
    figure.legend(loc="outside lower left", ncols=1, fontsize=7.5)
    return Picture(name, caption, figure, alt or caption.partition(":")[2].strip(), True)


def _table(fits: pd.DataFrame) -> Table:
    columns = (
        Column("series", "method", kind="code"),
        Column("place", "where", kind="text"),
        Column("measure", "of the", kind="text"),
        Column("scenarios", "targets", count),
        Column("order", "order p", digits(3)),
        Column("least", "least", digits(3)),
        Column("most", "most", digits(3)),
        Column("wrong", "wrong basins", count),
        Column("finest", "finest N", count),
        Column("value", "median there", digits(3)),
        Column("wall_s", "median time", seconds),
        Column("goal_s", "time to 1e-4", seconds),
    )
    caption = (
        "Order p of median ~ 1/N^p, and the least and largest order of single targets over the "
        "same N: where a switch falls between two steps moves every single gap. Answers in a "
        "wrong basin, counted for all N, measure no order and only enter the medians."
    )
    return Table("convergence", caption, fits, columns)
