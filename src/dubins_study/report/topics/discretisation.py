"""The section on the number of steps of `turn-rate-qp` and its engine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.results import Results
from dubins_study.report.elements.axes import duration, log_axis
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.names import figure_names, labels_of
from dubins_study.report.elements.style import MUTED, Style
from dubins_study.report.elements.topic import Topic
from dubins_study.report.statistics import metrics
from dubins_study.report.topics.convergence import label_without

SOLVER = "turn-rate-qp"
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


def plot_work_precision(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median gap against median time with the gap's quartiles as a band, one line per engine.

    Columns: label (of the engine), solver, n (written next to the marks), gap, gap_q25, gap_q75
    (finite and positive where drawn), wall_s (s).
    """
    _plot_engines(ax, table, "wall_s", palette)
    text: Style = {"textcoords": "offset points", "ha": "right", "va": "center", "fontsize": 7.5}
    fastest = table.sort_values("wall_s").drop_duplicates("n")
    for row in fastest.to_dict("records"):
        point = (row["wall_s"], row["gap"])
        ax.annotate(str(row["n"]), point, xytext=(-6, 0), color=MUTED, **text)
    ax.set_xlabel("median time of one attempt")
    log_axis(ax.xaxis, duration)
    ax.margins(x=0.14)


def plot_gap_order(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median gap against n with its quartiles as a band, one line per engine.

    Columns: label (of the engine), solver, n, gap, gap_q25, gap_q75, order (of the fit).
    """
    orders = [
        f"{label}, p = {digits(3)(order)}" if order == order else label
        for label, order in zip(table["label"], table["order"], strict=True)
    ]
    _plot_engines(ax, table.assign(label=orders), "n", palette)
    steps = sorted(table["n"].unique())
    ax.set_xlabel("steps n")
    ax.set_xticks(steps, [str(n) for n in steps])
    ax.minorticks_off()


def _plot_engines(ax: Axes, table: pd.DataFrame, x: str, palette: Palette) -> None:
    """The engines' lines, later ones thinner: they coincide where only the steps decide."""
    looks = palette.looks(table["solver"])
    top = 3 * table["gap"].max()
    groups = table.sort_values("n").groupby("solver", sort=True)
    for place, (solver, group) in enumerate(groups):
        look = looks[str(solver)]
        high = group["gap_q75"].clip(upper=top).to_numpy(np.float64)
        low = group["gap_q25"].clip(lower=table["gap"].min() / 3).to_numpy(np.float64)
        ax.fill_between(group[x], low, high, color=look.colour, alpha=0.14, linewidth=0)
        line: Style = {"color": look.colour, "linestyle": LINES[place % len(LINES)]}
        mark: Style = {"marker": look.marker, "markersize": 4 + 1.2 * place}
        mark |= {"markerfacecolor": "none"}
        ax.plot(group[x], group["gap"], **line, **mark, label=group["label"].iloc[0])
    ax.set(xscale="log", yscale="log", ylabel="gap to the shortest length")
    log_axis(ax.yaxis)


def discretisation_section(results: Results) -> Section | None:
    """Time against gap by n and engine, gap against n with the fitted order."""
    table = work_precision(results.rows, results.settings)
    if table.empty:
        return None
    drawable = table[np.isfinite(table["gap"]) & (table["gap"] > 0)]  # the axes are logarithmic
    labels = labels_of(results)
    names = figure_names({spec: label_without(labels[spec], "n") for spec in drawable["solver"]})
    named = drawable.assign(label=[_short(names[spec]) for spec in drawable["solver"]])
    pictures = _precision_pictures(named, Palette.of_page(results)) if len(named) else ()
    blocks = (*pictures, _precision_table(table))
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


_BAND = "a line of medians, with the quartiles over the targets as a band"


def _precision_pictures(table: pd.DataFrame, palette: Palette) -> tuple[Picture, Picture]:
    return (
        picture(
            "work-precision",
            plot_work_precision,
            *(table, palette),
            caption=f"Gap against median time: {_BAND}; the numbers are n. Lower left is better.",
            alt="Time against gap for each engine",
            height=3.7,
            legend=2,
        ),
        picture(
            "gap-order",
            plot_gap_order,
            *(table, palette),
            caption=f"Gap against the number of steps: {_BAND}, and the order p fitted to the "
            "medians as far as they fall: beyond their least value the engine's own accuracy "
            "decides.",
            alt="Gap against number of steps for each engine",
            height=3.7,
            legend=2,
        ),
    )


def _precision_table(frame: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="code", engine="engine"),
        *columns(count, n="n", attempts="attempts"),
        *columns(share, arrived="arrive", success="success"),
        *columns(digits(3), gap="median gap", gap_q90="90 %"),
        *columns(seconds, wall_s="median time"),
        *columns(digits(3), iterations="QPs"),
    )
    caption = (
        "Every engine at every n. Gap quantiles count an attempt that does not arrive as ∞. QPs: "
        "median number of QPs solved in one attempt."
    )
    return Table("discretisation", caption, frame, shown)


TOPIC = Topic("work and precision", discretisation_section, "discretisation")
