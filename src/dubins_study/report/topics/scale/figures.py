"""Gap against the unit of length."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from dubins_study.report.elements.axes import log_axis, mark_limit, power
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import Style
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.scale.numbers import ROUNDING

_MOST_LETTERS = 34  # of a solver's name in the figure


def plot_scale(
    ax: Axes, rows: pd.DataFrame, palette: Palette, foot: float, top: float
) -> dict[str, Line2D]:
    """Draw one scenario's gap over the radius, one line per solver; returns name -> line.

    Columns: solver, radius, gap (relative; NaN if the path does not arrive). Gaps within rounding
    are drawn at `foot`, answers that do not arrive at `top`.
    """
    looks, curves = palette.looks(rows["solver"]), {}
    names = palette.names(rows["solver"])
    for place, solver in enumerate(solver_order(rows["solver"].tolist())):
        group = rows[rows["solver"] == solver].sort_values("radius")
        gap = group["gap"].where(group["gap"] > ROUNDING, foot).where(group["gap"].notna(), top)
        # Many are exact: draw each solver a little higher than the last, so that all are visible.
        gap = gap.where(gap > foot, foot * 10 ** (0.28 * place))
        look = looks[solver]
        style: Style = {"marker": look.marker, "markersize": 3}
        (curve,) = ax.plot(group["radius"], gap, **style, **look.lines)
        curves[names[solver][:_MOST_LETTERS]] = curve
    mark_limit(ax, ROUNDING, "y")
    ax.set(xscale="log", yscale="log", ylim=(foot / 3, top * 4))
    log_axis(ax.xaxis)
    ax.xaxis.set_major_locator(LogLocator(numticks=5))
    ax.grid(True, axis="x")
    ticks = 10.0 ** np.arange(round(np.log10(ROUNDING)), round(np.log10(top)) - 1, 3)
    texts = [power(tick) for tick in ticks]
    ax.set_yticks([foot * 10, *ticks, top], ["rounding", *texts, "misses"])
    return curves
