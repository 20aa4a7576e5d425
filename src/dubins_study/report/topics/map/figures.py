"""Maps of the target plane, cell by cell, for attempts too many to draw one by one."""

from __future__ import annotations

from matplotlib.axes import Axes

from dubins_study.report.data.plane_map import REACH, WORDS, FloatArray
from dubins_study.report.elements import plane_axes
from dubins_study.report.elements.style import MAP_PAPER

_EXTENT = (-REACH, REACH, -REACH, REACH)


def plot_frequent_words(ax: Axes, words: FloatArray, centres: FloatArray) -> None:
    """The word that most answers of a cell have.

    Args:
        ax: where to draw.
        words: shape (cells, cells), from `frequent_words`.
        centres: shape (cells,), of the cells along either axis.
    """
    plane_axes.plot_word_cells(ax, words, _EXTENT)
    for place, word in enumerate(WORDS[: len(plane_axes.WORD_COLOURS)]):
        plane_axes.label_region(ax, centres, centres, words == place, word)
    plane_axes.draw_circles(ax, centres, centres)


def plot_ranges(ax: Axes, ranges: FloatArray) -> None:
    """Draw the range of lengths within each cell, divided by R.

    Args:
        ax: where to draw.
        ranges: shape (cells, cells), from `length_ranges`.
    """
    image = ax.imshow(
        ranges, origin="lower", extent=_EXTENT, cmap="cividis", interpolation="nearest", vmin=0
    )
    # The circles are not drawn: the jumps show them, and lines would hide the jumps.
    ax.plot(0, 0, marker="o", color=MAP_PAPER, markersize=3)
    ax.set(xlabel="target x / R", ylabel="target y / R", aspect="equal")
    ax.grid(False)
    plane_axes.add_colour_bar(ax, image, "largest less least length in a cell / R")
