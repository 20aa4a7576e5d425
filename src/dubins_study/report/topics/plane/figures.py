"""Maps over the target plane: the vehicle at the origin, heading along +x, radius 1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import NDArray

from dubins_study.report.elements import plane_axes
from dubins_study.report.elements.style import BLUE, INK, MUTED, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.metrics import success
from dubins_study.report.topics.plane.numbers import grid_of

_HATCHES = {"LS": "", "RS": "", "RL": "////", "LR": "\\\\\\\\"}


def _extent(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float, float, float]:
    dx, dy = (x[-1] - x[0]) / (x.size - 1) / 2, (y[-1] - y[0]) / (y.size - 1) / 2
    return x[0] - dx, x[-1] + dx, y[0] - dy, y[-1] + dy


def plot_words(ax: Axes, rows: pd.DataFrame) -> None:
    """Draw the shortest word of each target. Columns: target_x, target_y, word (on a grid)."""
    codes = {word: float(i) for i, word in enumerate(plane_axes.WORD_COLOURS)}
    other = float(len(plane_axes.WORD_COLOURS))
    known = rows.assign(code=rows["word"].map(lambda word: codes.get(word, other)))
    x, y, code = grid_of(known, "code")
    plane_axes.plot_word_cells(ax, code, _extent(x, y))
    for word, value in codes.items():
        inside = code == value
        if inside.any() and _HATCHES[word]:
            style: dict[str, Any] = {"colors": "none", "hatches": [_HATCHES[word]]}
            hatch = ax.contourf(x, y, inside.astype(float), levels=[0.5, 1.5], **style)
            hatch.set_edgecolor("#ffffff80")
            hatch.set_linewidth(0)
        plane_axes.label_region(ax, x, y, inside, word)
    plane_axes.draw_circles(ax, x, y)


def plot_lengths(ax: Axes, rows: pd.DataFrame) -> None:
    """The shortest length, with contours that break where it jumps.

    Columns: target_x, target_y, length, region (on a grid), radius.
    """
    x, y, length = grid_of(rows, "length")
    inside = rows.assign(inside=rows["region"].isin(["left disc", "right disc"]).astype(float))
    _, _, disc = grid_of(inside, "inside")
    image = ax.imshow(
        length, origin="lower", extent=_extent(x, y), cmap="cividis", interpolation="nearest"
    )
    levels = np.arange(math.floor(np.nanmin(length)), math.ceil(np.nanmax(length)) + 1)
    for part in (disc > 0.5, disc <= 0.5):  # separately, since a contour must not cross the jump
        values = np.where(part, length, np.nan)
        if np.isfinite(values).sum() > 4:
            lines = ax.contour(x, y, values, levels=levels, colors="white", linewidths=0.6)
            ax.clabel(lines, levels[::2], fmt=lambda v: f"{v:g}", fontsize=7, inline_spacing=2)
    plane_axes.draw_circles(ax, x, y)
    plane_axes.add_colour_bar(ax, image, "shortest length / R")


def plot_jump(ax: Axes, table: pd.DataFrame) -> None:
    """Length on both sides of a turning circle. Columns of `along_circle`."""
    sides = {"inside": (VERMILION, "x", 6), "outside": (BLUE, ".", -12)}
    for side, (colour, marker, lift) in sides.items():
        group = table[table["side"] == side]
        ax.plot(group["angle"], group["length"], marker, color=colour, markersize=2.5)
        at = group.iloc[(group["angle"] - 110).abs().argmin()] if len(group) else None
        if at is not None:
            text: dict[str, Any] = {"textcoords": "offset points", "ha": "left"}
            point = (at["angle"], at["length"])
            ax.annotate(f"just {side}", point, xytext=(0, lift), color=colour, **text)
    ax.axvspan(0, 180, color=RULE, alpha=0.35, linewidth=0)
    ax.text(90, 0.02, "front half", transform=ax.get_xaxis_transform(), ha="center", color=MUTED)
    ax.set(xlim=(0, 360), ylim=(0, 7.4), xlabel="arc angle to the point of the circle (deg)")
    ax.set(ylabel="shortest length / R")
    ax.set_xticks([0, 90, 180, 270, 360])


_WRONG: dict[str, dict[str, Any]] = {
    "longer": {"marker": "^", "color": ORANGE},
    "misses": {"marker": "x", "color": VERMILION},
    "none": {"marker": "s", "color": BLUE, "markersize": 3.0},
}


def plot_failures(ax: Axes, rows: pd.DataFrame) -> None:
    """Draw one solver's answers on a grid: a dot for a right answer, else a mark for the verdict.

    Columns: target_x, target_y, verdict, presolved.
    """
    right = rows[success(rows)]
    ax.plot(right["target_x"], right["target_y"], ".", color=MUTED, markersize=1.5, label="right")
    for verdict, look in _WRONG.items():
        group = rows[rows["verdict"] == verdict]
        if len(group):
            mark: dict[str, Any] = {"linestyle": "none", "markersize": 4.0, **look}
            text = f"{verdict} ({len(group)})"
            mark |= {"markerfacecolor": "none", "label": text}
            ax.plot(group["target_x"], group["target_y"], **mark)
    x, y = np.sort(rows["target_x"].unique()), np.sort(rows["target_y"].unique())
    plane_axes.draw_circles(ax, x.astype(np.float64), y.astype(np.float64), INK)
