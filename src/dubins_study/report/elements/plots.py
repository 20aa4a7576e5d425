"""Plots that most topics use.

A topic passes a table, and a `Mark` for each kind that is drawn. There are quartiles and shares
beside named lines, rising curves of shares, lines over a parameter, and maps of cells. Matplotlib's
constrained layout places the parts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from dubins_study.report.data.attempts import own_name
from dubins_study.report.elements.looks import BEHIND, Names, Palette, common_part, one_line
from dubins_study.report.elements.style import (
    HALF,
    INK,
    MUTED,
    WIDE,
    Style,
    log_axis,
    mark_limit,
    new_figure,
    percent_axis,
    plain_log_axis,
)
from dubins_study.report.statistics.methods import MOST_ENGINES
from dubins_study.study.arrays import FloatArray

# For captions of figures that show `statistics.methods.drawn_methods`.
DRAWN_TEXT = (
    f"Each formulation has at most {MOST_ENGINES} engines, each with its best-supported guess and "
    "settings."
)
MOST_NAMED = 4  # curves of a small panel that a reader can tell apart
HIGHEST = 6.2  # inches: on the page a screen of 900 pixels, the caption not counted
_ACROSS = 3  # panels side by side
_LETTERS = 48  # of a name below a panel
_LETTERS_OF_THREE = 34  # of a name below one of three panels
_MARKERS = ("D", "s", "^", "v")  # open marks that can be seen inside each other


@dataclass(frozen=True)
class Mark:
    """The look of one column, or of one kind."""

    key: str  # the column, or the kind
    label: str = ""  # its name in the legend; empty for its key
    colour: str = INK
    marker: str = ""  # empty for none
    filled: bool = True  # whether the marker is filled
    hatch: str = ""  # of bars; neighbours differ in it, so that grey print keeps them apart

    def dots(self) -> Style:
        """Keywords for markers without a line."""
        face = self.colour
        if not self.filled:
            face = "none"
        return {
            "linestyle": "none",
            "color": self.colour,
            "marker": self.marker,
            "markerfacecolor": face,
        }

    def bar(self) -> Style:
        """Keywords for a bar."""
        return {"facecolor": self.colour, "hatch": self.hatch, "edgecolor": "white", "linewidth": 0}


def quartile_lines(
    table: pd.DataFrame, key: str, palette: Palette, label: str, *, narrow: bool = False
) -> Figure:
    """Draw a median and quartiles of durations (s).

    Each row of the table has a named line; the axis is logarithmic. Columns: those of
    `named_lines`, solver, and `key` (the median), `key`_q1 and `key`_q3. A row whose median is not
    above 0 stays empty.
    """
    figure, axes = named_lines(table, label, narrow=narrow)
    looks = palette.looks(table["solver"])
    ends = table[[f"{key}_q1", key, f"{key}_q3"]].to_numpy(dtype=np.float64)
    positive = ends[ends > 0]
    if not positive.size:
        positive = np.ones(1)
    low = 0.8 * positive.min()
    high = 1.25 * positive.max()
    # The axis spans at least a factor of 6, so that it has a number.
    widen = max(1.0, (6 / (high / low)) ** 0.5)
    for ax, rows in axes:
        for row in rows.to_dict("records"):
            if row[key] > 0:
                look = looks[row["solver"]]
                start = max(row[f"{key}_q1"], low)
                end = row[f"{key}_q3"]
                ax.hlines(row["place"], start, end, color=look.colour, linewidth=2.4, alpha=0.45)
                ax.plot(row[key], row["place"], **look.dots)
        ax.set(xlim=(low / widen, high * widen), xscale="log")
        log_axis(ax.xaxis, "s")
        ax.xaxis.set_major_locator(LogLocator(numticks=3))
    return figure


def stacked_shares(
    table: pd.DataFrame, marks: Sequence[Mark], label: str, *, narrow: bool = False
) -> Figure:
    """Draw one bar of stacked shares for each row.

    The bars of a formulation stand together. Columns: those of `named_lines`, and a share for each
    mark's key. The marks are in the order of the stack, from dark to light. Marks that no row has
    are left out of the legend.
    """
    figure, axes = named_lines(table, label, narrow=narrow)
    present = [mark for mark in marks if table[mark.key].fillna(0).any()]
    for ax, rows in axes:
        places = rows["place"].to_numpy()
        left = np.zeros(len(rows))
        for mark in present:
            width = rows[mark.key].fillna(0).to_numpy(dtype=np.float64)
            shown = width > _THIN
            ax.barh(places[shown], width[shown], left=left[shown], height=0.68, **mark.bar())
            left += width
        ax.set(xlim=(0, 1), xticks=(0, 1))
        percent_axis(ax.xaxis)
    handles = [Patch(label=mark.label or mark.key, **mark.bar()) for mark in present]
    across = min(len(handles), 6)
    if narrow:
        across = 2
    _legend(figure, "upper", handles, across)
    return figure


_THIN = 1e-3  # a bar that is thinner than this share of its axis cannot be seen


_LINE = 0.145  # inches
_SHORTEST_BAR = 0.7  # inches, with the blanks around it
_LETTER = 0.5  # of a font's size: the width of a letter


def named_lines(
    table: pd.DataFrame, label: str, *, narrow: bool
) -> tuple[Figure, list[tuple[Axes, pd.DataFrame]]]:
    """Make a figure of named lines, still without data.

    Returned are the figure, and for each of its columns the axes and the rows to draw there. The
    lines of a formulation stand together. Columns of the table: formulation, short (the name), and
    perhaps note (a text at the right). The returned rows have a column `place`, the height of a
    line. A `narrow` figure has one column, half as wide.
    """
    size = 6.0
    most = _ACROSS
    if narrow:
        size = 6.5
        most = 1
    lines = _placed(table, size, most)
    columns = [rows for _, rows in lines.groupby("column")]
    lowest = lines["place"].max() + 0.5
    high = max(_LINE * lowest + 0.75, 1.7)  # a narrow legend has several lines
    figure = _page_figure(high, narrow=narrow)
    figure.supxlabel(label, fontsize=8, color=MUTED)
    axes = figure.subplots(1, len(columns), squeeze=False)[0]
    panels = list(zip(axes, columns, strict=True))
    for ax, rows in panels:
        ax.tick_params(axis="x", labelsize=size + 0.5)
        ax.set_ylim(lowest, 0)
        _name(ax, rows, size)
    return figure, panels


def _page_figure(high: float, *, narrow: bool) -> Figure:
    """An empty figure of a height (inches).

    It is as wide as the page, or half as wide if `narrow`. A wide figure is at most `HIGHEST` high.
    """
    if narrow:
        return new_figure(HALF, high)
    return new_figure(WIDE, min(HIGHEST, high))


def _placed(table: pd.DataFrame, size: float, most: int) -> pd.DataFrame:
    """A figure's lines with title, place and column.

    `size` is that of the font in points; `most` is the largest number of columns. Fewer columns are
    used where the bars would be too short to be read. The added columns: title (the formulation,
    and what all names below it share), place (height in its column), column (its number). Names are
    shortened in `short`.
    """
    titled = []
    for formulation, rows in table.groupby("formulation", sort=False):
        shared, names = common_part(rows["short"].tolist())
        title = one_line(f"{formulation}{shared}")
        titled.append(rows.assign(short=names, title=title, note=rows.get("note", "")))
    lines = pd.concat(titled)
    groups = lines.groupby("formulation", sort=False)
    # One line is left free above each formulation for its title.
    place = groups.ngroup() + np.arange(len(lines)) + 1.5
    middle = place.groupby(lines["formulation"]).transform("mean")
    letters = (lines["short"] + lines["note"]).str.len()
    for across in range(most, 0, -1):
        # All lines are cut into equal parts; a formulation goes where its middle line falls.
        column = (across * middle / (place.iloc[-1] + 0.5)).astype(int)
        longest = letters.groupby(column).max()
        texts = longest.sum() * _LETTER * size / 72  # inches
        if WIDE - texts >= across * _SHORTEST_BAR:
            break
    first = place.groupby(column).transform("min")
    return lines.assign(place=place - first + 1.5, column=column)


def _name(ax: Axes, rows: pd.DataFrame, size: float) -> None:
    """Write names, notes and titles beside a column's lines."""
    ax.grid(False, axis="y")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0, pad=2)
    ax.set_yticks(rows["place"], rows["short"], color=INK, fontsize=size)
    across = ax.get_yaxis_transform()
    for place, note in zip(rows["place"], rows["note"], strict=True):
        ax.text(1.02, place, note, transform=across, va="center", fontsize=size, color=MUTED)
    width = _LETTER * size * rows["short"].str.len().max()
    for _, top in rows.drop_duplicates("formulation").iterrows():
        ax.annotate(
            top["title"],
            (0, top["place"] - 0.6),
            xycoords=across,
            xytext=(-width, 0),
            textcoords="offset points",
            fontsize=7.5,
            fontweight="bold",
            in_layout=False,
            annotation_clip=False,
        )


