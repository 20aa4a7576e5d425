"""Figures with one line per solver: its name on the left, bars or marks to the right of it."""

from __future__ import annotations

import textwrap
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from dubins_study.report.elements.axes import only_grid, percent_axis
from dubins_study.report.elements.looks import Look, Palette, name_of
from dubins_study.report.elements.style import INK, MUTED, Style


def label_lines(
    ax: Axes, solvers: Iterable[str], places: ArrayLike, palette: Palette | None = None
) -> None:
    """Write the solvers' names to the left of their lines; draw grid lines for the values only.

    The names are the page's short ones if its palette is given, else the specs.
    """
    names = [wrapped(palette.label(solver)) if palette else name_of(solver) for solver in solvers]
    ax.set_yticks(np.asarray(places), names, color=INK)
    ax.set_ylim(-0.6, len(names) - 0.4)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def wrapped(name: str) -> str:
    """A short name over several lines if it is long."""
    return "\n".join(textwrap.wrap(name, _MOST_CHARACTERS, break_long_words=False))


_MOST_CHARACTERS = 32


def plot_quartiles(
    ax: Axes, row: Mapping[Hashable, Any], key: str, place: float, look: Look, fill: str = ""
) -> None:
    """Draw a duration's median as a mark and its quartiles as a bar, on the line at `place`.

    `row` holds the median (s) under `key`, and the quartiles under `key` with `_q1` and `_q3`.
    `fill` is the colour inside the mark; if it is empty, the solver's colour.
    """
    ends = [max(row[f"{key}_q1"], 1e-9), row[f"{key}_q3"]]
    bar: Style = {"color": look.colour, "linewidth": 2.4, "alpha": 0.45, "solid_capstyle": "butt"}
    ax.plot(ends, [place] * 2, **bar)
    ax.plot(row[key], place, **(look.dots | {"markerfacecolor": fill or look.colour}))


def plot_shares(
    ax: Axes,
    table: pd.DataFrame,
    look: Mapping[str, tuple[str, str]],
    notes: Sequence[str],
    palette: Palette | None = None,
) -> None:
    """Draw one stacked bar per solver: each column of `look` as a share of `attempts`.

    Args:
        ax: where to draw.
        table: columns solver, attempts, and a count for each name in `look`.
        look: column -> colour and hatch, in the order of the stack.
        notes: texts to the right of the bars, one per row.
        palette: of the page, for its short names.
    """
    places = np.arange(len(table))[::-1]
    left = np.zeros(len(table))
    for name, (colour, hatch) in look.items():
        width = table[name].to_numpy() / table["attempts"].to_numpy()
        if not width.any():
            continue
        style: Style = {"color": colour, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
        ax.barh(places, width, left=left, height=0.62, label=name, **style)
        left += width
    for place, note in zip(places, notes, strict=True):
        ax.text(1.015, place, note, va="center", fontsize=7.5, color=MUTED)
    label_lines(ax, table["solver"], places, palette)
    ax.set(xlim=(0, 1), xlabel="share of all attempts")
    percent_axis(ax.xaxis)
