"""Maps of where attempts fail."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dubins_study.report.data.failures import KINDS, REACH
from dubins_study.report.elements.axes import percent_axis
from dubins_study.report.elements.plane_axes import draw_circles
from dubins_study.report.elements.style import MUTED, WIDE, new_figure

# From hardly any to all; one hue from light to dark, so that grey print keeps the order.
_SHADES = LinearSegmentedColormap.from_list("failures", ["#fdf3ea", "#f2a468", "#7a2400"])
_EMPTY = "#d5d9df"  # a cell without a target
_HEIGHT = 2.15  # inches


def plot_failure_map(shares: Mapping[str, NDArray[np.float64]]) -> Figure:
    """One map per kind of failure: the share of each cell's attempts, on one scale.

    Args:
        shares: of `numbers.FailureMap`.
    """
    figure = new_figure(WIDE, _HEIGHT)
    # as many places as there are kinds, so that the maps of all reports have one size
    panels = figure.subplots(1, len(KINDS), sharey=True, squeeze=False)[0]
    highest = max(float(np.nanmax(values)) for values in shares.values())
    ends = np.array([-REACH, REACH])
    for ax, (kind, values) in zip(panels, shares.items(), strict=False):
        ax.set_facecolor(_EMPTY)
        image = ax.imshow(
            values,
            origin="lower",
            extent=(-REACH, REACH, -REACH, REACH),
            cmap=_SHADES,
            interpolation="nearest",
            vmin=0,
            vmax=highest,
        )
        draw_circles(ax, ends, ends)
        ax.set_title(kind)
        if ax is not panels[0]:
            ax.set_ylabel("")
    for ax in panels[len(shares) :]:
        ax.remove()
    bar = figure.colorbar(image, ax=panels[: len(shares)].tolist(), shrink=0.8, pad=0.02)
    bar.outline.set_visible(False)
    percent_axis(bar.ax.yaxis)
    bar.set_label("share of attempts", color=MUTED)
    return figure
