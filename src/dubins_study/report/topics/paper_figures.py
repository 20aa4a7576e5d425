"""The paper's Figures 3.1 and 6.1-6.5, drawn again from the paths in the rows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Picture,
    Place,
    Section,
    Topic,
    panels_picture,
    picture,
)
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES
from dubins_study.report.elements.style import (
    BLUE,
    GREEN,
    HALF,
    INK,
    MUTED,
    PAPER,
    RULE,
    VERMILION,
    WIDE,
    new_figure,
)
from dubins_study.report.paper.printed import PROBLEMS, WORDS, Problem
from dubins_study.report.topics.paper import word_paths
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path, outline
from dubins_study.study.scenario import Pose, Scenario

_BY_RANK = ((BLUE, "-"), (VERMILION, LINES[1]))
_BY_RADIUS = (BLUE, VERMILION, GREEN)
_TARGET_RING: dict[str, Any] = {
    **{"markersize": 7, "markerfacecolor": PAPER, "markeredgecolor": MUTED, "zorder": 4},
    **{"marker": "o", "markeredgewidth": 1.2},
}


def labelled(name: str, word: str, path: Path) -> str:
    """A path's entry in a legend."""
    return f"{name}: {word}, {digits(4)(path.length)}"


def _by_length(paths: Mapping[str, Path]) -> list[tuple[str, Path]]:
    return sorted(paths.items(), key=lambda item: item[1].length)


def plot_paths(ax: Axes, paths: Mapping[str, Path], scenario: Scenario) -> None:
    """One or two paths of a scenario by their names in a legend above the panel, shortest first.

    Both turning circles of the start, the start's arrow and the target are drawn too.
    """
    for (text, path), (colour, line) in zip(paths.items(), _BY_RANK, strict=False):
        points, _ = outline(path)
        ax.plot(points[:, 0], points[:, 1], color=colour, linestyle=line, label=text, zorder=3)
    for side in (1, -1):
        _turning_circle(ax, scenario.start, side * scenario.radius, RULE)
    plot_start_and_target(ax, scenario.start, (scenario.target_x, scenario.target_y))
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.07)
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2)


def plot_radii(ax: Axes, paths: Mapping[Problem, Path], reach: float) -> None:
    """The shortest path of each radius, up to `reach` from the start (length unit); named."""
    for (problem, path), colour, line in zip(paths.items(), _BY_RADIUS, LINES, strict=False):
        points = path.sample(600)[:, :2]
        near = points[np.hypot(*(points - points[0]).T) <= reach]
        text = labelled(f"R = {problem.radius:g}", path.word(), path)
        ax.plot(*near.T, color=colour, linestyle=line, label=text, zorder=3)
    box = ax.dataLim.frozen()  # of the paths alone
    pad = 0.08 * max(box.size)
    for (problem, path), colour in zip(paths.items(), _BY_RADIUS, strict=False):
        side = math.copysign(problem.radius, path.curvatures[0])
        _turning_circle(ax, path.start, side, colour)
    plot_start_and_target(ax, path.start, problem.target)
    ax.set_aspect("equal", adjustable="box", anchor="NW")  # as wide as the paths
    ax.set(xlim=(box.x0 - pad, box.x1 + pad), ylim=(box.y0 - 2 * pad, box.y1 + pad))


def plot_feasible(ax: Axes, paths: Mapping[str, Path], scenario: Scenario) -> None:
    """Figure 3.1: LS and RS to one target, with the points that the paper names."""
    plot_paths(ax, {labelled("feasible", *each): each[1] for each in _by_length(paths)}, scenario)
    target = scenario.target_x, scenario.target_y
    points = {"P": scenario.start[:2], "X₃ = T": target}
    for name, path in zip(("X₁", "X₂"), paths.values(), strict=True):
        points[name] = (path.poses[1][0], path.poses[1][1])
        ax.plot(*points[name], "o", color=MUTED, markersize=3.5, zorder=5)
    lifts = {"P": (-11, -2), "X₁": (-6, -13), "X₂": (4, -10), "X₃ = T": (-34, 6)}
    for name, place in points.items():
        ax.annotate(name, place, xytext=lifts[name], textcoords="offset points", fontsize=9)
    ax.margins(0.09)


def _turning_circle(ax: Axes, start: Pose, side: float, colour: str) -> None:
    """A turning circle at the start; `side` is its radius, positive on the left."""
    x, y, heading = start
    centre = x - side * math.sin(heading), y + side * math.cos(heading)
    look: dict[str, Any] = {"edgecolor": colour, "linewidth": 0.8, "zorder": 1}
    look |= {"alpha": 1.0 if colour == RULE else 0.45}
    ax.add_patch(Circle(centre, abs(side), fill=False, **look))


