"""How figures look, in one place: colours that survive colour blindness and grey printing.

Hues are Okabe and Ito's; every solver also has a marker of its own and every variant a line style.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from dubins_study.report.statistics.metrics import parse_spec, solver_order

INK, MUTED, RULE, PAPER = "#1a1c1f", "#6a7079", "#d5d9de", "#ffffff"
BLUE, VERMILION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PURPLE = "#56b4e9", "#cc79a7"
BROWN, OLIVE = "#7a3b12", "#8a8000"  # not Okabe and Ito's, whose yellow is lost on paper

# on coloured maps, which stay as they are when the page is dark; not equal to those above, which
# the page replaces
ON_MAP, MAP_PAPER = "#1a1c20", "#fffffe"

WIDE, HALF = 7.2, 3.55  # inches: the page's column, and half of it

_SETTINGS = {
    "font.family": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.titlepad": 8,
    "axes.labelsize": 8.5,
    "axes.labelcolor": MUTED,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": RULE,
    "grid.linewidth": 0.5,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 0,
    "ytick.minor.size": 0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "lines.linewidth": 1.4,
    "lines.markersize": 4,
    "text.color": INK,
    "text.parse_math": False,  # names come from outside, and "$" in them is a "$"
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "dubins-study",
    "hatch.linewidth": 0.5,
    "figure.facecolor": PAPER,
    "axes.facecolor": "none",
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
}


class Look(NamedTuple):
    """How a solver is drawn."""

    colour: str
    marker: str
    line: str | tuple[int, tuple[float, ...]]

    @property
    def dots(self) -> dict[str, Any]:
        """Keywords for markers alone."""
        return {"color": self.colour, "marker": self.marker, "linestyle": "none"}

    @property
    def lines(self) -> dict[str, Any]:
        """Keywords for a line without markers."""
        return {"color": self.colour, "linestyle": self.line}

    def curve(self, place: int) -> dict[str, Any]:
        """Keywords for a line of many points: a marker now and then, so that grey print tells
        curves apart; `place` in the list of curves keeps the markers of equal ones apart."""
        every = (0.03 + 0.045 * (place % 5), 0.22)
        return {**self.lines, "marker": self.marker, "markevery": every, "markersize": 3.5}


_KNOWN = {
    "analytic": (INK, "o"),
    "slsqp": (ORANGE, "s"),
    "ipopt": (BLUE, "^"),
    "turn-rate-qp": (GREEN, "D"),
    "collocation": (VERMILION, "v"),
    "shooting": (PURPLE, "P"),
    "heading-milp": (SKY, "X"),
    "disjunctive": (BROWN, "p"),
    "nlp": (OLIVE, "*"),
}
_OTHERS = ((MUTED, "<"), (VERMILION, ">"), (PURPLE, "h"), (SKY, "d"))
LINES: tuple[str | tuple[int, tuple[float, ...]], ...] = (
    "-",
    (0, (4, 1.5)),
    (0, (1, 1.2)),
    (0, (5, 1.5, 1, 1.5)),
)


@contextmanager
def drawing() -> Iterator[None]:
    """The study's settings, whatever the user's own are; drawing and saving both need them."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)  # type: ignore[arg-type]  # a plain dict of settings
        yield


def looks(solvers: Sequence[str]) -> dict[str, Look]:
    """A look for each solver: hue and marker by its name, line style by its settings."""
    found: dict[str, Look] = {}
    seen: dict[str, int] = {}
    others = iter(range(10**6))
    base: dict[str, tuple[str, str]] = dict(_KNOWN)
    for solver in solver_order(list(solvers)):
        name = parse_spec(solver)[0]
        if name not in base:
            base[name] = _OTHERS[next(others) % len(_OTHERS)]
        variant = seen[name] = seen.get(name, -1) + 1
        found[solver] = Look(*base[name], LINES[variant % len(LINES)])
    return found


def new_figure(width: float, height: float) -> Figure:
    """An empty figure (inches) that makes room for its labels."""
    return Figure(figsize=(width, height), layout="constrained")


def name_of(solver: str, width: int = 26) -> str:
    """A solver's name for a figure, settings on lines of their own."""
    name, settings = parse_spec(solver)
    lines, line = [name], ""
    for key, value in settings.items():
        item = f"{key}={value}"
        if line and len(line) + len(item) + 2 > width:
            lines.append(line)
            line = item
        else:
            line = f"{line}, {item}" if line else item
    return "\n".join(part[:60] for part in (*lines, line) if part)


def legend_lines(solvers: Iterable[str], width: int = 26, columns: int = 1) -> int:
    """About how many lines of text a legend of these solvers takes."""
    lines = [name_of(solver, width).count("\n") + 1 for solver in solvers]
    return math.ceil(len(lines) / columns) * max(lines, default=1) if columns > 1 else sum(lines)


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
    """A logarithmic axis with decades labelled; few labels where there are many decades."""
    axis.set_major_locator(LogLocator(numticks=8))
    axis.set_major_formatter(FuncFormatter(label))
    axis.set_minor_formatter(NullFormatter())


def plain_log_axis(axis: Axis) -> None:
    """A logarithmic axis over a few decades: 1, 2, 5, 10, ... labelled as plain numbers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def only_grid(ax: Axes, which: str) -> None:
    """Keep the rules of one axis: `x` or `y`."""
    ax.grid(False)
    ax.grid(True, axis="x" if which == "x" else "y")
