"""The section on the order of convergence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Picture, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, sentences, slug
from dubins_study.report.elements.looks import Palette, figure_names, labels_of
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.statistics import metrics
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.study.path import FloatArray

# Method -> the setting that controls its fineness.
SIZES = {"turn-rate-qp": "n", "heading-milp": "headings", "collocation": "n"}
PLACES = ("outside", "in a disc")
GOAL = 1e-4  # the gap up to which the check says optimal by default
# Below these values no order is visible: a gap is rounding, a miss is within Ipopt's tolerance.
FLOOR = {"gap": 1e-13, "miss": 1e-9}
Settings = Mapping[str, Mapping[str, Any]]
ORDERS = (
    *columns(kind="text", label="method"),
    *columns(kind="text", place="where", measure="of the"),
    *columns(count, scenarios="targets"),
    *columns(digits(3), order="order p", least="least", most="most"),
    *columns(count, wrong="wrong basins", finest="finest N"),
    *columns(digits(3), value="median there"),
    *columns(seconds, wall_s="median time", goal_s="time to 1e-4"),
)


def refined(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The attempts of methods that can be refined, with the value measured for each.

    Args:
        rows: attempts.
        settings: spec -> its settings, as a manifest holds them.

    Returns:
        Columns series (the method and all settings in its spec except the size), solver, size,
        place, scenario_id, measure (`gap`, or `miss` in radii for uncorrected collocation), value
        (infinite if there is none), wrong_basin and wall_s (s).
    """
    specs = {str(spec): settings.get(str(spec), {}) for spec in rows["solver"].unique()}
    sizes = {spec: specs[spec].get(SIZES.get(metrics.parse_spec(spec)[0], "")) for spec in specs}
    refinable = [spec for spec, size in sizes.items() if isinstance(size, int)]
    group = rows[rows["solver"].isin(refinable) & rows["region"].notna()]
    raw = group["solver"].map({spec: specs[spec].get("correct") is False for spec in refinable})
    raw = raw.astype(bool)
    value = group["gap"].clip(lower=0).where(~raw, group["miss"] / group["radius"]).fillna(np.inf)
    return pd.DataFrame(
        {
            "series": group["solver"].map({spec: series(spec) for spec in refinable}),
            "solver": group["solver"],
            "size": group["solver"].map(sizes).astype("int64"),
            "place": np.where(group["region"].str.endswith("disc"), *PLACES[::-1]),
            "scenario_id": group["scenario_id"],
            "measure": np.where(raw, "miss", "gap"),
            "value": value,
            "wrong_basin": group["wrong_basin"].astype(bool),
            "wall_s": group["wall_s"],
        }
    )


def series(spec: str) -> str:
    """A spec without its size: `collocation[n=20,mesh=equal]` -> `collocation[mesh=equal]`."""
    name, settings = metrics.parse_spec(spec)
    others = [f"{key}={value}" for key, value in settings.items() if key != SIZES.get(name)]
    return f"{name}[{','.join(others)}]" if others else name


def series_names(attempts: pd.DataFrame, labels: Mapping[str, str]) -> pd.DataFrame:
    """How the series of `refined` are called and drawn.

    Args:
        attempts: from `refined`.
        labels: spec -> the solver's short name.

    Returns:
        Indexed by series; columns solver (one spec of the series) and label (its short name without
        the size).
    """
    frame = attempts.groupby("series")[["solver"]].first()
    keys = [SIZES[metrics.parse_spec(spec)[0]] for spec in frame["solver"]]
    pairs = zip(frame["solver"], keys, strict=True)
    without = {spec: label_without(labels[spec], key) for spec, key in pairs}
    return frame.assign(label=frame["solver"].map(figure_names(without)))


def label_without(label: str, key: str) -> str:
    """A short name without one setting: of the series that differs only in it."""
    return ", ".join(item for item in label.split(", ") if not item.startswith(f"{key}="))


