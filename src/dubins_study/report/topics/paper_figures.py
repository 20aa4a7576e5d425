"""The paper's Figures 6.1-6.5, drawn from the rows' paths."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from matplotlib.axes import Axes
from matplotlib.patches import Circle

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Place, Section, Topic, picture
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES
from dubins_study.report.elements.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    PAPER,
    RULE,
    VERMILION,
    Style,
)
from dubins_study.report.paper.printed import PROBLEMS, Problem
from dubins_study.report.topics.paper import word_paths
from dubins_study.study.path import Path, outline
from dubins_study.study.scenario import Pose, Scenario

_COLOURS = (BLUE, VERMILION, GREEN)
_TARGET_RING: Style = {
    "markersize": 7,
    "markerfacecolor": PAPER,
    "markeredgecolor": MUTED,
    "zorder": 4,
    "marker": "o",
    "markeredgewidth": 1.2,
}


def labelled(name: str, word: str, path: Path) -> str:
    """A path's entry in a legend."""
    return f"{name}: {word}, {digits(4)(path.length)}"


def plot_paths(
    ax: Axes, paths: Mapping[str, Path], scenario: Scenario, radii: Iterable[float] = ()
) -> None:
    """Draw up to three paths of a scenario.

    `paths` maps an entry of the legend to its path; the legend stands above the panel. Further
    there are the start's arrow, the target, and both turning circles of the start. The circles have
    the radii `radii`, or the scenario's radius if there are none.
    """
    for (text, path), colour, line in zip(paths.items(), _COLOURS, LINES, strict=False):
        points, _ = outline(path)
        ax.plot(points[:, 0], points[:, 1], color=colour, linestyle=line, label=text, zorder=3)
    x, y, heading = scenario.start
    for radius in radii or (scenario.radius,):
        for side in (radius, -radius):
            centre = x - side * math.sin(heading), y + side * math.cos(heading)
            draw_turning_circle(ax, centre, radius)
    plot_start_and_target(ax, scenario.start, scenario.stops[-1][:2])
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.07)
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2)


def draw_turning_circle(ax: Axes, centre: tuple[float, float], radius: float) -> None:
    """Draw a faint circle behind the paths."""
    ax.add_patch(Circle(centre, radius, fill=False, edgecolor=RULE, linewidth=0.8, zorder=1))


def plot_start_and_target(
    ax: Axes, start: Pose, target: tuple[float, float], final_heading: float | None = None
) -> None:
    """Draw the start and the target of a path.

    The start has an arrow, a ninth as long as what is drawn already; the target is a ring. If there
    is a final heading, a second arrow begins at the target.
    """
    reach = max(ax.dataLim.size) / 9
    head = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    for (x, y), heading in ((start[:2], start.heading), (target, final_heading)):
        if heading is not None:
            tip = (x + reach * math.cos(heading), y + reach * math.sin(heading))
            ax.annotate("", xy=tip, xytext=(x, y), arrowprops=head, zorder=5)
    ax.plot(start.x, start.y, marker="o", color=INK, markersize=3.5, zorder=5)
    ax.plot(*target, **_TARGET_RING)
    ax.plot(*target, marker="o", color=INK, markersize=2.5, zorder=5)
    ax.set(xlabel="x", ylabel="y")


def figures_section(results: Results) -> Section | None:
    """The section with Figures 6.1-6.5."""
    paths_of_words = word_paths(results)
    if not paths_of_words:
        return None
    pictures = []
    shortest: dict[Problem, tuple[str, Path]] = {}  # at each radius of the fifth problem
    for label, problem in PROBLEMS.items():
        of_label = [(word, path) for (name, word), path in paths_of_words.items() if name == label]
        paths = sorted(of_label, key=lambda named_path: named_path[1].length)
        if problem.position == "problem 5" and paths:
            shortest[problem] = paths[0]
        elif paths:
            ranked = zip(("optimal", "feasible"), paths, strict=False)
            named = {labelled(rank, word, path): path for rank, (word, path) in ranked}
            content = "Optimal (solid) and feasible (dashed) path"
            pictures.append(_picture(problem, named, content))
    if shortest:
        named = {
            labelled(f"R = {at.radius}", word, path): path for at, (word, path) in shortest.items()
        }
        content = "Optimal paths for three turning radii"
        pictures.append(_picture(min(shortest), named, content, [at.radius for at in shortest]))
    text = (
        "The paper's Figures 6.1–6.5, drawn from the controls in the rows. The arrow is the start "
        "heading, the ring is the target; the turning circles are faint. The paper's text gives "
        "each length with two decimals; the tables above say which are right."
    )
    lead = "In every problem the shortest path is LS or RS; see how much longer the other path is."
    return Section("paths", "The paper's figures", text, tuple(pictures), lead)


def _picture(
    problem: Problem, paths: Mapping[str, Path], content: str, radii: Iterable[float] = ()
) -> Picture:
    """The paper's figure of one of its test problems."""
    number = problem.position.removeprefix("problem ")
    return picture(
        f"paths-{number}",
        plot_paths,
        paths,
        problem.scenario,
        radii,
        caption=f"Figure 6.{number}. {content} with their lengths; length units.",
        alt=f"Paths of test {problem.position}",
        height=2.9,
    )


TOPIC = Topic("the paper's figures", figures_section, "paper", place=Place.PAPER)
