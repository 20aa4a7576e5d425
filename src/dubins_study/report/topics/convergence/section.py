"""The section on the order of convergence."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.page.content import Column, Picture, Section, Table, count, digits, seconds
from dubins_study.report.page.style import HALF, new_figure
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.report.topics.convergence.figures import plot_cost, plot_orders
from dubins_study.report.topics.convergence.numbers import (
    EXPERIMENT,
    PLACES,
    medians,
    orders,
    refined,
)

_WHERE = {"outside": "outside the discs", "in a disc": "in a disc"}


def convergence_section(results: Results) -> Section | None:
    """Gap against size with the fitted order, gap against time, and the table of orders."""
    rows = results.rows[results.rows["experiment"] == EXPERIMENT]
    attempts = refined(rows, results.settings)
    if attempts.empty:
        return None
    table, found = medians(attempts), orders(attempts)
    blocks: tuple[Picture | Table, ...] = (*_pictures(table, found), _table(found))
    text = (
        "A held turn rate costs the integral of |ν₃ Δu| over the steps in which it should have "
        "switched. ν₃ leaves zero quadratically where an arc meets a straight and linearly where "
        "two arcs meet, so steps of 1/N should cost 1/N³ outside the discs and 1/N² inside; a "
        f"grid of headings should cost 1/N² in both. {sentences(found)}"
    )
    return Section("convergence", "Order of convergence", text, blocks)


def sentences(found: pd.DataFrame) -> str:
    """What the orders say; `found` is `orders`' frame."""
    said = [_falling(found), _cheapest(found), _collocated(found)]
    return " ".join(sentence for sentence in said if sentence)


def _falling(found: pd.DataFrame) -> str:
    parts = []
    for place in PLACES:
        own = found[
            (found["measure"] == "gap") & (found["place"] == place) & found["order"].notna()
        ]
        if len(own):
            items = ", ".join(
                f"{row['series']} {digits(3)(row['order'])}" for row in own.to_dict("records")
            )
            parts.append(f"{_WHERE[place]} {items}")
    return f"The median gap falls with the orders: {'; '.join(parts)}." if parts else ""


def _cheapest(found: pd.DataFrame) -> str:
    parts = []
    for place in PLACES:
        own = found[(found["measure"] == "gap") & (found["place"] == place)]
        there = own.dropna(subset=["goal_s"]).sort_values("goal_s")
        if own.empty:
            continue
        if there.empty:
            parts.append(f"{_WHERE[place]} none of them does")
            continue
        first = there.iloc[0]
        part = f"{_WHERE[place]} {first['series']} is first, in {seconds(first['goal_s'])}"
        if len(there) < len(own):
            part += f", and {len(own) - len(there)} of {len(own)} never is"
        parts.append(part)
    return f"At a median gap of 1e-4 {'; '.join(parts)}." if parts else ""


def _collocated(found: pd.DataFrame) -> str:
    raw = found[(found["measure"] == "miss") & found["order"].notna()]
    parts = []
    for place in PLACES:
        own = raw[raw["place"] == place]
        items = [
            f"{_points(name)}: {digits(3)(p)}"
            for name, p in zip(own["series"], own["order"], strict=True)
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


def _pictures(table: pd.DataFrame, found: pd.DataFrame) -> list[Picture]:
    pictures = []
    gaps = table[(table["measure"] == "gap") & np.isfinite(table["value"]) & (table["value"] > 0)]
    for place in PLACES:
        own = gaps[gaps["place"] == place]
        if own.empty:
            continue
        key, where = place.replace(" ", "-"), _WHERE[place]
        pictures += [
            _picture(
                f"convergence-{key}",
                own,
                _orders_of(found, "gap", place),
                "median gap",
                f"Targets {where}: median gap against the number of steps, headings or elements, "
                "and the order p fitted as far as it falls. Steeper is better; marks inside each "
                "other are lines that coincide.",
            ),
            _cost_picture(
                f"convergence-time-{key}",
                own,
                f"Targets {where}: the same gaps against what they cost. Lower left is better; "
                "along each line N doubles from mark to mark.",
            ),
        ]
    for place in PLACES:
        own = table[(table["measure"] == "miss") & (table["place"] == place)]
        own = own[np.isfinite(own["value"]) & (own["value"] > 0)]
        if len(own):
            pictures.append(
                _picture(
                    f"convergence-miss-{place.replace(' ', '-')}",
                    own,
                    _orders_of(found, "miss", place),
                    "median miss / R",
                    f"Targets {_WHERE[place]}: by how much collocation misses if nothing corrects "
                    "it. Nothing is fitted below 1e-9, Ipopt's own tolerance.",
                )
            )
    return pictures


def _orders_of(found: pd.DataFrame, measure: str, place: str) -> dict[str, float]:
    own = found[(found["measure"] == measure) & (found["place"] == place)]
    return dict(zip(own["series"], own["order"].astype(float), strict=True))


def _picture(
    name: str, table: pd.DataFrame, fitted: dict[str, float], ylabel: str, caption: str
) -> Picture:
    figure = new_figure(HALF, 3.7)
    plot_orders(figure.add_subplot(), table, fitted, ylabel)
    figure.legend(loc="outside lower left", ncols=1, fontsize=7.5)
    return Picture(name, caption, figure, caption.partition(":")[2].strip(), True)


def _cost_picture(name: str, table: pd.DataFrame, caption: str) -> Picture:
    figure = new_figure(HALF, 3.7)
    plot_cost(figure.add_subplot(), table)
    figure.legend(loc="outside lower left", ncols=1, fontsize=7.5)
    return Picture(name, caption, figure, "Median gap against median time", True)


def _table(found: pd.DataFrame) -> Table:
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
    return Table("convergence", caption, found, columns)
