"""The section on the target plane of results with too many attempts to draw one by one."""

from __future__ import annotations

from dubins_study.report.data.plane_map import CELLS, REACH, PlaneMap
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, picture
from dubins_study.report.elements.formats import count, slug
from dubins_study.report.elements.topic import General, Topic
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