def medians(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per series, place and size, from the attempts that `refined` returns.

    Columns measure, series, place, size, attempts, arrived (share with a value), value (median,
    infinite if half have none) and wall_s (median, s).
    """
    arrived = attempts.assign(arrived=np.isfinite(attempts["value"]))
    groups = arrived.groupby(["measure", "series", "place", "size"])
    frame = pd.DataFrame({"attempts": groups.size(), "arrived": groups["arrived"].mean()})
    frame["value"] = groups["value"].agg(lambda values: metrics.upper_quantile(values, 0.5))
    return frame.assign(wall_s=groups["wall_s"].median()).reset_index()


def orders(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row per series and place, from the attempts that `refined` returns.

    Columns measure, series, place, scenarios, order (p of median ~ size^-p, over the sizes at which
    the median falls), least and most (smallest and largest order of single scenarios over the same
    sizes, without answers in a wrong basin), wrong (number of these answers), finest (size), value
    and wall_s (medians at that size), and goal_s: the median time at the smallest size from which
    on the median gap is at most 1e-4, NaN if there is no such size.
    """
    table, keys = medians(attempts), ["measure", "series", "place"]
    lines = dict(list(table.groupby(keys)))
    attempts_of = dict(list(attempts.groupby(keys)))
    series_names = metrics.solver_order(table["series"].tolist())
    places = product(sorted(table["measure"].unique()), series_names, PLACES)
    records = [
        _order(lines[key].sort_values("size"), attempts_of[key]) for key in places if key in lines
    ]
    return pd.DataFrame.from_records(records)


def _order(line: pd.DataFrame, attempts: pd.DataFrame) -> dict[str, object]:
    value = line["value"].to_numpy(dtype=np.float64)
    floor = FLOOR[str(line["measure"].iloc[0])]
    falling = line.iloc[: int(value.argmin()) + 1]
    fitted = attempts[attempts["size"].isin(falling["size"]) & ~attempts["wrong_basin"]]
    scenarios = fitted.groupby("scenario_id")
    orders = [metrics.fitted_order(rows["size"], rows["value"], floor) for _, rows in scenarios]
    singly = [order for order in orders if math.isfinite(order)]
    last = line.iloc[-1]
    return {
        **last[["measure", "series", "place"]],
        "scenarios": attempts["scenario_id"].nunique(),
        "order": metrics.fitted_order(falling["size"], falling["value"], floor),
        "least": min(singly, default=math.nan),
        "most": max(singly, default=math.nan),
        "wrong": int(attempts["wrong_basin"].sum()),
        "finest": int(last["size"]),
        "value": last["value"],
        "wall_s": last["wall_s"],
        "goal_s": _goal(value, line["wall_s"].to_numpy(dtype=np.float64)),
    }


def _goal(value: FloatArray, seconds: FloatArray) -> float:
    """Time (s) at the smallest size from which on all values are within the goal."""
    above = np.flatnonzero(~(value <= GOAL))
    first = int(above[-1]) + 1 if above.size else 0
    return float(seconds[first]) if first < value.size else float("nan")


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
    caption = (
        "Order p of median ~ 1/N^p, and the least and largest order of single targets over the "
        "same N: where a switch falls between two steps moves every single gap. Answers in a "
        "wrong basin, counted for all N, measure no order and only enter the medians."
    )
    blocks: tuple[Picture | Table, ...] = (
        *pictures,
        Table("convergence", caption, fits, ORDERS, numbers=("series",)),
    )
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


# Measure -> name of the figures, axis, caption.
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


def _pictures(
    table: pd.DataFrame, fits: pd.DataFrame, names: pd.DataFrame, palette: Palette
) -> list[Picture]:
    """Value against size, and of gaps against time too, outside the discs and in a disc."""
    lines = table.join(names, on="series").sort_values(["series", "size"], kind="stable")
    lines = lines.merge(fits[["measure", "series", "place", "order"]], how="left")
    pictures = []
    for measure, place in product(_ORDERS, PLACES):
        group = lines[(lines["measure"] == measure) & (lines["place"] == place)]
        if not (np.isfinite(group["value"]) & (group["value"] > 0)).any():
            continue
        stem, ylabel, text = _ORDERS[measure]
        fitted = [
            f"{label}: p = {digits(3)(order)}" if order == order else label
            for label, order in zip(group["label"], group["order"], strict=True)
        ]
        xlabel = "steps, headings or elements N"
        data = group.assign(name=fitted), "size", "value", palette, xlabel, ylabel
        caption, name = f"Targets {_WHERE[place]}: {text}", f"{stem}-{slug(place)}"
        figure = parameter_lines(*data, height=3.7)
        pictures.append(Picture(name, caption, figure, caption, half=True))
        if measure == "gap":
            caption = (
                f"Targets {_WHERE[place]}: the same gaps against what they cost. Lower left is "
                "better; along each line N doubles from mark to mark."
            )
            data = group.assign(name=group["label"]), "wall_s", "value", palette, _TIME, ylabel
            figure = parameter_lines(*data, seconds=True, height=3.7)
            name = f"convergence-time-{slug(place)}"
            pictures.append(Picture(name, caption, figure, caption, half=True))
    return pictures


_TIME = "median time of one attempt"


TOPIC = Topic("the order of convergence", convergence_section, "convergence")
