"""Gap against the unit of length."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import log_axis, mark_limit, power
from dubins_study.report.elements.looks import Palette, name_of
from dubins_study.report.elements.style import Style
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.scale.numbers import ROUNDING


def plot_scale(ax: Axes, rows: pd.DataFrame, palette: Palette, foot: float, top: float) -> None:
    """Draw one scenario's gap over the radius, one line per solver.

    Columns: solver, radius, gap (relative; NaN if the path does not arrive). Gaps within rounding
    are drawn at `foot`, answers that do not arrive at `top`.
    """
    looks = palette.looks(rows["solver"])
    for place, solver in enumerate(solver_order(rows["solver"].tolist())):
        group = rows[rows["solver"] == solver].sort_values("radius")
        gap = group["gap"].where(group["gap"] > ROUNDING, foot).where(group["gap"].notna(), top)
        # Many are exact: draw each solver a little higher than the last, so that all are visible.
        gap = gap.where(gap > foot, foot * 10 ** (0.28 * place))
        look = looks[solver]
        style: Style = {"marker": look.marker, "markersize": 3, "label": name_of(solver)}
        ax.plot(group["radius"], gap, **style, **look.lines)
    mark_limit(ax, ROUNDING, "y")
    ax.set(xscale="log", yscale="log", ylim=(foot / 3, top * 4))
    ax.set(xlabel="turning radius R (length unit)")
    log_axis(ax.xaxis)
    ax.grid(True, axis="x")
    ticks = 10.0 ** np.arange(round(np.log10(ROUNDING)), round(np.log10(top)) - 1, 3)
    texts = [power(tick) for tick in ticks]
    ax.set_yticks([foot * 10, *ticks, top], ["rounding", *texts, "misses"])
