"""How fast the discretised methods approach the optimum when they are refined."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.elements.names import figure_names
from dubins_study.report.statistics import metrics
from dubins_study.study.path import FloatArray

# Method -> the setting that controls its fineness.
SIZES = {"turn-rate-qp": "n", "heading-milp": "headings", "collocation": "n"}
PLACES = ("outside", "in a disc")
GOAL = 1e-4  # the gap up to which the check says optimal by default
# Below these values no order is visible: a gap is rounding, a miss is within Ipopt's tolerance.
FLOOR = {"gap": 1e-13, "miss": 1e-9}
Settings = Mapping[str, Mapping[str, Any]]


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
