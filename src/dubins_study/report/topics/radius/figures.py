"""Length, word and time against the turning radius, for one start and target."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from dubins_study.report.elements.axes import duration, label_curves, log_axis, plain_log_axis
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.style import INK, MUTED
from dubins_study.report.topics.radius.numbers import Sweep

_CLEAR = 1.15  # so far above the shortest length a line has room for its name
_MOST_LETTERS = 34  # of a solver's name in the figure
_WORD_SHADE = {"LS": 0.06, "RS": 0.12, "RL": 0.22, "LR": 0.3}
_WORD_LINE = {"LS": LINES[1], "RS": LINES[2]}


def plot_length(ax: Axes, sweep: Sweep, palette: Palette) -> None:
    """Draw the shortest length over radius, its words and R*, and every answer visibly wrong.

    The line breaks where the word changes, since the length may jump there.
    """
    radii, lengths = sweep.shortest["radius"].to_numpy(), sweep.shortest["length"].to_numpy()
    ax.set(xscale="log", xlim=(radii.min(), radii.max()))
    plain_log_axis(ax.xaxis)
    for span in sweep.spans:
        shade = _WORD_SHADE.get(span.word, 0.02)
        ax.axvspan(span.left, span.right, color=MUTED, alpha=shade, linewidth=0, zorder=0)
        middle, across = np.sqrt(span.left * span.right), ax.get_xaxis_transform()
        ax.text(middle, 0.97, span.word, transform=across, va="top", ha="center")
        ax.plot(radii[span.first : span.past], lengths[span.first : span.past], color=INK, zorder=3)
    for word, group in sweep.single_words.groupby("word"):
        line = _WORD_LINE[str(word)]
        ax.plot(
            group["radius"], group["length"], color=MUTED, linestyle=line, linewidth=0.9, zorder=2
        )
        _name_word(ax, group.dropna(), sweep, str(word))
    _wrong_answers(ax, sweep.wrong, palette)
    _circle_mark(ax, sweep.circle, f"R* = {digits(4)(sweep.circle)}")
    longest = float(np.nanmax([lengths.max(), *sweep.wrong["length"]]))
    _length_scale(ax, lengths.min(), longest)


def _name_word(ax: Axes, line: pd.DataFrame, sweep: Sweep, word: str) -> None:
    """Name the line of one word where it is clear of the shortest words, which have their names."""
    lengths = np.interp(line["radius"], sweep.shortest["radius"], sweep.shortest["length"])
    clear = line[line["length"] > _CLEAR * lengths]
    if clear.empty:
        return
    middle = clear.iloc[len(clear) // 2]
    point = (middle["radius"], middle["length"])
    ax.annotate(word, point, xytext=(-3, 3), textcoords="offset points", ha="right", color=MUTED)


def _length_scale(ax: Axes, foot: float, top: float) -> None:
    ax.set_ylabel("length")
    if foot > 0:  # a logarithmic scale shows the jump and lengths that grow with the radius
        ax.set(yscale="log", ylim=(0.75 * foot, top * (top / foot) ** 0.15 * 1.2))
        plain_log_axis(ax.yaxis)
    else:
        ax.set_ylim(0, 1.22 * top or 1.0)
        ax.yaxis.set_major_locator(MaxNLocator(5))


def _wrong_answers(ax: Axes, wrong: pd.DataFrame, palette: Palette) -> None:
    looks, names = palette.looks(wrong["solver"]), palette.names(wrong["solver"])
    for solver, look in looks.items():
        group = wrong[wrong["solver"] == solver]
        arrived, lost = group[group["arrives"]], group[~group["arrives"]]
        dots = look.dots | {"markersize": 3.5, "markerfacecolor": "none", "zorder": 4}
        dots |= {"label": names[solver][:_MOST_LETTERS]}
        ax.plot(arrived["radius"], arrived["length"], **dots)
        if len(lost):  # an empty line off the data's axes would upset the layout
            foot = np.full(len(lost), 0.03)
            dots |= {"marker": "x"} | ({"label": "_again"} if len(arrived) else {})
            ax.plot(lost["radius"], foot, transform=ax.get_xaxis_transform(), **dots)
    if looks:
        ax.legend(loc="lower right", fontsize=6.5, handletextpad=0.3)


def plot_time(ax: Axes, sweep: Sweep, solvers: Sequence[str], palette: Palette) -> None:
    """Draw some solvers' median time over the radius, each named at the end of its curve.

    The axes must have their final place.
    """
    looks, names, curves = palette.looks(solvers), palette.names(solvers), {}
    for place, solver in enumerate(solvers):
        group = sweep.times[sweep.times["solver"] == solver]
        style = looks[solver].curve(place) | {"linewidth": 1.1}
        (curve,) = ax.plot(group["radius"], group["wall_s"], **style)
        curves[names[solver][:_MOST_LETTERS]] = curve
    ends = sweep.shortest["radius"].min(), sweep.shortest["radius"].max()
    ax.set(xscale="log", xlim=ends, yscale="log", ylabel="median time")
    log_axis(ax.yaxis, duration)
    plain_log_axis(ax.xaxis)
    _circle_mark(ax, sweep.circle, "R*")
    label_curves(ax, curves)


def _circle_mark(ax: Axes, circle: float, text: str = "") -> None:
    """A dotted line at R*, which a target straight ahead does not have."""
    low, high = ax.get_xlim()
    if not low < circle < high:
        return
    ax.axvline(circle, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))
    above = ax.get_xaxis_transform()
    ax.text(circle, 1.02, text, transform=above, ha="center", fontsize=8, color=MUTED)