def share_curves(
    shares: Mapping[str, pd.DataFrame],
    names: Names,
    palette: Palette,
    xlabel: str,
    ylabel: str = "share of questions",
    *,
    limit: float | None = None,
    same_x: bool = True,
    narrow: bool = False,
) -> Figure:
    """Draw rising shares over a logarithmic axis.

    The figure has one wide panel or several small ones. The panels of a `narrow` figure stand in
    one column.

    `shares` maps the title of each panel to its table: shares in [0, 1], indexed by x (ascending),
    a column per solver. `names` maps solvers to their names; other curves are grey. One of several
    panels names the first `MOST_NAMED` solvers only. A dotted line is drawn at `limit`.
    """
    across = min(_ACROSS, len(shares))
    if narrow:
        across = 1
    down = -(-len(shares) // across)
    letters = _LETTERS
    if across > 1:
        letters = _LETTERS_OF_THREE
    several = len(shares) > 1
    most = None
    panel = 2.2  # inches
    if several:
        most = MOST_NAMED
        panel = 1.2
    chosen = {}
    for title, table in shares.items():
        named = [str(solver) for solver in table if solver in names]
        # plug-ins' solvers first, so that they are named
        chosen[title] = sorted(named, key=lambda solver: not own_name(solver))[:most]
    entries = [len(solvers) for solvers in chosen.values()]
    side_by_side = [entries[start : start + across] for start in range(0, len(entries), across)]
    lines = sum(max(row) for row in side_by_side)  # of the legends below the panels
    figure = _page_figure(0.5 + panel * down + 0.13 * lines, narrow=narrow)
    panels = figure.subplots(down, across, sharex=same_x, sharey=True, squeeze=False).ravel()
    for place, (title, table) in enumerate(shares.items()):
        ax = panels[place]
        shared, short_names = common_part([names[solver] for solver in chosen[title]])
        entries_below = [one_line(name, letters) for name in short_names]
        _draw_shares(ax, table, dict(zip(chosen[title], entries_below, strict=True)), palette)
        ax.set_title(one_line(f"{title}{shared}"), fontsize=7.5, pad=3)
        ax.tick_params(labelsize=6.5, labelbottom=not same_x or place + across >= len(shares))
        if limit is not None:
            mark_limit(ax, limit)
        _scale(ax, float(table.index[0]), float(table.index[-1]))
        if several:
            ax.xaxis.set_major_locator(LogLocator(numticks=3))
            ax.set_yticks((0, 0.5, 1))
    for ax in panels[len(shares) :]:
        ax.remove()
    figure.supxlabel(xlabel, fontsize=8, color=MUTED)
    figure.supylabel(ylabel, fontsize=8, color=MUTED)
    return figure


def _draw_shares(ax: Axes, table: pd.DataFrame, names: Names, palette: Palette) -> None:
    """Draw each column of a table as steps.

    Columns with a name are in colour, and in the legend below the axes; others are grey.
    """
    looks = palette.looks(names)
    lines = {}
    for solver in [*table.columns.difference([*names]), *names]:
        curve = table[solver]
        # Only points at which the curve rises, and its end: the file stays small.
        changed = curve.ne(curve.shift()) | (curve.index == curve.index[-1])
        style = BEHIND
        if solver in looks:
            style = looks[solver].lines | {"linewidth": 1.1}
            if own_name(solver):
                style["linewidth"] = 2.2
        (line,) = ax.step(curve.index[changed], curve[changed], where="post", **style)
        line.set_label(names.get(solver, "_"))
        lines[solver] = line

    def height(solver: str) -> tuple[float, float]:
        return round(table[solver].iloc[-1], 3), table[solver].mean()

    # The legend has the order in which the curves end, from the highest down.
    handles = [lines[solver] for solver in sorted(names, key=height, reverse=True)]
    ax.legend(
        handles=handles,
        fontsize=6.5,
        handlelength=1.8,
        labelspacing=0.15,
        loc="upper left",
        bbox_to_anchor=(0.0, -0.12),
    )
    ax.set(ylim=(0, 1.02))
    percent_axis(ax.yaxis)


def parameter_lines(table: pd.DataFrame, palette: Palette, xlabel: str, ylabel: str) -> Figure:
    """Draw lines over a size, both axes logarithmic.

    Each name has a line. Its marks are open and their size grows from line to line, so that lines
    that coincide stay visible. Columns: solver, name (in the legend), size and value. Only positive
    finite values are drawn.
    """
    values = table["value"]
    shown = table[np.isfinite(values.astype(float)) & (values > 0)]
    looks = palette.looks(shown["solver"])
    groups = shown.groupby("name", sort=False)
    growth = min(1.2, 4 / max(len(groups), 1))
    figure = new_figure(HALF, 3.7)
    ax = figure.subplots()
    handles: dict[str, Artist] = {}
    for place, (name, group) in enumerate(groups):
        look = looks[group["solver"].iloc[0]]
        (handles[str(name)],) = ax.plot(
            group["size"],
            group["value"],
            marker=_MARKERS[place % len(_MARKERS)],
            markerfacecolor="none",
            markersize=3.5 + growth * place,
            linewidth=1.1,
            label=name,
            **look.lines,
        )
    ax.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    log_axis(ax.yaxis)
    _scale(ax, *ax.get_xlim())
    across = 2
    if max(map(len, handles), default=0) > 25:
        across = 1
    _legend(figure, "lower", list(handles.values()), across)
    return figure


def draw_cells(
    ax: Axes, values: FloatArray, x: FloatArray, y: FloatArray, colours: Sequence[str] | str
) -> AxesImage:
    """Fill the cells of a grid.

    A cell without a value stays empty.

    Args:
        ax: where to draw.
        values: shape (m, n); with a list of colours the index of each cell's colour.
        x, y: centres of the cells, shapes (n,) and (m,), evenly spaced.
        colours: a list of colours, or the name of a colour map.
    """
    extent: list[Any] = []
    for centres in (x, y):
        half = 0.5
        if centres.size > 1:
            half = np.diff(centres).mean() / 2
        extent += [centres[0] - half, centres[-1] + half]
    style: Style = {"origin": "lower", "interpolation": "nearest", "cmap": colours}
    if not isinstance(colours, str):
        ends = {"vmin": -0.5, "vmax": len(colours) - 0.5}
        style |= {"cmap": ListedColormap([*colours]), **ends}
    ax.grid(False)
    return ax.imshow(values, extent=tuple(extent), **style)


def _scale(ax: Axes, low: float, high: float) -> None:
    """Make the x axis logarithmic from `low` to `high`.

    A short axis has a number at 1, 2, 5, 10, ...
    """
    ax.set(xscale="log", xlim=(low, high))
    if high / low > 1000:
        log_axis(ax.xaxis)
    else:
        plain_log_axis(ax.xaxis)


def _legend(figure: Figure, side: str, handles: Sequence[Artist], columns: int) -> None:
    """Add a legend above or below the panels.

    `side` is `upper` or `lower`; nothing is added without handles.
    """
    if handles:
        place: Style = {"loc": f"outside {side} left", "ncols": columns}
        figure.legend(handles=handles, fontsize=7.5, columnspacing=1.2, **place)
