"""Axes of figures: logarithmic axes with plain labels, durations, grid lines, named curves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import ArrayLike

from dubins_study.report.elements.style import MUTED
from dubins_study.study.path import FloatArray

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power(value: float, _: object = None) -> str:
    """A power of ten as a tick label, without mathtext; plain from 0.01 to 1000."""
    if value <= 0:
        return "0"
    exponent = round(math.log10(value))
    if abs(value / 10.0**exponent - 1) > 1e-6:
        return ""
    return f"{value:g}" if -2 <= exponent <= 3 else "10" + str(exponent).translate(_RAISED)


def duration(value: float, _: object = None) -> str:
    """A power of ten of seconds as a tick label with its own unit."""
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= 0.999 * factor:
            return f"{value / factor:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def log_axis(axis: Axis, label: Any = power) -> None:
    """Make an axis logarithmic and label its decades; label fewer if there are many decades."""
    axis.set_major_locator(LogLocator(numticks=8))
    axis.set_major_formatter(FuncFormatter(label))
    axis.set_minor_formatter(NullFormatter())


def plain_log_axis(axis: Axis) -> None:
    """Make an axis logarithmic and label 1, 2, 5, 10, ... as plain numbers, for few decades."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def only_grid(ax: Axes, which: str) -> None:
    """Draw the grid lines of one axis only: `x` or `y`."""
    ax.grid(False)
    ax.grid(True, axis="x" if which == "x" else "y")


def mark_limit(ax: Axes, place: float, across: str = "x") -> Line2D:
    """Draw a thin dotted line at a limit: vertical for `across="x"`, horizontal for `"y"`."""
    draw = ax.axvline if across == "x" else ax.axhline
    return draw(place, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))


def percent_axis(axis: Axis) -> None:
    """Label shares as percentages."""
    axis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")


_SPACING = 1.2  # height of a line of text over the size of its letters
_DROP, _RULE = 0.08, 0.26  # inches to the right of the axes: where a name's rule begins and ends


def spread_labels(places: ArrayLike, distance: float, room: tuple[float, float]) -> FloatArray:
    """Places of labels near the ends of their curves, at least a distance apart.

    The labels keep the order of the places, and each group that must move is centred on its
    places: least squares under the order (pool adjacent violators). If the room is too small for
    the distance, the labels share it evenly.

    Args:
        places: where the curves end, in any order, shape (n,).
        distance: between neighbours, in the places' unit.
        room: smallest and largest place of a label.
    """
    wanted = np.asarray(places, dtype=np.float64)
    low, high = room
    if wanted.size > 1:
        distance = min(distance, (high - low) / (wanted.size - 1))
    order = np.argsort(wanted, kind="stable")
    steps = distance * np.arange(wanted.size)
    groups: list[tuple[float, int]] = []  # mean of the places without their steps, and number
    for value in wanted[order] - steps:
        mean, number = float(value), 1
        while groups and groups[-1][0] >= mean:
            other, others = groups.pop()
            mean, number = (mean * number + other * others) / (number + others), number + others
        groups.append((mean, number))
    flat = np.repeat([mean for mean, _ in groups], [number for _, number in groups])
    result = np.empty_like(wanted)
    if wanted.size:
        result[order] = np.clip(flat, low, max(low, high - steps[-1])) + steps
    return result


def label_curves(ax: Axes, lines: Mapping[str, Line2D], size: float = 6.0) -> None:
    """Write each curve's name at its right end, beside the axes; no two names overlap.

    The axes must have their final size. A thin line leads from the end of the curve to its name,
    with the curve's dashes, and its marker if it has one.
    """
    figure = ax.figure
    assert figure is not None
    width, height = ax.get_position().size * figure.get_figure(root=True).get_size_inches()
    box = ax.transAxes.inverted()
    curves = {
        name: box.transform(ax.transData.transform(_points(line, ax)))
        for name, line in lines.items()
    }
    # Curves that end together are named in the order in which they come from below.
    order = sorted(
        curves, key=lambda name: (round(curves[name][-1, 1], 3), curves[name][:, 1].mean())
    )
    ends = np.clip([curves[name][-1, 1] for name in order], 0, 1) + 1e-6 * np.arange(len(order))
    step = _SPACING * size / 72 / height
    places = spread_labels(ends, step, (0.3 * step, 1 - 0.45 * step))
    right = [1 + inches / width for inches in (0, _DROP, (_DROP + _RULE) / 2, _RULE)]
    outside: dict[str, Any] = {"transform": ax.transAxes, "clip_on": False}
    for name, end, place in zip(order, ends, places, strict=True):
        line = lines[name]
        thin: dict[str, Any] = {"color": line.get_color(), "linewidth": 0.5}
        ax.add_artist(Line2D(right[:2], [end, place], **thin, **outside))
        rule = Line2D([], [])
        rule.update_from(line)
        rule.set(xdata=right[1:], ydata=[place] * 3, drawstyle="default", markevery=[1], **outside)
        ax.add_artist(rule)
        at = 1 + (_RULE + 0.04) / width
        ax.text(at, place, name, va="center_baseline", fontsize=size, transform=ax.transAxes)


def _points(line: Line2D, ax: Axes) -> FloatArray:
    """The points of a curve inside the axes, the last at the right edge or where it ends."""
    x, y = (np.asarray(values, dtype=np.float64) for values in line.get_data())
    inside = (x <= max(ax.get_xlim())) & np.isfinite(y)
    return np.column_stack([x[inside], y[inside]])


def step_curve(x: FloatArray, y: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A step function as coarse as a panel can show it: those points where it has changed.

    Its value at a point is that at the last `x` up to it; 0 before the first.

    Args:
        x: ascending, shape (n,).
        y: shape (n,).
        points: ascending, shape (m,).
    Returns:
        Some of the points, the first and the last among them, and the values there.
    """
    values = np.concatenate(([0.0], y))[np.searchsorted(x, points, side="right")]
    changed = np.ones(len(points), dtype=bool)
    changed[1:-1] = values[1:-1] != values[:-2]
    return points[changed], values[changed]
