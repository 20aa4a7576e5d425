"""Maps over the target plane: the vehicle at the origin, heading along +x, radius 1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap
from matplotlib.patches import Arc, Circle
from numpy.typing import NDArray

from dubins_study.report.data.attempts import SUCCESSES
from dubins_study.report.page.style import (
    BLUE,
    INK,
    MAP_PAPER,
    MUTED,
    ON_MAP,
    ORANGE,
    RULE,
    VERMILION,
)

# a light and a dark shade of two hues: apart in hue for the eye, apart in lightness for grey
WORD_COLOURS = {"LS": "#cfe3f1", "RS": "#fbe6c8", "RL": "#5d9cc6", "LR": "#d69a3c"}
_HATCHES = {"LS": "", "RS": "", "RL": "////", "LR": "\\\\\\\\"}
OTHER = "#8a8f96"


def grid_of(rows: pd.DataFrame, column: str) -> tuple[NDArray[np.float64], ...]:
    """x of shape (n,), y of shape (m,) and the column's values of shape (m, n); NaN where none."""
    table = rows.pivot_table(index="target_y", columns="target_x", values=column, aggfunc="first")
    x = table.columns.to_numpy(dtype=np.float64)
    y = table.index.to_numpy(dtype=np.float64)
    return x, y, table.to_numpy(dtype=np.float64)


def _extent(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float, float, float]:
    dx, dy = (x[-1] - x[0]) / (x.size - 1) / 2, (y[-1] - y[0]) / (y.size - 1) / 2
    return x[0] - dx, x[-1] + dx, y[0] - dy, y[-1] + dy


def plot_words(ax: Axes, rows: pd.DataFrame) -> None:
    """Which word is shortest where. Columns: target_x, target_y, word (on a grid)."""
    codes = {word: float(i) for i, word in enumerate(WORD_COLOURS)}
    other = float(len(WORD_COLOURS))
    known = rows.assign(code=rows["word"].map(lambda word: codes.get(word, other)))
    x, y, code = grid_of(known, "code")
    colours = ListedColormap([*WORD_COLOURS.values(), OTHER])
    ax.imshow(
        code,
        origin="lower",
        extent=_extent(x, y),
        cmap=colours,
        vmin=-0.5,
        vmax=len(WORD_COLOURS) + 0.5,
        interpolation="nearest",
    )
    for word, value in codes.items():
        inside = code == value
        if not inside.any():
            continue
        if _HATCHES[word]:
            hatch = ax.contourf(
                x,
                y,
                inside.astype(float),
                levels=[0.5, 1.5],
                colors="none",
                hatches=[_HATCHES[word]],
            )
            hatch.set_edgecolor("#ffffff80")
            hatch.set_linewidth(0)
        row, column = deepest(inside)
        box = {"facecolor": MAP_PAPER, "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
        ax.text(
            x[column], y[row], word, ha="center", va="center", fontsize=10, bbox=box, color=ON_MAP
        )
    frame(ax, x, y)


def deepest(inside: NDArray[np.bool_]) -> tuple[int, int]:
    """The cell farthest from the edge of its region: where a label has most room."""
    depth = np.zeros(inside.shape, dtype=int)
    left = np.pad(inside, 1)
    while left.any():
        depth += left[1:-1, 1:-1]
        left[1:-1, 1:-1] &= left[:-2, 1:-1] & left[2:, 1:-1] & left[1:-1, :-2] & left[1:-1, 2:]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    return int(row), int(column)


def plot_lengths(ax: Axes, rows: pd.DataFrame) -> ScalarMappable:
    """The shortest length, with contours that break where it jumps; returns what is to be scaled.

    Columns: target_x, target_y, length, region (on a grid), radius.
    """
    x, y, length = grid_of(rows, "length")
    inside = rows.assign(inside=rows["region"].isin(["left disc", "right disc"]).astype(float))
    _, _, disc = grid_of(inside, "inside")
    image = ax.imshow(
        length, origin="lower", extent=_extent(x, y), cmap="cividis", interpolation="nearest"
    )
    levels = np.arange(math.floor(np.nanmin(length)), math.ceil(np.nanmax(length)) + 1)
    for part in (disc > 0.5, disc <= 0.5):  # a contour across the jump would be none
        values = np.where(part, length, np.nan)
        if np.isfinite(values).sum() > 4:
            lines = ax.contour(x, y, values, levels=levels, colors="white", linewidths=0.6)
            ax.clabel(lines, levels[::2], fmt=lambda v: f"{v:g}", fontsize=7, inline_spacing=2)
    frame(ax, x, y)
    return image


def frame(ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], ink: str = ON_MAP) -> None:
    """Turning circles, the half that jumps drawn heavily, and the start."""
    for side in (1, -1):
        ax.add_patch(Circle((0, side), 1, fill=False, edgecolor=ink, linewidth=0.6))
        ax.add_patch(Arc((0, side), 2, 2, theta1=-90, theta2=90, color=ink, linewidth=1.8))
    head = {"arrowstyle": "-|>", "color": ink, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(0.75, 0), xytext=(0, 0), arrowprops=head)
    ax.plot(0, 0, marker="o", color=ink, markersize=3)
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel="target x / R", ylabel="target y / R")
    ax.set_aspect("equal")
    ax.grid(False)


def along_circle(rows: pd.DataFrame) -> pd.DataFrame:
    """Targets within one grid step of a turning circle, by where on it they lie.

    Columns: angle (arc angle from the start to there, deg), side (`inside`, `outside`), length.
    """
    xs = np.sort(rows["target_x"].unique())
    near = rows[rows["margin"] <= np.diff(xs).min()]
    angle = np.arctan2(near["target_x"], 1 - near["target_y"].abs())
    disc = near["region"].isin(["left disc", "right disc"])
    return pd.DataFrame(
        {
            "angle": np.degrees(angle) % 360,
            "side": np.where(disc, "inside", "outside"),
            "length": near["length"],
        }
    ).sort_values("angle")


def plot_jump(ax: Axes, table: pd.DataFrame) -> None:
    """Length on both sides of a turning circle. Columns of `along_circle`."""
    looks_of = {"inside": (VERMILION, "x", 6), "outside": (BLUE, ".", -12)}
    for side, (colour, marker, lift) in looks_of.items():
        own = table[table["side"] == side]
        ax.plot(own["angle"], own["length"], marker, color=colour, markersize=2.5)
        at = own.iloc[(own["angle"] - 110).abs().argmin()] if len(own) else None
        if at is not None:
            ax.annotate(
                f"just {side}",
                (at["angle"], at["length"]),
                xytext=(0, lift),
                textcoords="offset points",
                color=colour,
                ha="left",
            )
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
    """One solver's answers on a grid: dots where right, marks by verdict where not.

    Columns: target_x, target_y, verdict.
    """
    right = rows[rows["verdict"].isin(SUCCESSES)]
    ax.plot(right["target_x"], right["target_y"], ".", color=MUTED, markersize=1.5, label="right")
    for verdict, look in _WRONG.items():
        own = rows[rows["verdict"] == verdict]
        if len(own):
            mark: dict[str, Any] = {"linestyle": "none", "markersize": 4.0, **look}
            text = f"{verdict} ({len(own)})"
            ax.plot(own["target_x"], own["target_y"], markerfacecolor="none", label=text, **mark)
    x, y = np.sort(rows["target_x"].unique()), np.sort(rows["target_y"].unique())
    frame(ax, x.astype(np.float64), y.astype(np.float64), INK)
