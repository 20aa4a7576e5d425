"""Figures of curves with room for their names, whose places are computed from the names' widths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dubins_study.report.elements.names import one_line
from dubins_study.report.elements.panels import HIGHEST
from dubins_study.report.elements.style import MUTED, WIDE, Style, add_panel, text_width

_ACROSS = 3
_NAME, _TITLE, _SMALL = 6.0, 7.5, 6.5  # points: names of curves, of panels, of axes
# Inches: a panel's title, its tick labels, an axis' name, a gap.
_HEAD, _TICKS, _LABEL, _GAP = 0.26, 0.17, 0.2, 0.1
_PERCENT = 0.36  # inches: the labels of an axis of shares
_HANDLE = 0.32  # inches: from the end of a curve to its name
_HIGHEST_PANEL = 1.35  # inches
_NAMES_APART = 0.095  # inches: names of curves, of which a panel holds as many as it is high


def curve_panels(
    names: Mapping[str, Sequence[str]], xlabel: str, ylabel: str, same_x: bool = True
) -> tuple[Figure, dict[str, Axes]]:
    """A figure as wide as the page, with small panels side by side, one per title.

    To the right of each panel there is room for the names of its curves (`axes.label_curves`).

    Args:
        names: title -> the names of the curves of its panel.
        xlabel, ylabel: of all panels.
        same_x: whether all panels share the horizontal axis, which the lowest then label.
    """
    titles = list(names)
    ticks = 0.0 if same_x else _TICKS
    foot = _LABEL + _TICKS - ticks
    most = max(map(len, names.values()))
    for across in range(min(2, len(titles)), _ACROSS + 1):
        down = -(-len(titles) // across)
        tall = min(_HIGHEST_PANEL, (HIGHEST - foot) / down - _HEAD - ticks)
        if tall >= most * _NAMES_APART:
            break
    height = foot + down * (tall + _HEAD + ticks)
    figure = Figure(figsize=(WIDE, height))
    after = [
        _HANDLE + max(text_width(name, _NAME) for t in titles[c::across] for name in names[t])
        for c in range(across)
    ]
    left = _LABEL + _PERCENT
    width = (WIDE - left - sum(after) - across * _GAP) / across
    panels = {}
    for number, title in enumerate(titles):
        row, column = divmod(number, across)
        x = left + column * (width + _GAP) + sum(after[:column])
        y = height - (row + 1) * (_HEAD + tall) - row * ticks
        ax = panels[title] = add_panel(figure, (x, y, width, tall))
        ax.set_title(one_line(title), fontsize=_TITLE, pad=3)
        lowest = number + across >= len(titles)
        ax.tick_params(labelsize=_SMALL, pad=1.5)
        ax.xaxis.set_tick_params(labelbottom=lowest or not same_x)
        ax.yaxis.set_tick_params(labelleft=column == 0)
    figure.text(0.5, 0.05 / height, xlabel, ha="center", fontsize=8, color=MUTED)
    side: Style = {"rotation": "vertical", "va": "center", "fontsize": 8, "color": MUTED}
    figure.text(0.05 / WIDE, 0.5, ylabel, **side)
    return figure, panels


def curve_panel(
    names: Sequence[str], xlabel: str, ylabel: str, height: float = 2.9
) -> tuple[Figure, Axes]:
    """One panel as wide as the page, with room for the names of its curves at its right.

    Args:
        names: of the curves.
        xlabel, ylabel: of the axes.
        height: of the figure (inches).
    """
    figure = Figure(figsize=(WIDE, height))
    left, foot = _LABEL + 1.3 * _PERCENT, _LABEL + 0.25
    right = _HANDLE + max(text_width(name, _TITLE) for name in names)
    box = (left, foot, max(2.0, WIDE - left - right - _GAP), height - foot - 0.2)
    ax = add_panel(figure, box)
    ax.set(xlabel=xlabel, ylabel=ylabel)
    return figure, ax
