"""Length, word and time against the turning radius, for one start and target."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from dubins_study.report.data.attempts import SUCCESSES
from dubins_study.report.page.content import digits
from dubins_study.report.page.style import (
    INK,
    LINES,
    MUTED,
    duration,
    log_axis,
    looks,
    name_of,
    plain_log_axis,
)
from dubins_study.report.statistics.metrics import runs_of, solver_order
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario

WARM = ", warm"
_WORD_SHADE = {"LS": 0.06, "RS": 0.12, "RL": 0.22, "LR": 0.3}


def plot_length(ax: Axes, rows: pd.DataFrame, circle: float) -> None:
    """The shortest length over radius, its words, and every answer that is not the shortest.

    Columns: solver, branch, radius, length, reference, reference_word, verdict. The line breaks where
    the word changes, since the length may jump there.
    """
    best = rows[rows["branch"] == "best"]
    exact = best[best["reference_word"].notna()].sort_values("radius").drop_duplicates("radius")
    radii, lengths = exact["radius"].to_numpy(), _bare(rows, exact)
    low, high = radii.min(), radii.max()
    ax.set(xscale="log", xlim=(low, high))
    plain_log_axis(ax.xaxis)
    for first, past, word in runs_of(exact["reference_word"].tolist()):
        left = low if first == 0 else math.sqrt(radii[first - 1] * radii[first])
        right = high if past == len(radii) else math.sqrt(radii[past - 1] * radii[past])
        shade = _WORD_SHADE.get(word, 0.02)
        ax.axvspan(left, right, color=MUTED, alpha=shade, linewidth=0, zorder=0)
        middle = math.sqrt(left * right)
        ax.text(middle, 0.97, word, transform=ax.get_xaxis_transform(), va="top", ha="center")
        ax.plot(radii[first:past], lengths[first:past], color=INK, zorder=3)
    for branch, line in (("LS", LINES[1]), ("RS", LINES[2])):
        r, only = one_word(rows.iloc[0], branch, low, high)
        ax.plot(r, only, color=MUTED, linestyle=line, linewidth=0.9, zorder=2)
    _wrong_answers(ax, best)
    _circle_mark(ax, circle)
    top, foot = np.nanmax([lengths.max(), best["length"].max()]), lengths.min()
    ax.set_ylabel("length")
    if foot > 0:  # a logarithmic scale shows the jump beside lengths that grow with the radius
        ax.set(yscale="log", ylim=(0.75 * foot, top * (top / foot) ** 0.15 * 1.2))
        plain_log_axis(ax.yaxis)
    else:
        ax.set_ylim(0, 1.22 * top or 1.0)
        ax.yaxis.set_major_locator(MaxNLocator(5))


def one_word(row: pd.Series, branch: str, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Radii from `low` to `high` and the length of one word there, NaN where it does not exist."""
    radii = np.geomspace(low, high, 300)
    where: dict[str, Any] = {
        key: float(row[key]) for key in ("x", "y", "heading", "target_x", "target_y")
    }
    found = [shortest(Scenario(**where, radius=radius), branch) for radius in radii]
    lengths = [np.nan if word is None else word.total for word in found]
    return radii, np.array(lengths) * radii


def _bare(rows: pd.DataFrame, exact: pd.DataFrame) -> np.ndarray:
    """The shortest length at each radius; the closed form's own where there is one."""
    own = rows[(rows["solver"] == "analytic") & (rows["branch"] == "best")]
    known = own.drop_duplicates("radius").set_index("radius")["length"]
    return exact["radius"].map(known).fillna(exact["reference"]).to_numpy(dtype=np.float64)


def _wrong_answers(ax: Axes, best: pd.DataFrame) -> None:
    wrong = best[~best["verdict"].isin(SUCCESSES)]
    style = looks(best["solver"].tolist())
    for solver in solver_order(wrong["solver"].tolist()):
        own = wrong[wrong["solver"] == solver]
        drawn, lost = own[own["gap"].notna()], own[own["gap"].isna()]
        dots = style[solver].dots | {"markersize": 3.5, "markerfacecolor": "none", "zorder": 4}
        ax.plot(drawn["radius"], drawn["length"], **dots)
        if len(lost):  # an empty line off the data's axes would upset the layout
            foot = np.full(len(lost), 0.03)
            dots |= {"marker": "x"}
            ax.plot(lost["radius"], foot, transform=ax.get_xaxis_transform(), **dots)


def plot_time(ax: Axes, rows: pd.DataFrame, circle: float) -> None:
    """Whole time of each solver over radius, cold solid and warm dotted.

    Columns: solver, branch, start, radius, wall_s (s).
    """
    best = rows[(rows["branch"] == "best") & rows["wall_s"].notna()]
    style = looks(rows["solver"].tolist())
    for place, solver in enumerate(solver_order(best["solver"].tolist())):
        for start, line in (("cold", LINES[0]), ("warm", LINES[2])):
            own = best[(best["solver"] == solver) & (best["initial_guess"] == start)]
            if own.empty:
                continue
            median = own.groupby("radius")["wall_s"].median()
            ax.plot(
                median.index,
                median,
                **style[solver].curve(place) | {"linestyle": line, "linewidth": 1.1},
                label=name_of(solver) + (WARM if start == "warm" else ""),
            )
    ax.set(yscale="log", ylabel="time", xlabel="turning radius R")
    log_axis(ax.yaxis, duration)
    plain_log_axis(ax.xaxis)
    if _on_axis(ax, circle):
        ax.axvline(circle, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))


def _on_axis(ax: Axes, radius: float) -> bool:
    low, high = ax.get_xlim()
    return low < radius < high  # a target straight ahead has no such radius


def _circle_mark(ax: Axes, circle: float) -> None:
    if not _on_axis(ax, circle):
        return
    ax.axvline(circle, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))
    ax.text(
        circle,
        1.02,
        f"R* = {digits(4)(circle)}",
        transform=ax.get_xaxis_transform(),
        ha="center",
        fontsize=8,
        color=MUTED,
    )
