"""Figures of two compared runs."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis, only_grid, plain_log_axis
from dubins_study.report.elements.content import Picture, picture
from dubins_study.report.elements.style import BLUE, INK, MUTED, VERMILION, WIDE, new_figure
from dubins_study.report.two_runs.comparison import Comparison

# More solvers than these have no line of their own: those that changed most are drawn.
_MOST = 24
_LINE, _MARGINS = 0.22, 1.0  # inches
_WIDE_RANGE = 5  # ratios of times that differ by more need a logarithmic axis
_LONGEST = 48  # characters of a name


def changes_picture(frame: pd.DataFrame) -> Picture:
    """Change of success and ratio of times, one line per solver, with intervals."""
    change = frame["right_change"].abs().fillna(0) * 100 + np.log(frame["time_ratio"]).abs().fillna(
        0
    )
    drawn = frame.loc[change.sort_values(ascending=False, kind="stable").index[:_MOST]].sort_index()
    left_out = len(frame) - len(drawn)
    caption = (
        "Left: change of the share of right answers, in percentage points; right: time of the new "
        "run by the base's, with 95 % intervals. Triangles: an interval that does not meet the "
        "vertical line, of a solver whose code changed."
        + (f" The {left_out} solvers that changed least are not drawn." if left_out else "")
    )
    figure = new_figure(WIDE, min(7.0, _MARGINS + _LINE * len(drawn)))
    change_ax, ratio_ax = figure.subplots(1, 2, sharey=True)
    _plot_intervals(change_ax, drawn, "right_change", 100.0, 0.0)
    _plot_intervals(ratio_ax, drawn, "time_ratio", 1.0, 1.0)
    change_ax.set(xlabel="change of right answers, percentage points")
    ratio_ax.set(xlabel="time, new / base")
    if drawn["time_ratio"].max() > _WIDE_RANGE * drawn["time_ratio"].min():
        ratio_ax.set_xscale("log")
        plain_log_axis(ratio_ax.xaxis)
    names = [str(solver)[:_LONGEST] for solver in drawn["solver"]]
    change_ax.set_yticks(np.arange(len(drawn))[::-1], names, fontsize=7)
    change_ax.set_ylim(-0.6, len(drawn) - 0.4)
    alt = "change of success and ratio of times, one line per solver"
    return Picture("changes", caption, figure, alt)


def _plot_intervals(
    ax: Axes, frame: pd.DataFrame, key: str, scale: float, unchanged: float
) -> None:
    """One line per solver; an interval beyond `unchanged` is coloured and has another marker.

    More right answers are better, more time is worse.
    """
    middle, low, high = ((frame[f"{key}{end}"] * scale).to_numpy() for end in ("", "_low", "_high"))
    below, above = high < unchanged, low > unchanged
    worse, better = (below, above) if key == "right_change" else (above, below)
    if key == "time_ratio":  # what became of the same code is the machine's doing
        changed = ~frame["same_code"].to_numpy(bool)
        worse, better = worse & changed, better & changed
    places = np.arange(len(frame))[::-1]
    looks = ((worse, VERMILION, "v"), (better, BLUE, "^"), (~(worse | better), MUTED, "o"))
    for chosen, colour, marker in looks:
        ax.hlines(places[chosen], low[chosen], high[chosen], colors=colour, linewidth=1.6)
        ax.scatter(middle[chosen], places[chosen], c=colour, marker=marker, s=20, zorder=3)
    ax.axvline(unchanged, color=INK, linewidth=0.8)
    only_grid(ax, "x")


def times_picture(pairs: pd.DataFrame, comparison: Comparison) -> Picture | None:
    """Every question's time in the new run against the base; None if none was timed in both."""
    both = pairs[pairs["time_base"].gt(0) & pairs["time_new"].gt(0)]
    if both.empty:
        return None
    slower = comparison.regressions.query("kind == 'slower'")["solver"]
    caption = (
        "Each dot is a question of one solver: its time in the new run against the base's. "
        "Solid: equally long; dashed: what the machine explains. Triangles: a slower solver."
    )
    return picture(
        "times-pairs",
        _plot_times,
        both,
        set(slower),
        1.0 if comparison.speed is None else comparison.speed.ratio,
        caption=caption,
        alt="times of questions in two runs",
        height=4.5,
        width=WIDE,
    )


def _plot_times(ax: Axes, both: pd.DataFrame, slower: set[str], machine: float) -> None:
    apart = both["solver"].isin(slower)
    looks = ((~apart, MUTED, "o", 0.35), (apart, VERMILION, "^", 0.7))
    for flag, colour, marker, alpha in looks:
        ax.scatter(
            both.loc[flag, "time_base"],
            both.loc[flag, "time_new"],
            c=colour,
            marker=marker,
            alpha=alpha,
            s=8,
            linewidths=0,
            rasterized=True,
        )
    ends = np.array(
        [both[["time_base", "time_new"]].min().min(), both[["time_base", "time_new"]].max().max()]
    )
    ax.plot(ends, ends, color=INK, linewidth=0.8)
    ax.plot(ends, ends * machine, color=INK, linewidth=0.8, linestyle="--")
    ax.set(xscale="log", yscale="log", xlabel="time in the base", ylabel="time in the new run")
    for axis in (ax.xaxis, ax.yaxis):
        log_axis(axis, duration)
