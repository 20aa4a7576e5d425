"""The paper's Figures 3.1 and 6.1-6.5, drawn again from the paths in the rows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
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
from dubins_study.report.topics.paper import word_paths
from dubins_study.study.arrays import FloatArray
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path, outline
from dubins_study.study.scenario import Pose, Scenario

_BY_RANK = ((BLUE, "-"), (VERMILION, LINES[1]))
_BY_RADIUS = (BLUE, VERMILION, GREEN)
_TARGET_RING: dict[str, Any] = {
    **{"markersize": 7, "markerfacecolor": PAPER, "markeredgecolor": MUTED, "zorder": 4},
    **{"marker": "o", "markeredgewidth": 1.2},
}


def plot_paths(
    ax: Axes, paths: pd.DataFrame, names: Sequence[str] = ("optimal", "feasible")
) -> None:
    """Paths to one target at one radius, named in a legend above the panel.

    Columns: branch, path (`study.path.Path`), length, rank (1 the shortest), target_x, target_y,
    radius. Both turning circles of the start, the start's arrow and the target are drawn too.
    """
    for row in paths.sort_values("rank").to_dict("records"):
        colour, line = _BY_RANK[int(row["rank"]) - 1]
        text = f"{names[int(row['rank']) - 1]}: {_word_and_length(row)}"
        points, _ = outline(row["path"])
        ax.plot(points[:, 0], points[:, 1], color=colour, linestyle=line, label=text, zorder=3)
    first = paths.iloc[0]
    for side in (1, -1):
        _turning_circle(ax, first["path"], side * first["radius"], RULE)
    target = (first["target_x"], first["target_y"])
    plot_start_and_target(ax, first["path"].start, target)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.07)
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2)


def plot_radii(ax: Axes, paths: pd.DataFrame, reach: float) -> None:
    """The shortest path of each radius, up to `reach` from the start (length unit); named.

    Columns of `plot_paths`, one row per radius.
    """
    rows = paths.sort_values("radius", ascending=False).to_dict("records")
    shown: list[FloatArray] = []
    for place, row in enumerate(rows):
        path, radius = row["path"], float(row["radius"])
        points = path.sample(600)[:, :2]
        near = np.hypot(*(points - points[0]).T) <= reach
        shown.append(points[near])
        colour, line = _BY_RADIUS[place % 3], LINES[place % len(LINES)]
        text = f"R = {radius:g}: {_word_and_length(row)}"
        ax.plot(*shown[-1].T, color=colour, linestyle=line, label=text, zorder=3)
        _turning_circle(ax, path, radius * math.copysign(1.0, path.curvatures[0]), colour)
    low, high = np.vstack(shown).min(axis=0), np.vstack(shown).max(axis=0)
    pad = 0.08 * float(np.max(high - low))
    first = paths.iloc[0]
    target = (first["target_x"], first["target_y"])
    plot_start_and_target(ax, first["path"].start, target)
    ax.set_aspect("equal", adjustable="box", anchor="NW")  # as wide as the paths
    ax.set(xlim=(low[0] - pad, high[0] + pad), ylim=(low[1] - 2 * pad, high[1] + pad))


def plot_feasible(ax: Axes, paths: pd.DataFrame) -> None:
    """Figure 3.1: LS and RS to one target, with the points that the paper names."""
    plot_paths(ax, paths, names=("feasible", "feasible"))
    first = paths.iloc[0]
    points = {"P": first["path"].start, "X₃ = T": (first["target_x"], first["target_y"])}
    for word, path in zip(paths["branch"], paths["path"], strict=True):
        points["X₁" if word == "LS" else "X₂"] = path.poses[1]
        ax.plot(*path.poses[1][:2], "o", color=MUTED, markersize=3.5, zorder=5)
    lifts = {"P": (-11, -2), "X₁": (-6, -13), "X₂": (4, -10), "X₃ = T": (-34, 6)}
    for name, (x, y, *_) in points.items():
        ax.annotate(name, (x, y), xytext=lifts[name], textcoords="offset points", fontsize=9)
    ax.margins(0.09)


def _word_and_length(row: Any) -> str:
    return f"{row['branch']}, {digits(4)(row['length'])}"


def _turning_circle(ax: Axes, path: Path, side: float, colour: str) -> None:
    """A turning circle at the start; `side` is its radius, positive on the left."""
    x, y, heading = path.start
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
    paths = {word: shortest_path(_FEASIBLE, word) for word in ("LS", "RS")}
    frame = pd.DataFrame(
        {"branch": word, "path": path, "length": path.length}
        for word, path in paths.items()
        if path is not None
    )
    place = {"target_x": _FEASIBLE.target_x, "target_y": _FEASIBLE.target_y, "radius": 1.0}
    frame = frame.assign(rank=frame["length"].rank(), **place)
    caption = (
        "As the paper's Figure 3.1. From P the vehicle turns left to X₁ or right to X₂, then "
        "drives straight to X₃ = T: the feasible paths LS and RS. Faint: the turning circles."
    )
    alt = "The paths LS and RS from a start to a target"
    return picture("paths-feasible", plot_feasible, frame, caption=caption, alt=alt, height=_HEIGHT)


def problem_picture(problem: int, paths: pd.DataFrame) -> Picture:
    """The paper's figure of one test problem; `paths` are those of `problem_paths`."""
    if problem == 5:
        return _radii_picture(paths)
    return picture(
        f"paths-{problem}",
        plot_paths,
        paths,
        caption=f"Figure 6.{problem}. Optimal (solid) and feasible (dashed) path with their "
        "lengths; length units.",
        alt=f"Paths of test problem {problem}",
        height=_HEIGHT,
    )


def _radii_picture(paths: pd.DataFrame) -> Picture:
    caption = (
        "Figure 6.5. Optimal paths of test problem 5 for three turning radii with their lengths, "
        "and the same paths near the start, where they differ; faint: the turning circles. Length "
        "units."
    )
    alt = "Paths of test problem 5 for three radii"
    return panels_picture("paths-5", caption, _two_scales, alt, paths)


def _two_scales(paths: pd.DataFrame, *, narrow: bool) -> Figure:
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


def problem_paths(results: Results, problem: int) -> pd.DataFrame:
    """The closed form's paths that the paper's figure of one test problem shows.

    Columns label, branch, path, length, rank (1 the shorter of LS and RS), target_x, target_y,
    radius. For problem 5, as in the paper, only the shorter paths at its three radii.
    """
    paths = word_paths(results, EXACT)
    records = [
        {"label": label, "branch": branch, "path": path, "length": path.length}
        for (label, branch), path in paths.items()
        if label.startswith(f"problem {problem}")
    ]
    if not records:
        return pd.DataFrame()
    frame = pd.DataFrame(records)
    frame["rank"] = frame.groupby("label")["length"].rank(method="first")
    scenarios = results.rows.drop_duplicates("label")
    frame = frame.merge(scenarios[["label", "target_x", "target_y", "radius"]], on="label")
    return frame[frame["rank"] == 1] if problem == 5 else frame


def figures_section(results: Results) -> Section | None:
    """Figures 3.1 and 6.1-6.5, redrawn from the paths in the rows."""
    frames = {problem: problem_paths(results, problem) for problem in range(1, 6)}
    pictures = [problem_picture(problem, frame) for problem, frame in frames.items() if len(frame)]
    if not pictures:
        return None
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
    return Section("paths", "The paper's figures", text, (feasible_picture(), *pictures), lead)


TOPIC = Topic("the paper's figures", figures_section, "paper", place=Place.PAPER)
