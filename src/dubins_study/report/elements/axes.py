"""Axes of figures: logarithmic axes with plain labels, durations, shares, grid lines."""

from __future__ import annotations

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from dubins_study.report.elements.style import MUTED

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
