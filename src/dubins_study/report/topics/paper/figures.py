"""Paths in the plane: the paper's Figures 6.1-6.5."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES
from dubins_study.report.elements.style import BLUE, GREEN, INK, MUTED, PAPER, RULE, VERMILION
from dubins_study.study.path import Path

_BY_RANK = ((BLUE, "-"), (VERMILION, LINES[1]))
_BY_RADIUS = (BLUE, VERMILION, GREEN)


def plot_paths(
    ax: Axes, paths: pd.DataFrame, names: Sequence[str] = ("optimal", "feasible")
) -> None:
    """Paths to one target, with both turning circles of every start, start arrow and target.

    Columns: branch, path (`study.path.Path`), length, rank (1 the shortest), target_x, target_y,
    radius. With several radii the colours tell these apart, otherwise the rank, by its name.
    """
    radii = sorted(paths["radius"].unique(), reverse=True)
    drawn: set[float] = set()
    for row in paths.sort_values(["radius", "rank"], ascending=[False, True]).to_dict("records"):
        path, radius, rank = row["path"], row["radius"], int(row["rank"]) - 1
        if radius not in drawn:
            _turning_circles(ax, path, radius)
            drawn.add(radius)
        if len(radii) > 1:
            place = radii.index(radius)
            colour, line = _BY_RADIUS[place % 3], LINES[place % len(LINES)]
            text = f"R = {radius:g}: {row['branch']}, {digits(4)(row['length'])}"
        else:
            colour, line = _BY_RANK[rank]
            text = f"{names[rank]}: {row['branch']}, {digits(4)(row['length'])}"
        points = path.sample(400)
        ax.plot(points[:, 0], points[:, 1], color=colour, linestyle=line, label=text, zorder=3)
    first = paths.iloc[0]
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.07)
    _start_and_target(ax, first["path"], first["target_x"], first["target_y"])
    ax.set(xlabel="x", ylabel="y")
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2)


def aspect_of(paths: pd.DataFrame) -> float:
    """Height over width of what `plot_paths` draws."""
    points = np.vstack([path.sample(200)[:, :2] for path in paths["path"]])
    path, radius = paths.iloc[0]["path"], paths["radius"].max()
    x, y, heading = path.start
    for side in (radius, -radius):
        centre = np.array((x - side * math.sin(heading), y + side * math.cos(heading)))
        points = np.vstack((points, centre - radius, centre + radius))
    width, height = np.ptp(points, axis=0)
    return float(height / width)


def _turning_circles(ax: Axes, path: Path, radius: float) -> None:
    x, y, heading = path.start
    for side in (1, -1):
        centre = (x - side * radius * math.sin(heading), y + side * radius * math.cos(heading))
        ax.add_patch(Circle(centre, radius, fill=False, edgecolor=RULE, linewidth=0.8, zorder=1))


def _start_and_target(ax: Axes, path: Path, target_x: float, target_y: float) -> None:
    x, y, heading = path.start
    low, high = np.array(ax.dataLim.min), np.array(ax.dataLim.max)
    reach = 0.11 * float(np.max(high - low))
    tip = (x + reach * math.cos(heading), y + reach * math.sin(heading))
    head = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=tip, xytext=(x, y), arrowprops=head, zorder=5)
    ax.plot(x, y, marker="o", color=INK, markersize=3.5, zorder=5)
    ring: dict[str, Any] = {"markersize": 7, "markerfacecolor": PAPER, "markeredgecolor": MUTED}
    ax.plot(target_x, target_y, marker="o", markeredgewidth=1.2, zorder=4, **ring)
    ax.plot(target_x, target_y, marker="o", color=INK, markersize=2.5, zorder=5)
