"""The section on the target plane."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import General, Picture, Section, Topic, picture
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import Mark, draw_cells
from dubins_study.report.elements.style import MAP_PAPER, ON_MAP, ORANGE, VERMILION, Style
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.report.topics.maps import grid_of, kind_maps

_DENSE = 200  # places along each axis; with an even number none lies on a symmetric grid's axis
_FEWEST_LINES = 5  # grid lines along x and along y; fewer do not give a map
# The hue is that of the first turn; light and dark shades keep all four apart in grey print.
WORDS = (
    Mark("LS", colour="#adcfe8"),
    Mark("RS", colour="#fdefd9"),
    Mark("RL", colour="#d69a3c"),
    Mark("LR", colour="#3f7fb0"),
)
# Right answers, and the verdicts of wrong ones.
ANSWERS = (
    Mark("right", colour=MAP_PAPER),
    Mark("longer", colour=ORANGE, marker="^"),
    Mark("misses", colour=VERMILION, marker="x"),
    Mark("none", colour="#5d636b"),
)


def exact_answers(rows: pd.DataFrame) -> pd.DataFrame:
    """The shortest word and length on a dense grid.

    The grid covers the closed form's targets in the rows; the frame is empty if these are no grid.
    Columns: x and y (of the target), kind (the shortest word), length, inside (whether the target
    is in a turning circle).
    """
    exact = rows[rows["solver"] == EXACT]
    xs = exact["target_x"].unique()
    ys = exact["target_y"].unique()
    if min(xs.size, ys.size) < _FEWEST_LINES:
        return exact.iloc[:0]
    # this loads numba
    from dubins_study.study.closed_form import kernel

    grid = np.meshgrid(
        np.linspace(xs.min(), xs.max(), _DENSE), np.linspace(ys.min(), ys.max(), _DENSE)
    )
    x, y = (values.ravel() for values in grid)
    first = exact.iloc[0]
    problems = (first["x"], first["y"], first["heading"], x, y, first["radius"])
    best = kernel.shortest_rows(*np.broadcast_arrays(*problems))
    words = np.array(kernel.WORDS)[best.word]
    inside = np.hypot(x, np.abs(y) - 1) < 1
    return pd.DataFrame({"x": x, "y": y, "kind": words, "length": best.length, "inside": inside})


def _draw_circles(ax: Axes, _: pd.DataFrame) -> None:
    """Draw the turning circles and the start.

    The half where the length jumps has a heavy line.
    """
    for side in (1, -1):
        ax.add_patch(Circle((0, side), 1, fill=False, edgecolor=ON_MAP, linewidth=0.6))
        ax.add_patch(Arc((0, side), 2, 2, theta1=-90, theta2=90, color=ON_MAP, linewidth=1.8))
    head: Style = {"arrowstyle": "-|>", "color": ON_MAP, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(0.75, 0), xytext=(0, 0), arrowprops=head)
    ax.plot(0, 0, marker="o", color=ON_MAP, markersize=3)
    ax.set(xlabel="target x / R", ylabel="target y / R")
    ax.set_aspect("equal")


def plot_lengths(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the shortest length by colour and contours.

    The contours break where the length jumps. `table` is that of `exact_answers`.
    """
    x, y, length = grid_of(table, "length")
    inside = grid_of(table, "inside")[2] > 0.5
    image = draw_cells(ax, length, x, y, "cividis")
    levels = np.arange(math.floor(length.min()), math.ceil(length.max()) + 1)
    for part in (inside, ~inside):  # separately, since a contour must not cross the jump
        values = np.where(part, length, np.nan)
        if part.any():
            lines = ax.contour(x, y, values, levels=levels, colors="white", linewidths=0.6)
            ax.clabel(lines, levels[::2], fmt="%g", fontsize=7, inline_spacing=2)
    _draw_circles(ax, table)
    bar = ax.figure.colorbar(image, ax=ax, location="bottom", shrink=0.7, pad=0.02, aspect=28)
    bar.outline.set_visible(False)
    bar.set_label("shortest length / R")


def _exact_pictures(exact: pd.DataFrame) -> list[Picture]:
    """Maps of the shortest words, and of the lengths."""
    words = kind_maps({"": exact}, WORDS, _draw_circles, high=3.5, narrow=True)
    lengths = picture(
        "plane-lengths",
        plot_lengths,
        exact,
        caption="Shortest length by target, with a contour every R. The length jumps across the "
        "front half of the two circles; across the rear half it is smooth.",
        alt="Map of shortest lengths",
        height=4.1,
    )
    caption = (
        "Shortest word by target. Dark: inside a turning circle, where the path first turns away "
        "from the target. On the axis ahead the path is straight. Lengths in R."
    )
    return [Picture("plane-words", caption, words, "Map of shortest words", half=True), lengths]


def _solver_picture(number: int, targets: pd.DataFrame, name: str) -> Picture:
    """A map of one solver's right and wrong answers.

    The legend has the number of each wrong verdict. `number` is a part of the file's name.
    """
    right = success(targets)
    kinds = targets["verdict"].mask(right, "right")
    numbers = kinds.value_counts()
    marks = [replace(mark, label=f"{mark.key} ({numbers.get(mark.key, 0)})") for mark in ANSWERS]
    placed = pd.DataFrame({"x": targets["target_x"], "y": targets["target_y"], "kind": kinds})
    figure = kind_maps({"": placed}, marks, _draw_circles, high=3.5, narrow=True)
    caption = f"{name}: {count(right.sum())} of {count(len(targets))} targets right; lengths in R."
    alt = f"Targets {name} gets wrong"
    return Picture(f"plane-solver-{number}", caption, figure, alt, half=True)


def plane_section(results: Results) -> Section | None:
    """The section with maps of the target plane.

    They show the shortest words, the shortest lengths, and the wrong answers of each solver on a
    coarse grid.
    """
    rows = results.rows[results.rows["branch"] == "best"]
    exact = exact_answers(rows)
    pictures: list[Picture] = []
    if len(exact):
        pictures += _exact_pictures(exact)
    coarse = rows[rows["solver"] != EXACT]
    names = Palette.of_page(results).names(coarse["solver"])
    for number, solver in enumerate(solver_order(list(names)), start=1):
        targets = coarse[coarse["solver"] == solver].drop_duplicates(["target_x", "target_y"])
        pictures.append(_solver_picture(number, targets, names[solver]))
    if not pictures:
        return None
    text = (
        "The vehicle starts at the origin and heads along +x; every point is a target. The paper "
        "states LS and RS only. That is right outside the two turning circles and wrong inside: "
        "there the shortest path turns away first. The length jumps, by up to 2π R, only across "
        "the front half of each circle (heavy)."
    )
    lead = (
        "Look inside the two circles: the shortest words differ from the paper's there, and "
        "solvers go wrong there."
    )
    return Section("plane", "The target plane", text, tuple(pictures), lead)


# Not compared: only the closed form answers a plane's hundred thousand questions.
TOPIC = Topic("the target plane", plane_section, "plane", (General.POOLED,))
