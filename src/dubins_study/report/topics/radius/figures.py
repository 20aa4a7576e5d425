"""Length, word and time against the turning radius, for one start and target."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from dubins_study.report.elements.axes import duration, log_axis, plain_log_axis
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES, Palette, name_of
from dubins_study.report.elements.style import INK, MUTED
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.radius.numbers import Sweep

WARM = ", warm"
_WORD_SHADE = {"LS": 0.06, "RS": 0.12, "RL": 0.22, "LR": 0.3}
_WORD_LINE = {"LS": LINES[1], "RS": LINES[2]}


def plot_length(ax: Axes, sweep: Sweep, palette: Palette) -> None:
    """Draw the shortest length over radius, its words, and every answer that is not shortest.

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
    _wrong_answers(ax, sweep.wrong, palette)
    _circle_mark(ax, sweep.circle, f"R* = {digits(4)(sweep.circle)}")
    longest = float(np.nanmax([lengths.max(), *sweep.wrong["length"]]))
    _length_scale(ax, lengths.min(), longest)


def _length_scale(ax: Axes, foot: float, top: float) -> None:
    ax.set_ylabel("length")
    if foot > 0:  # a logarithmic scale shows the jump and lengths that grow with the radius
        ax.set(yscale="log", ylim=(0.75 * foot, top * (top / foot) ** 0.15 * 1.2))
        plain_log_axis(ax.yaxis)
    else:
        ax.set_ylim(0, 1.22 * top or 1.0)
        ax.yaxis.set_major_locator(MaxNLocator(5))


def _wrong_answers(ax: Axes, wrong: pd.DataFrame, palette: Palette) -> None:
    looks = palette.looks(wrong["solver"])
    for solver, look in looks.items():
        group = wrong[wrong["solver"] == solver]
        arrived, lost = group[group["arrives"]], group[~group["arrives"]]
        dots = look.dots | {"markersize": 3.5, "markerfacecolor": "none", "zorder": 4}
        ax.plot(arrived["radius"], arrived["length"], **dots)
        if len(lost):  # an empty line off the data's axes would upset the layout
            foot = np.full(len(lost), 0.03)
            dots |= {"marker": "x"}
            ax.plot(lost["radius"], foot, transform=ax.get_xaxis_transform(), **dots)


def plot_time(ax: Axes, sweep: Sweep, palette: Palette) -> None:
    """Median time of each solver over radius, cold solid and warm dotted."""
    times = sweep.times
    looks = palette.looks(times["solver"])
    for place, solver in enumerate(solver_order(times["solver"].tolist())):
        for guess, line in (("cold", LINES[0]), ("warm", LINES[2])):
            group = times[(times["solver"] == solver) & (times["initial_guess"] == guess)]
            if group.empty:
                continue
            curve = looks[solver].curve(place) | {"linestyle": line, "linewidth": 1.1}
            label = name_of(solver) + (WARM if guess == "warm" else "")
            ax.plot(group["radius"], group["wall_s"], **curve, label=label)
    ax.set(yscale="log", ylabel="time", xlabel="turning radius R")
    log_axis(ax.yaxis, duration)
    plain_log_axis(ax.xaxis)
    _circle_mark(ax, sweep.circle)


def _circle_mark(ax: Axes, circle: float, text: str = "") -> None:
    """A dotted line at R*, which a target straight ahead does not have."""
    low, high = ax.get_xlim()
    if not low < circle < high:
        return
    ax.axvline(circle, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))
    above = ax.get_xaxis_transform()
    ax.text(circle, 1.02, text, transform=above, ha="center", fontsize=8, color=MUTED)
