"""The target plane of more attempts than could be drawn one by one, cell by cell."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap

from dubins_study.report.data.attempts import REACH
from dubins_study.report.page.style import MAP_PAPER, ON_MAP
from dubins_study.report.topics.map.numbers import WORDS, PlaneMap
from dubins_study.report.topics.plane.figures import OTHER, WORD_COLOURS, deepest, frame

_EXTENT = (-REACH, REACH, -REACH, REACH)


def plot_frequent_words(ax: Axes, plane: PlaneMap) -> None:
    """The word that most of a cell's answers have; empty where there is none."""
    most = np.where(plane.counts.sum(axis=0) > 0, plane.counts.argmax(axis=0), np.nan)
    colours = ListedColormap([*WORD_COLOURS.values(), OTHER])
    ax.imshow(
        most,
        origin="lower",
        extent=_EXTENT,
        cmap=colours,
        vmin=-0.5,
        vmax=len(WORDS) - 0.5,
        interpolation="nearest",
    )
    at = plane.centres
    for place, word in enumerate(WORDS[: len(WORD_COLOURS)]):
        if (most == place).any():
            row, column = deepest(most == place)
            box = {"facecolor": MAP_PAPER, "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
            ax.text(at[column], at[row], word, ha="center", va="center", bbox=box, color=ON_MAP)
    frame(ax, at, at)


def plot_ranges(ax: Axes, plane: PlaneMap) -> ScalarMappable:
    """By how much lengths differ within a cell, over R; returns what is to be scaled."""
    known = plane.counts.sum(axis=0) > 1
    span = np.subtract(plane.largest, plane.least, where=known, out=np.full(known.shape, np.nan))
    image = ax.imshow(
        span, origin="lower", extent=_EXTENT, cmap="cividis", interpolation="nearest", vmin=0
    )
    # the circles show by themselves: drawn lines would hide the jumps across them
    ax.plot(0, 0, marker="o", color=MAP_PAPER, markersize=3)
    ax.set(xlabel="target x / R", ylabel="target y / R", aspect="equal")
    ax.grid(False)
    return image
