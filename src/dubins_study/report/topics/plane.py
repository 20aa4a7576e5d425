"""The section on the target plane."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Patch

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import General, Section, Topic, picture
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import Mark, draw_cells
from dubins_study.report.elements.style import (
    BLUE,
    INK,
    MUTED,
    ON_MAP,
    ORANGE,
    VERMILION,
    Style,
)
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import Paths
from dubins_study.study.scenario_frame import check_frame

_DENSE = 200  # places along each axis; with an even number none lies on a symmetric grid's axis
_FEWEST_LINES = 5  # grid lines along x and along y; fewer do not give a map
# A light and a dark shade of two hues: the shades differ in grey print too.
WORDS = (
    Mark("LS", colour="#cfe3f1"),
    Mark("RS", colour="#fbe6c8"),
    Mark("RL", colour="#5d9cc6", hatch="////"),
    Mark("LR", colour="#d69a3c", hatch="\\\\\\\\"),
)
OTHER_COLOUR = "#8a8f96"
# Verdicts of wrong answers.
WRONG = (
    Mark("longer", colour=ORANGE, marker="^", filled=False),
    Mark("misses", colour=VERMILION, marker="x"),
    Mark("none", colour=BLUE, marker="s", filled=False),
)
_DISCS = ("left disc", "right disc")


def exact_answers(rows: pd.DataFrame) -> pd.DataFrame:
    """The closed form on a dense grid over its targets in the rows; empty if they are no grid.

    Columns: target_x, target_y, word, length, region.
    """
    exact = rows[rows["solver"] == EXACT]
    sides = [np.unique(exact[name].to_numpy(np.float64)) for name in ("target_x", "target_y")]
    if min(side.size for side in sides) < _FEWEST_LINES:
        return exact.iloc[:0]
    dense = [np.linspace(side[0], side[-1], _DENSE) for side in sides]
    # these load numba
    from dubins_study.study.closed_form.kernel import RATES, WORDS, curvatures, shortest_rows
    from dubins_study.study.judging.verdict_frame import REGIONS, judge_frame

    x, y = (each.ravel() for each in np.meshgrid(*dense))
    first = {name: float(exact[name].iloc[0]) for name in ("x", "y", "heading", "radius")}
    frame = check_frame(pd.DataFrame({**first, "target_x": x, "target_y": y}))
    columns = ("x", "y", "heading", "target_x", "target_y", "radius")
    best = shortest_rows(*(frame[name].to_numpy(np.float64) for name in columns))
    turns = np.empty((2, len(frame)))
    curvatures(RATES, best.word, frame["radius"].to_numpy(np.float64), turns)
    judged = judge_frame(frame, Paths(turns, best.segments))
    return frame.assign(
        word=np.array(WORDS)[best.word],
        length=best.length,
        region=np.array([str(region) for region in REGIONS])[judged.region],
    )


def _grid(rows: pd.DataFrame, column: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """x of shape (n,), y of shape (m,) and the column's values of shape (m, n); NaN where none."""
    table = rows.pivot_table(index="target_y", columns="target_x", values=column, aggfunc="first")
    x, y = table.columns.to_numpy(dtype=np.float64), table.index.to_numpy(dtype=np.float64)
    return x, y, table.to_numpy(dtype=np.float64)


def _draw_circles(ax: Axes, x: FloatArray, y: FloatArray, ink: str = ON_MAP) -> None:
    """Draw the turning circles and the start; the half where the length jumps has a heavy line."""
    for side in (1, -1):
        ax.add_patch(Circle((0, side), 1, fill=False, edgecolor=ink, linewidth=0.6))
        ax.add_patch(Arc((0, side), 2, 2, theta1=-90, theta2=90, color=ink, linewidth=1.8))
    head: Style = {"arrowstyle": "-|>", "color": ink, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(0.75, 0), xytext=(0, 0), arrowprops=head)
    ax.plot(0, 0, marker="o", color=ink, markersize=3)
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel="target x / R", ylabel="target y / R")
    ax.set_aspect("equal")
    ax.grid(False)


def plot_words(ax: Axes, rows: pd.DataFrame) -> list[Artist]:
    """Draw the shortest word of each target, and return the legend's entries.

    Columns: target_x, target_y, word (on a grid).
    """
    codes = {mark.key: float(i) for i, mark in enumerate(WORDS)}
    x, y, code = _grid(rows.assign(code=rows["word"].map(codes).fillna(len(WORDS))), "code")
    draw_cells(ax, code, x, y, [*(mark.colour for mark in WORDS), OTHER_COLOUR])
    present = [mark for mark in WORDS if (code == codes[mark.key]).any()]
    for mark in filter(lambda mark: mark.hatch, present):
        inside = (code == codes[mark.key]).astype(float)
        style: Style = {"colors": "none", "hatches": [mark.hatch]}
        hatch = ax.contourf(x, y, inside, levels=[0.5, 1.5], **style)
        hatch.set_edgecolor("#ffffff80")
        hatch.set_linewidth(0)
    _draw_circles(ax, x, y)
    return [Patch(label=mark.key, **mark.bar()) for mark in present]


