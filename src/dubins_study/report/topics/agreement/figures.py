"""The agreement matrix."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm

from dubins_study.report.elements.formats import digits, share
from dubins_study.report.elements.style import BLUE, INK, MAP_PAPER, MUTED, ON_MAP, Style

# One hue from light to dark, so that the order stays visible in grey print.
_DEPTH = LinearSegmentedColormap.from_list("depth", ["#f4f7fa", "#9cc6e0", BLUE, "#0b2f47"])
_SMALLEST, _LARGEST = 1e-16, 1.0


def plot_agreement(ax: Axes, pairs: pd.DataFrame, labels: Mapping[str, str]) -> None:
    """Draw the largest length difference below the diagonal, the share within 1e-6 above it.

    Columns: first, second, both, largest, within; in the order of the solvers. `labels` are names
    to show instead of the solvers' own.
    """
    solvers = list(dict.fromkeys([*pairs["first"], *pairs["second"]]))
    n = len(solvers)
    depth = np.full((n, n), np.nan)
    centred: Style = {"ha": "center", "va": "center", "fontsize": 8.5 if n < 10 else 6.5}
    depth_text = digits(2) if n < 10 else digits(1)
    share_text = share if n < 10 else _short_share
    for row in pairs[pairs["both"] > 0].to_dict("records"):
        i, j = sorted((solvers.index(row["first"]), solvers.index(row["second"])))
        depth[j, i] = min(max(row["largest"], _SMALLEST), _LARGEST)
        ink = MAP_PAPER if depth[j, i] > 1e-6 else ON_MAP
        ax.text(i, j, depth_text(row["largest"]), color=ink, **centred)
        ax.text(j, i, share_text(row["within"]), color=INK, **centred)
    norm = LogNorm(_SMALLEST, _LARGEST)
    ax.imshow(depth, cmap=_DEPTH, norm=norm, interpolation="nearest", aspect="auto")
    names = [f"{labels.get(solver, solver)}   {i}" for i, solver in enumerate(solvers, 1)]
    ax.set_yticks(range(n), names, color=INK)
    ax.set_xticks(range(n), [str(i) for i in range(1, n + 1)], color=INK)
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.plot([-0.5, n - 0.5], [-0.5, n - 0.5], color=MUTED, linewidth=0.5)


def _short_share(value: float) -> str:
    """A share in whole per cent, for narrow cells; 0 % and 100 % only of none and of all."""
    percent = 100 * value
    if 0 < percent < 1:
        return "<1 %"
    return ">99 %" if 99 < percent < 100 else f"{percent:.0f} %"
