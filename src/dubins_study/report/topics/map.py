"""The section on the target plane of results with too many attempts to draw one by one."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from dubins_study.report.data.plane_map import CELLS, REACH, WORDS, FloatArray, PlaneMap
from dubins_study.report.data.results import Results
from dubins_study.report.elements import plane_axes
from dubins_study.report.elements.content import Picture, Section, picture
from dubins_study.report.elements.formats import count, slug
from dubins_study.report.elements.style import MAP_PAPER
from dubins_study.report.elements.topic import General, Topic


def frequent_words(plane: PlaneMap) -> FloatArray:
    """Index in `WORDS` of each cell's most frequent word, shape (cells, cells); NaN if empty."""
    return np.where(plane.counts.sum(axis=0) > 0, plane.counts.argmax(axis=0), np.nan)


def length_ranges(plane: PlaneMap) -> FloatArray:
    """(Largest - smallest length) / R per cell, shape (cells, cells); NaN below two attempts."""
    known = plane.counts.sum(axis=0) > 1
    empty = np.full(known.shape, np.nan)
    return np.subtract(plane.largest, plane.least, where=known, out=empty)


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


_FEWEST = 10 * CELLS**2  # attempts; below that most cells say little


def map_section(results: Results) -> Section | None:
    """Two maps for each experiment whose targets fill the plane around the start."""
    if not results.sampled:
        return None  # every attempt can be drawn
    pictures: list[Picture] = []
    for experiment, plane in results.attempts.planes().items():
        if plane.counts.sum() >= _FEWEST:
            pictures += [_words(experiment, plane), _ranges(experiment, plane)]
    if not pictures:
        return None
    text = (
        f"Where the closed form's targets lie, seen from the vehicle and in radii, counted in "
        f"{CELLS} × {CELLS} cells up to {REACH:g} R from the start: every attempt at the branch "
        "best counts."
    )
    lead = "Compare the two maps: the length jumps only where a circle's front half divides words."
    return Section("map", "The plane, counted", text, tuple(pictures), lead)


def _words(experiment: str, plane: PlaneMap) -> Picture:
    caption = (
        f"Experiment {experiment}: the most frequent shortest word of each cell, of "
        f"{count(plane.counts.sum())} attempts. Lengths in R."
    )
    name, alt = f"map-words-{slug(experiment)}", f"Map of shortest words, {experiment}"
    data = frequent_words(plane), plane.centres
    return picture(name, plot_frequent_words, *data, caption=caption, alt=alt, height=3.5)


def _ranges(experiment: str, plane: PlaneMap) -> Picture:
    caption = (
        f"Experiment {experiment}: by how much the shortest lengths within one cell differ. Across "
        "the front halves of the turning circles they jump, elsewhere they change no faster than "
        "the target moves."
    )
    name, alt = f"map-ranges-{slug(experiment)}", f"Map of jumps in length, {experiment}"
    return picture(name, plot_ranges, length_ranges(plane), caption=caption, alt=alt, height=4.1)


TOPIC = Topic("the plane, counted", map_section, General.EVERY, counted=True)