def plot_lengths(ax: Axes, rows: pd.DataFrame) -> None:
    """Draw the shortest length, with contours that break where it jumps.

    Columns: target_x, target_y, length, region (on a grid).
    """
    x, y, length = _grid(rows, "length")
    disc = _grid(rows.assign(disc=rows["region"].isin(_DISCS).astype(float)), "disc")[2] > 0.5
    image = draw_cells(ax, length, x, y, "cividis")
    levels = np.arange(math.floor(np.nanmin(length)), math.ceil(np.nanmax(length)) + 1)
    for part in (disc, ~disc):  # separately, since a contour must not cross the jump
        values = np.where(part, length, np.nan)
        if np.isfinite(values).sum() > 4:
            lines = ax.contour(x, y, values, levels=levels, colors="white", linewidths=0.6)
            ax.clabel(lines, levels[::2], fmt=lambda v: f"{v:g}", fontsize=7, inline_spacing=2)
    _draw_circles(ax, x, y)
    figure = ax.figure
    assert figure is not None
    bar = figure.colorbar(image, ax=ax, location="bottom", shrink=0.7, pad=0.02, aspect=28)
    bar.outline.set_visible(False)
    bar.set_label("shortest length / R")


def plot_failures(ax: Axes, rows: pd.DataFrame) -> None:
    """Draw one solver's answers on a grid: a dot for a right answer, else a mark for the verdict.

    Columns: target_x, target_y, verdict, presolved.
    """
    right = rows[success(rows)]
    ax.plot(right["target_x"], right["target_y"], ".", color=MUTED, markersize=1.5, label="right")
    for mark in WRONG:
        group = rows[rows["verdict"] == mark.key]
        if len(group):
            dots = mark.dots() | {"markersize": 4.0, "label": f"{mark.key} ({len(group)})"}
            ax.plot(group["target_x"], group["target_y"], **dots)
    x, y = (np.sort(rows[name].unique()).astype(np.float64) for name in ("target_x", "target_y"))
    _draw_circles(ax, x, y, INK)


def plane_section(results: Results) -> Section | None:
    """Maps of words and lengths, and where the solvers on a coarse grid go wrong."""
    rows = results.rows[results.rows["branch"] == "best"]
    exact = exact_answers(rows)
    pictures = []
    if len(exact):
        caption = (
            "Shortest word by target. Hatched: inside a turning circle, where the first turn is "
            "away from the target. On the axis ahead the path is straight. Lengths in R."
        )
        style: Style = {"caption": caption, "alt": "Map of shortest words", "height": 3.8}
        pictures.append(picture("plane-words", plot_words, exact, **style, legend=4))
        caption = (
            "Shortest length by target, a contour every R. The two discs stand out because the "
            "length jumps across the front half of their circles; across the rear half it is "
            "smooth."
        )
        style = {"caption": caption, "alt": "Map of shortest lengths", "height": 4.1}
        pictures.append(picture("plane-lengths", plot_lengths, exact, **style))
    coarse = rows[rows["solver"] != EXACT]
    names = Palette.of_page(results).names(coarse["solver"])
    for number, solver in enumerate(solver_order(coarse["solver"].tolist()), start=1):
        targets = coarse[coarse["solver"] == solver].drop_duplicates(["target_x", "target_y"])
        right = f"{count(success(targets).sum())} of {count(len(targets))} targets right"
        pictures.append(
            picture(
                f"plane-solver-{number}",
                plot_failures,
                targets,
                caption=f"{names[solver]}: {right}; lengths in R.",
                alt=f"Targets {names[solver]} gets wrong",
                height=3.9,
                legend=2,
            )
        )
    if not pictures:
        return None
    text = (
        "The vehicle starts at the origin and heads along +x; every point is a target. The paper "
        "states LS and RS only, which is right outside the two turning circles and wrong inside: "
        "there the shortest path turns away first. Across the front half of each circle (heavy) "
        "the length jumps by up to 2π R, and nowhere else."
    )
    lead = (
        "Look inside the two circles: there the shortest words are others than the paper's, and "
        "there solvers go wrong."
    )
    return Section("plane", "The target plane", text, tuple(pictures), lead)


# Not compared: a plane has a hundred thousand questions that only the closed form answers.
TOPIC = Topic("the target plane", plane_section, "plane", (General.POOLED,))
