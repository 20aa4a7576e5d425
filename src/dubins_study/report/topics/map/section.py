"""The section on the target plane of results with too many attempts to draw one by one."""

from __future__ import annotations

from dubins_study.report.data.plane_map import CELLS, REACH, PlaneMap
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, count, slug
from dubins_study.report.elements.style import HALF, new_figure
from dubins_study.report.topics.map.figures import plot_frequent_words, plot_ranges
from dubins_study.report.topics.map.numbers import frequent_words, length_ranges

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
    return Section("map", "The plane, counted", text, tuple(pictures))


def _words(experiment: str, plane: PlaneMap) -> Picture:
    figure = new_figure(HALF, 3.5)
    plot_frequent_words(figure.add_subplot(), frequent_words(plane), plane.centres)
    caption = (
        f"Experiment {experiment}: the most frequent shortest word of each cell, of "
        f"{count(plane.counts.sum())} attempts. Lengths in R."
    )
    name = f"map-words-{slug(experiment)}"
    return Picture(name, caption, figure, f"Map of shortest words, {experiment}", True)


def _ranges(experiment: str, plane: PlaneMap) -> Picture:
    figure = new_figure(HALF, 4.1)
    ax = figure.add_subplot()
    image = plot_ranges(ax, length_ranges(plane))
    bar = figure.colorbar(image, ax=ax, location="bottom", shrink=0.7, pad=0.02, aspect=28)
    bar.outline.set_visible(False)
    bar.set_label("largest less least length in a cell / R")
    caption = (
        f"Experiment {experiment}: by how much the shortest lengths within one cell differ. Across "
        "the front halves of the turning circles they jump, elsewhere they change no faster than "
        "the target moves."
    )
    name = f"map-ranges-{slug(experiment)}"
    return Picture(name, caption, figure, f"Map of jumps in length, {experiment}", True)
