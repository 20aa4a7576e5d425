"""Shared elements of maps over the target plane: colours of words, labels, turning circles.

The vehicle stands at the origin and heads along +x; its turning radius is 1.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap
from matplotlib.patches import Arc, Circle
from numpy.typing import NDArray

from dubins_study.report.elements.style import MAP_PAPER, ON_MAP, Style

# A light and a dark shade of two hues: the shades differ in grey print too.
WORD_COLOURS = {"LS": "#cfe3f1", "RS": "#fbe6c8", "RL": "#5d9cc6", "LR": "#d69a3c"}
OTHER_COLOUR = "#8a8f96"


def plot_word_cells(
    ax: Axes, words: NDArray[np.float64], extent: tuple[float, float, float, float]
) -> None:
    """Fill each cell with the colour of its word.

    Args:
        ax: where to draw.
        words: index in `WORD_COLOURS` per cell, the next index for other words, NaN for an empty
            cell; shape (m, n).
        extent: smallest and largest x, smallest and largest y of the cells.
    """
    colours = ListedColormap([*WORD_COLOURS.values(), OTHER_COLOUR])
    limits: Style = {"vmin": -0.5, "vmax": len(WORD_COLOURS) + 0.5}
    ax.imshow(words, origin="lower", extent=extent, cmap=colours, interpolation="nearest", **limits)


def label_region(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], inside: NDArray[np.bool_], text: str
) -> None:
    """Write a word where its region is widest; nothing if the region is empty.

    Args:
        ax: where to draw.
        x, y: coordinates of the grid, shapes (n,) and (m,).
        inside: whether each cell belongs to the region, shape (m, n).
        text: the word.
    """
    if not inside.any():
        return
    row, column = _deepest(inside)
    box = {"facecolor": MAP_PAPER, "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
    ax.text(x[column], y[row], text, ha="center", va="center", bbox=box, color=ON_MAP)


def _deepest(inside: NDArray[np.bool_]) -> tuple[int, int]:
    """Row and column of the cell farthest from the region's edge."""
    depth = np.zeros(inside.shape, dtype=int)
    left = np.pad(inside, 1)
    while left.any():
        depth += left[1:-1, 1:-1]
        left[1:-1, 1:-1] &= left[:-2, 1:-1] & left[2:, 1:-1] & left[1:-1, :-2] & left[1:-1, 2:]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    return int(row), int(column)


def draw_circles(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], ink: str = ON_MAP
) -> None:
    """Draw the turning circles and the start; the half where the length jumps has a heavy line."""
    for side in (1, -1):
        ax.add_patch(Circle((0, side), 1, fill=False, edgecolor=ink, linewidth=0.6))
        ax.add_patch(Arc((0, side), 2, 2, theta1=-90, theta2=90, color=ink, linewidth=1.8))
    head = {"arrowstyle": "-|>", "color": ink, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(0.75, 0), xytext=(0, 0), arrowprops=head)
    ax.plot(0, 0, marker="o", color=ink, markersize=3)
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel="target x / R", ylabel="target y / R")
    ax.set_aspect("equal")
    ax.grid(False)


def add_colour_bar(ax: Axes, image: ScalarMappable, label: str) -> None:
    """Draw the scale of a map's colours below the map."""
    figure = ax.figure
    assert figure is not None
    bar = figure.colorbar(image, ax=ax, location="bottom", shrink=0.7, pad=0.02, aspect=28)
    bar.outline.set_visible(False)
    bar.set_label(label)
