"""The section on the target plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.patches import Arc, Circle
from numpy.typing import NDArray

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, picture
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import draw_cells
from dubins_study.report.elements.style import (
    BLUE,
    INK,
    MAP_PAPER,
    MUTED,
    ON_MAP,
    ORANGE,
    RULE,
    VERMILION,
)
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.metrics import solver_order, success
from dubins_study.study.path import Paths
from dubins_study.study.scenario import check_frame

_DENSE = 200  # places along each axis; with an even number none lies on a symmetric grid's axis
_FEWEST_LINES = 5  # grid lines along x and along y; fewer do not give a map


def exact_answers(rows: pd.DataFrame) -> pd.DataFrame:
    """The closed form on a dense grid over its targets in the rows; empty if they are no grid.

    Columns: target_x, target_y, word, length, region, margin.
    """
    exact = rows[rows["solver"] == EXACT]
    sides = [np.unique(exact[name].to_numpy(np.float64)) for name in ("target_x", "target_y")]
    if min(side.size for side in sides) < _FEWEST_LINES:
        return exact.iloc[:0]
    # these load numba
    from dubins_study.study.check.verdict_frame import judge_frame
    from dubins_study.study.check.verdict_kernel import REGIONS
    from dubins_study.study.closed_form.kernel import WORDS, curvatures, shortest_rows

    x, y = (each.ravel() for each in np.meshgrid(*map(_dense, sides)))
    first = {name: float(exact[name].iloc[0]) for name in ("x", "y", "heading", "radius")}
    frame = check_frame(pd.DataFrame({**first, "target_x": x, "target_y": y}))
    columns = ("x", "y", "heading", "target_x", "target_y", "radius")
    best = shortest_rows(*(frame[name].to_numpy(np.float64) for name in columns))
    turns = np.empty((2, len(frame)))
    curvatures(best.word, frame["radius"].to_numpy(np.float64), turns)
    judged = judge_frame(frame, Paths(turns, np.stack([best.first, best.second])))
    return frame.assign(
        word=np.array(WORDS)[best.word],
        length=best.length,
        region=np.array([str(region) for region in REGIONS])[judged.region],
        margin=judged.margin,
    )


def _dense(side: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linspace(side[0], side[-1], _DENSE)


def grid_of(rows: pd.DataFrame, column: str) -> tuple[NDArray[np.float64], ...]:
    """x of shape (n,), y of shape (m,) and the column's values of shape (m, n); NaN where none."""
    table = rows.pivot_table(index="target_y", columns="target_x", values=column, aggfunc="first")
    x = table.columns.to_numpy(dtype=np.float64)
    y = table.index.to_numpy(dtype=np.float64)
    return x, y, table.to_numpy(dtype=np.float64)


def along_circle(rows: pd.DataFrame) -> pd.DataFrame:
    """Targets within one grid step of a turning circle, with their position along the circle.

    Columns: angle (arc angle from the start, deg), side (`inside`, `outside`), length.
    """
    xs = np.sort(rows["target_x"].unique())
    near = rows[rows["margin"] <= np.diff(xs).min()]
    angle = np.arctan2(near["target_x"], 1 - near["target_y"].abs())
    disc = near["region"].isin(["left disc", "right disc"])
    return pd.DataFrame(
        {
            "angle": np.degrees(angle) % 360,
            "side": np.where(disc, "inside", "outside"),
            "length": near["length"],
        }
    ).sort_values("angle")


# A light and a dark shade of two hues: the shades differ in grey print too.
WORD_COLOURS = {"LS": "#cfe3f1", "RS": "#fbe6c8", "RL": "#5d9cc6", "LR": "#d69a3c"}
OTHER_COLOUR = "#8a8f96"
_HATCHES = {"LS": "", "RS": "", "RL": "////", "LR": "\\\\\\\\"}


