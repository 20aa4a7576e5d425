"""How fast the discretised methods close in on the optimum as they are refined."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.statistics.metrics import (
    FloatArray,
    fitted_order,
    parse_spec,
    solver_order,
    upper_quantile,
)

# the setting that says how fine each method is
SIZES = {"turn-rate-qp": "n", "heading-milp": "headings", "collocation": "n"}
PLACES = ("outside", "in a disc")
GOAL = 1e-4  # the gap up to which the check says optimal by default
# where no order shows any more: gaps in their rounding, misses in Ipopt's tolerance
FLOOR = {"gap": 1e-13, "miss": 1e-9}
Settings = Mapping[str, Mapping[str, Any]]


def refined(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """The attempts of methods that can be refined, with what is measured of each.

    Args:
        rows: attempts.
        settings: spec -> its settings, as a manifest holds them.

    Returns:
        Columns series (the method and all settings that its spec changes but the size), size,
        place, scenario_id, measure (`gap`; `miss`, in radii, of collocation that leaves it open),
        value (infinite if there is none), wrong_basin and wall_s (s).
    """
    specs = {str(spec): settings.get(str(spec), {}) for spec in rows["solver"].unique()}
    sizes = {spec: given.get(SIZES.get(parse_spec(spec)[0], "")) for spec, given in specs.items()}
    kept = [spec for spec, size in sizes.items() if isinstance(size, int)]
    own = rows[rows["solver"].isin(kept) & rows["region"].notna()]
    raw = own["solver"].map({spec: specs[spec].get("correct") is False for spec in kept})
    raw = raw.astype(bool)
    value = own["gap"].clip(lower=0).where(~raw, own["miss"] / own["radius"]).fillna(np.inf)
    return pd.DataFrame(
        {
            "series": own["solver"].map({spec: series(spec) for spec in kept}),
            "size": own["solver"].map(sizes).astype("int64"),
            "place": np.where(own["region"].str.endswith("disc"), *PLACES[::-1]),
            "scenario_id": own["scenario_id"],
            "measure": np.where(raw, "miss", "gap"),
            "value": value,
            "wrong_basin": own["wrong_basin"].astype(bool),
            "wall_s": own["wall_s"],
        }
    )


def series(spec: str) -> str:
    """A spec without its size: `collocation[n=20,mesh=equal]` -> `collocation[mesh=equal]`."""
    name, given = parse_spec(spec)
    kept = ",".join(f"{key}={value}" for key, value in given.items() if key != SIZES.get(name))
    return f"{name}[{kept}]" if kept else name


def medians(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row a series, place and size, of what `refined` returns.

    Columns measure, series, place, size, attempts, arrived (share with a value), value (median,
    infinite if half have none) and wall_s (median, s).
    """
    keys = ["measure", "series", "place", "size"]
    records = [
        {
            **dict(zip(keys, group, strict=True)),
            "attempts": len(own),
            "arrived": float(np.isfinite(own["value"]).mean()),
            "value": upper_quantile(own["value"], 0.5),
            "wall_s": own["wall_s"].median(),
        }
        for group, own in attempts.groupby(keys)
    ]
    return pd.DataFrame.from_records(records)


def orders(attempts: pd.DataFrame) -> pd.DataFrame:
    """One row a series and place, of what `refined` returns.

    Columns measure, series, place, scenarios, order (p of median ~ size^-p, as far as the median
    falls), least and most (that of the scenarios taken one by one, over the same sizes, without
    answers in a wrong basin, which measure no order), wrong (how many those are), finest (size),
    value and wall_s (medians there), and goal_s: the median time at the least size from which on
    the median gap is at most 1e-4, NaN if there is none.
    """
    table = medians(attempts)
    records = []
    for measure in sorted(table["measure"].unique()):
        own = table[table["measure"] == measure]
        for name in solver_order(own["series"].tolist()):
            for place in PLACES:
                line = own[(own["series"] == name) & (own["place"] == place)].sort_values("size")
                if len(line):
                    asked = attempts[
                        (attempts["series"] == name)
                        & (attempts["place"] == place)
                        & (attempts["measure"] == measure)
                    ]
                    records.append(_order(line, asked))
    return pd.DataFrame.from_records(records)


def _order(line: pd.DataFrame, attempts: pd.DataFrame) -> dict[str, object]:
    value = line["value"].to_numpy(dtype=np.float64)
    floor = FLOOR[str(line["measure"].iloc[0])]
    falling = line.iloc[: int(value.argmin()) + 1]
    fitted = attempts[attempts["size"].isin(falling["size"]) & ~attempts["wrong_basin"]]
    singly = [
        fitted_order(own["size"], own["value"], floor) for _, own in fitted.groupby("scenario_id")
    ]
    known = np.array([order for order in singly if np.isfinite(order)])
    last = line.iloc[-1]
    return {
        "measure": last["measure"],
        "series": last["series"],
        "place": last["place"],
        "scenarios": attempts["scenario_id"].nunique(),
        "order": fitted_order(falling["size"], falling["value"], floor),
        "least": float(known.min()) if known.size else float("nan"),
        "most": float(known.max()) if known.size else float("nan"),
        "wrong": int(attempts["wrong_basin"].sum()),
        "finest": int(last["size"]),
        "value": last["value"],
        "wall_s": last["wall_s"],
        "goal_s": _goal(value, line["wall_s"].to_numpy(dtype=np.float64)),
    }


def _goal(value: FloatArray, seconds: FloatArray) -> float:
    """Time at the first size from which on every value is within the goal."""
    above = np.flatnonzero(~(value <= GOAL))
    first = int(above[-1]) + 1 if above.size else 0
    return float(seconds[first]) if first < value.size else float("nan")
