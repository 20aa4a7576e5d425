"""The section on the number of steps of `turn-rate-qp` and its engine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Picture, Section, Table, Topic
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.elements.looks import Palette, figure_names, labels_of
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.statistics import metrics
from dubins_study.report.topics.convergence import label_without

SOLVER = "turn-rate-qp"
COLUMNS = (
    *columns(kind="code", engine="engine"),
    *columns(count, n="n", attempts="attempts"),
    *columns(share, arrived="arrive", success="success"),
    *columns(digits(3), gap="median gap", gap_q90="90 %"),
    *columns(seconds, wall_s="median time"),
    *columns(digits(3), iterations="QPs"),
)
_QUANTILES = {"gap_q25": 0.25, "gap": 0.5, "gap_q75": 0.75, "gap_q90": 0.9}
Settings = Mapping[str, Mapping[str, Any]]


def work_precision(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """One row per engine and n, from the attempts of `turn-rate-qp`.

    Args:
        rows: attempts.
        settings: spec -> its settings, as a manifest holds them.

    Returns:
        Columns engine (with all settings in the spec except n), n, solver (a spec of the engine's,
        the same at all n), attempts, arrived and success (shares of all attempts), gap and gap_q25,
        gap_q75, gap_q90 (median and quantiles, infinite if too few arrive), wall_s (median, s),
        iterations (median), order (p of gap ~ n^-p, up to the engine's smallest gap).
    """
    steps = {spec: _steps(spec, settings) for spec in rows["solver"].unique()}
    refined = rows[rows["solver"].map(steps) > 0]
    if refined.empty:
        return pd.DataFrame()
    engines = {spec: _engine(spec, settings) for spec in refined["solver"].unique()}
    refined = refined.assign(engine=refined["solver"].map(engines), n=refined["solver"].map(steps))
    frame = _measures(refined).reset_index()
    orders = {engine: _order(group) for engine, group in frame.groupby("engine")}
    specs = refined.groupby("engine")["solver"].min()
    return frame.assign(order=frame["engine"].map(orders), solver=frame["engine"].map(specs))


def _order(rows: pd.DataFrame) -> float:
    falling = rows.sort_values("n").reset_index(drop=True)
    falling = falling.loc[: int(falling["gap"].to_numpy().argmin())]
    return metrics.fitted_order(falling["n"], falling["gap"])


def _steps(spec: str, settings: Settings) -> int:
    """The setting n of a spec; 0 for another solver, or if n is not a number."""
    n = settings.get(spec, {}).get("n")
    return n if metrics.parse_spec(spec)[0] == SOLVER and isinstance(n, int) else 0


def _engine(spec: str, settings: Settings) -> str:
    engine = str(settings.get(spec, {}).get("engine"))
    others = [
        f"{k}={v}" for k, v in metrics.parse_spec(spec)[1].items() if k not in ("n", "engine")
    ]
    return ", ".join([engine, *others])


def _measures(rows: pd.DataFrame) -> pd.DataFrame:
    measured = rows.assign(value=metrics.gaps(rows), success=metrics.success(rows))
    groups = measured.groupby(["engine", "n"])
    arrived = groups["value"].agg(lambda gaps: np.isfinite(gaps.dropna()).mean())
    frame = pd.DataFrame({"attempts": groups.size(), "arrived": arrived})
    frame = frame.assign(success=groups["success"].mean(), wall_s=groups["wall_s"].median())
    for name, q in _QUANTILES.items():
        frame[name] = groups["value"].agg(metrics.upper_quantile, q=q)
    return frame.assign(iterations=groups["iterations"].median())


def discretisation_section(results: Results) -> Section | None:
    """Time against gap by n and engine, gap against n with the fitted order."""
    table = work_precision(results.rows, results.settings)
    if table.empty:
        return None
    drawable = table[np.isfinite(table["gap"]) & (table["gap"] > 0)]  # the axes are logarithmic
    labels = labels_of(results)
    names = figure_names({spec: label_without(labels[spec], "n") for spec in drawable["solver"]})
    named = drawable.assign(name=[_short(names[spec]) for spec in drawable["solver"]])
    pictures = _pictures(named, Palette.of_page(results)) if len(named) else ()
    caption = (
        "Every engine at every n. Gap quantiles count an attempt that does not arrive as ∞. QPs: "
        "median number of QPs solved in one attempt."
    )
    blocks = (*pictures, Table("discretisation", caption, table, COLUMNS))
    text = (
        "turn-rate-qp holds each of n turn rates over a step, so its best path is longer than the "
        "best of all. How fast that cost falls with n, what it takes, and which engine to use."
    )
    lead = (
        "Follow a curve down to the gap that you want and read off the steps and the time; the "
        "engine whose curve is farthest left is the one to use."
    )
    return Section("discretisation", "Work and precision", text, blocks, lead)


def _short(name: str) -> str:
    """A solver's name without the formulation, which is the same for all."""
    return ", ".join(item for item in name.split(", ") if item != "turn rates")


def _pictures(table: pd.DataFrame, palette: Palette) -> tuple[Picture, Picture]:
    """Gap against time and against n, a line per engine."""
    top = 3 * table["gap"].max()  # of quartiles, of which some are infinite
    lines = table.assign(
        gap_q1=table["gap_q25"].clip(lower=table["gap"].min() / 3),
        gap_q3=table["gap_q75"].clip(upper=top),
    ).sort_values(["solver", "n"])
    ylabel = "gap to the shortest length"
    caption = (
        "Gap against median time, medians with the quartiles over the targets as a band; along "
        "each line n doubles from mark to mark. Lower left is better."
    )
    data = lines, "wall_s", "gap", palette, "median time of one attempt", ylabel
    precision = parameter_lines(*data, seconds=True, height=3.7)
    alt = "Time against gap for each engine"
    first = Picture("work-precision", caption, precision, alt, half=True)
    caption = (
        "Gap against the number of steps, and the order p fitted to the medians as far as they "
        "fall: beyond their least value the engine's own accuracy decides."
    )
    fitted = [
        f"{name}, p = {digits(3)(order)}" if order == order else name
        for name, order in zip(lines["name"], lines["order"], strict=True)
    ]
    data = lines.assign(name=fitted), "n", "gap", palette, "steps n", ylabel
    alt = "Gap against number of steps for each engine"
    return first, Picture("gap-order", caption, parameter_lines(*data, height=3.7), alt, half=True)


TOPIC = Topic("work and precision", discretisation_section, "discretisation")