def label_region(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], inside: NDArray[np.bool_], text: str
) -> None:
    """Write a word where its region is widest; nothing if the region is empty.

    Args:
        ax: where to draw.
        x, y: coordinates of the grid, shapes (n,) and (m,).
        inside: whether each cell belongs to the region, shape (m, n).
        text: the word.
    """
    if not inside.any():
        return
    row, column = _deepest(inside)
    box = {"facecolor": MAP_PAPER, "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
    ax.text(x[column], y[row], text, ha="center", va="center", bbox=box, color=ON_MAP)


def _deepest(inside: NDArray[np.bool_]) -> tuple[int, int]:
    """Row and column of the cell farthest from the region's edge."""
    depth = np.zeros(inside.shape, dtype=int)
    left = np.pad(inside, 1)
    while left.any():
        depth += left[1:-1, 1:-1]
        left[1:-1, 1:-1] &= left[:-2, 1:-1] & left[2:, 1:-1] & left[1:-1, :-2] & left[1:-1, 2:]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    return int(row), int(column)


def draw_circles(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], ink: str = ON_MAP
) -> None:
    """Draw the turning circles and the start; the half where the length jumps has a heavy line."""
    for side in (1, -1):
        ax.add_patch(Circle((0, side), 1, fill=False, edgecolor=ink, linewidth=0.6))
        ax.add_patch(Arc((0, side), 2, 2, theta1=-90, theta2=90, color=ink, linewidth=1.8))
    head = {"arrowstyle": "-|>", "color": ink, "linewidth": 1.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=(0.75, 0), xytext=(0, 0), arrowprops=head)
    ax.plot(0, 0, marker="o", color=ink, markersize=3)
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel="target x / R", ylabel="target y / R")
    ax.set_aspect("equal")
    ax.grid(False)


def add_colour_bar(ax: Axes, image: ScalarMappable, label: str) -> None:
    """Draw the scale of a map's colours below the map."""
    figure = ax.figure
    assert figure is not None
    bar = figure.colorbar(image, ax=ax, location="bottom", shrink=0.7, pad=0.02, aspect=28)
    bar.outline.set_visible(False)
    bar.set_label(label)


def plot_words(ax: Axes, rows: pd.DataFrame) -> None:
    """Draw the shortest word of each target. Columns: target_x, target_y, word (on a grid)."""
    codes = {word: float(i) for i, word in enumerate(WORD_COLOURS)}
    other = float(len(WORD_COLOURS))
    known = rows.assign(code=rows["word"].map(lambda word: codes.get(word, other)))
    x, y, code = grid_of(known, "code")
    draw_cells(ax, code, x, y, [*WORD_COLOURS.values(), OTHER_COLOUR])
    for word, value in codes.items():
        inside = code == value
        if inside.any() and _HATCHES[word]:
            style: dict[str, Any] = {"colors": "none", "hatches": [_HATCHES[word]]}
            hatch = ax.contourf(x, y, inside.astype(float), levels=[0.5, 1.5], **style)
            hatch.set_edgecolor("#ffffff80")
            hatch.set_linewidth(0)
        label_region(ax, x, y, inside, word)
    draw_circles(ax, x, y)


def plot_lengths(ax: Axes, rows: pd.DataFrame) -> None:
    """The shortest length, with contours that break where it jumps.

    Columns: target_x, target_y, length, region (on a grid), radius.
    """
    x, y, length = grid_of(rows, "length")
    inside = rows.assign(inside=rows["region"].isin(["left disc", "right disc"]).astype(float))
    _, _, disc = grid_of(inside, "inside")
    image = draw_cells(ax, length, x, y, "cividis")
    levels = np.arange(math.floor(np.nanmin(length)), math.ceil(np.nanmax(length)) + 1)
    for part in (disc > 0.5, disc <= 0.5):  # separately, since a contour must not cross the jump
        values = np.where(part, length, np.nan)
        if np.isfinite(values).sum() > 4:
            lines = ax.contour(x, y, values, levels=levels, colors="white", linewidths=0.6)
            ax.clabel(lines, levels[::2], fmt=lambda v: f"{v:g}", fontsize=7, inline_spacing=2)
    draw_circles(ax, x, y)
    add_colour_bar(ax, image, "shortest length / R")