def plot_start_and_target(
    ax: Axes, start: Pose, target: tuple[float, float], final_heading: float | None = None
) -> None:
    """The start with an arrow a ninth as long as what is drawn already; the target as a ring.

    The arrow of a final heading begins at the target.
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


# Any target ahead and to the left shows what Figure 3.1 shows; the paper gives no numbers.
_FEASIBLE = Scenario(heading=math.radians(75), target_x=4.6, target_y=2.4)
_NEAR = 28.0  # length units around the start, where the paths of test problem 5 differ
_HEIGHT = 2.9  # inches


def feasible_picture() -> Picture:
    """Figure 3.1 for a target of our own."""
    found = {word: shortest_path(_FEASIBLE, word) for word in WORDS}
    paths = {word: path for word, path in found.items() if path is not None}
    caption = (
        "As the paper's Figure 3.1. From P the vehicle turns left to X₁ or right to X₂, then "
        "drives straight to X₃ = T: the feasible paths LS and RS. Faint: the turning circles."
    )
    alt = "The paths LS and RS from a start to a target"
    drawn = paths, _FEASIBLE
    return picture(
        "paths-feasible", plot_feasible, *drawn, caption=caption, alt=alt, height=_HEIGHT
    )


def problem_picture(problem: Problem, paths: Mapping[str, Path]) -> Picture:
    """The paper's figure of one of its first four test problems; paths by their words."""
    named = {
        labelled(name, *each): each[1]
        for name, each in zip(("optimal", "feasible"), _by_length(paths), strict=False)
    }
    number = problem.label.removeprefix("problem ")
    caption = (
        f"Figure 6.{number}. Optimal (solid) and feasible (dashed) path with their lengths; length "
        "units."
    )
    alt = f"Paths of test {problem.label}"
    drawn = named, problem.scenario
    return picture(f"paths-{number}", plot_paths, *drawn, caption=caption, alt=alt, height=_HEIGHT)


def radii_picture(paths: Mapping[Problem, Path]) -> Picture:
    """The paper's figure of the fifth test problem: the shortest path at each radius."""
    caption = (
        "Figure 6.5. Optimal paths of test problem 5 for three turning radii with their lengths, "
        "and the same paths near the start, where they differ; faint: the turning circles. Length "
        "units."
    )
    alt = "Paths of test problem 5 for three radii"
    return panels_picture("paths-5", caption, _two_scales, alt, paths)


def _two_scales(paths: Mapping[Problem, Path], *, narrow: bool) -> Figure:
    """The whole paths, and what is near the start, side by side or one below the other."""
    figure = new_figure(*((HALF, 4.6) if narrow else (WIDE, 2.4)))
    apart: dict[str, Any] = {"nrows": 2} if narrow else {"ncols": 2, "width_ratios": (7, 4)}
    whole, near = figure.subplots(**apart)
    plot_radii(whole, paths, math.inf)
    plot_radii(near, paths, _NEAR)
    whole.legend(loc="lower left", borderaxespad=0.1)
    whole.set_title("whole paths")
    near.set_title("near the start")
    return figure


def figures_section(results: Results) -> Section | None:
    """Figures 3.1 and 6.1-6.5, redrawn from the paths in the rows."""
    found = word_paths(results, EXACT)
    if not found:
        return None
    pictures = [feasible_picture()]
    radii: dict[Problem, Path] = {}
    for label, problem in PROBLEMS.items():
        paths = {word: found[label, word] for word in WORDS if (label, word) in found}
        if problem.position == "problem 5" and paths:
            radii[problem] = min(paths.values(), key=lambda path: path.length)
        elif paths:
            pictures.append(problem_picture(problem, paths))
    if radii:
        pictures.append(radii_picture(radii))
    text = (
        "The paper's Figures 3.1 and 6.1–6.5, drawn from the controls in the rows. The "
        "arrow is the start heading, the ring the target; faint are the "
        "turning circles. The paper's text gives each length with two decimals; the tables above "
        "say which of these are right."
    )
    lead = (
        "In every problem one of two paths is the shortest, LS or RS; see how far the other is "
        "round."
    )
    return Section("paths", "The paper's figures", text, tuple(pictures), lead)


TOPIC = Topic("the paper's figures", figures_section, "paper", place=Place.PAPER)