def plot_jump(ax: Axes, table: pd.DataFrame) -> None:
    """Length on both sides of a turning circle. Columns of `along_circle`."""
    sides = {"inside": (VERMILION, "x", 6), "outside": (BLUE, ".", -12)}
    for side, (colour, marker, lift) in sides.items():
        group = table[table["side"] == side]
        ax.plot(group["angle"], group["length"], marker, color=colour, markersize=2.5)
        at = group.iloc[(group["angle"] - 110).abs().argmin()] if len(group) else None
        if at is not None:
            text: dict[str, Any] = {"textcoords": "offset points", "ha": "left"}
            point = (at["angle"], at["length"])
            ax.annotate(f"just {side}", point, xytext=(0, lift), color=colour, **text)
    ax.axvspan(0, 180, color=RULE, alpha=0.35, linewidth=0)
    ax.text(90, 0.02, "front half", transform=ax.get_xaxis_transform(), ha="center", color=MUTED)
    ax.set(xlim=(0, 360), ylim=(0, 7.4), xlabel="arc angle to the point of the circle (deg)")
    ax.set(ylabel="shortest length / R")
    ax.set_xticks([0, 90, 180, 270, 360])


_WRONG: dict[str, dict[str, Any]] = {
    "longer": {"marker": "^", "color": ORANGE},
    "misses": {"marker": "x", "color": VERMILION},
    "none": {"marker": "s", "color": BLUE, "markersize": 3.0},
}


def plot_failures(ax: Axes, rows: pd.DataFrame) -> None:
    """Draw one solver's answers on a grid: a dot for a right answer, else a mark for the verdict.

    Columns: target_x, target_y, verdict, presolved.
    """
    right = rows[success(rows)]
    ax.plot(right["target_x"], right["target_y"], ".", color=MUTED, markersize=1.5, label="right")
    for verdict, look in _WRONG.items():
        group = rows[rows["verdict"] == verdict]
        if len(group):
            mark: dict[str, Any] = {"linestyle": "none", "markersize": 4.0, **look}
            text = f"{verdict} ({len(group)})"
            mark |= {"markerfacecolor": "none", "label": text}
            ax.plot(group["target_x"], group["target_y"], **mark)
    x, y = np.sort(rows["target_x"].unique()), np.sort(rows["target_y"].unique())
    draw_circles(ax, x.astype(np.float64), y.astype(np.float64), INK)


def plane_section(results: Results) -> Section | None:
    """Maps of words and lengths, and where the solvers on a coarse grid go wrong."""
    rows = results.rows[results.rows["branch"] == "best"]
    exact = exact_answers(rows)
    pictures: list[Picture] = []
    if len(exact):
        pictures += [_words(exact), _lengths(exact), _jump(exact)]
    coarse = rows[rows["solver"] != EXACT]
    names = Palette.of_page(results).names(coarse["solver"])
    for number, solver in enumerate(solver_order(coarse["solver"].tolist()), start=1):
        pictures.append(_failures(number, names[solver], coarse[coarse["solver"] == solver]))
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


def _words(exact: pd.DataFrame) -> Picture:
    caption = (
        "Shortest word by target. Hatched: inside a turning circle, where the first turn is away "
        "from the target. On the axis ahead the path is straight. Lengths in R."
    )
    alt = "Map of shortest words"
    return picture("plane-words", plot_words, exact, caption=caption, alt=alt, height=3.5)


def _lengths(exact: pd.DataFrame) -> Picture:
    caption = (
        "Shortest length by target, a contour every R. The two discs stand out because the "
        "length jumps across the front half of their circles; across the rear half it is smooth."
    )
    alt = "Map of shortest lengths"
    return picture("plane-lengths", plot_lengths, exact, caption=caption, alt=alt, height=4.1)


def _jump(exact: pd.DataFrame) -> Picture:
    caption = (
        "The same lengths for the targets within one grid step of a turning circle, by their "
        "place on it. On the front half a target just inside costs up to 2π R more than one just "
        "outside; on the rear half the two sides meet."
    )
    table, alt = along_circle(exact), "Length on both sides of a turning circle"
    return picture("plane-jump", plot_jump, table, caption=caption, alt=alt, height=3.5)


def _failures(number: int, name: str, rows: pd.DataFrame) -> Picture:
    group = rows.drop_duplicates(["target_x", "target_y"])
    right = int(success(group).sum())
    caption = f"{name}: {count(right)} of {count(len(group))} targets right; lengths in R."
    stem, alt = f"plane-solver-{number}", f"Targets {name} gets wrong"
    return picture(stem, plot_failures, group, caption=caption, alt=alt, height=3.9, legend=2)


# Not compared: a plane has a hundred thousand questions that only the closed form answers.
TOPIC = Topic("the target plane", plane_section, "plane", (General.POOLED,))
