"""The look of figures: colours, sizes, axes, files.

On the light page and on the dark one a hue has a contrast of at least 3 to 1 (the ratio of WCAG
2.2, success criterion 1.4.11, for graphical objects). The engines' hues are as far apart as ten can
be at that contrast, also for readers with protanopia or deuteranopia; a test measures both.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any, NamedTuple, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter, FuncFormatter, LogLocator, NullFormatter

Style: TypeAlias = dict[str, Any]  # keywords of matplotlib


class Hue(NamedTuple):
    """One hue on the light and the dark page.

    The values are `#rrggbb`.
    """

    light: str
    dark: str


# Hues of kinds: verdicts, proofs, parts of a cost. From dark to light and hatched where they meet.
HUES = {
    "blue": Hue("#0072b2", "#4aa8e0"),
    "vermilion": Hue("#d55e00", "#f08a4b"),
    "green": Hue("#009e73", "#2fc39a"),
    "orange": Hue("#b87a00", "#e6ac3a"),
}

# Hues of engines, in the order in which engines get them.
ENGINE_HUES = (
    Hue("#1473b2", "#4696cb"),  # blue
    Hue("#ba5f47", "#ef790f"),  # orange
    Hue("#14a381", "#1fc09d"),  # teal
    Hue("#732623", "#c4604d"),  # brown
    Hue("#8a5ae4", "#b981fe"),  # violet
    Hue("#b88302", "#efcc31"),  # ochre
    Hue("#2b2f9e", "#6b6df1"),  # navy
    Hue("#535f09", "#a1c266"),  # olive
    Hue("#c0388e", "#f399cf"),  # magenta
    Hue("#0f9cd4", "#9ddcff"),  # sky
)
_NAMED = HUES | {f"engine-{place}": hue for place, hue in enumerate(ENGINE_HUES, 1)}

# Value in a figure's file -> the page's variable, so that a figure follows the page's mode.
VARIABLES = {hue.light: f"--{name}" for name, hue in _NAMED.items()}

INK = "#1a1c1f"
MUTED = "#6a7079"
RULE = "#d5d9de"
PAPER = "#ffffff"
BLUE, VERMILION, GREEN, ORANGE = (hue.light for hue in HUES.values())

# Colours for maps. The dark page replaces INK and PAPER, but must not replace these, so they differ
# by one digit.
ON_MAP = "#1a1c20"
MAP_PAPER = "#fffffe"

# inches: 180 and 88 mm, two columns of a journal and one; on the page its column, and half of it
WIDE = 180 / 25.4
HALF = 88 / 25.4

_SETTINGS: Style = {
    "font.family": ["DejaVu Sans"],
    **dict.fromkeys(("font.size", "axes.labelsize"), 8.5),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8),
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.titlepad": 8,
    **dict.fromkeys(("axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), MUTED),
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.6),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": RULE,
    "grid.linewidth": 0.5,
    **dict.fromkeys(("xtick.major.size", "ytick.major.size"), 2.5),
    **dict.fromkeys(("xtick.minor.size", "ytick.minor.size"), 0),
    "legend.handlelength": 2.2,
    "lines.linewidth": 1.4,
    "lines.markersize": 4,
    "text.color": INK,
    "text.parse_math": False,  # a "$" in a name from outside must stay a "$"
    "svg.fonttype": "none",  # text stays text
    "pdf.fonttype": 42,  # TrueType: journals refuse matplotlib's default, Type 3
    "svg.hashsalt": "dubins-study",
    "hatch.linewidth": 0.5,
    "figure.facecolor": PAPER,
    "axes.facecolor": "none",
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
}


def css_values(mode: str) -> str:
    """The CSS declarations of all hues, e.g. `--blue: #0072b2;`.

    `mode` is that of the page: `light` or `dark`.
    """
    return " ".join(f"--{name}: {getattr(hue, mode)};" for name, hue in _NAMED.items())


@contextmanager
def drawing() -> Iterator[None]:
    """Use the study's matplotlib settings inside `with`.

    Figures have to be drawn and saved inside the block. The caller's settings come back after it.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)  # type: ignore[arg-type]  # a plain dict of settings
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure whose layout makes room for labels.

    Width and height are in inches.
    """
    return Figure(figsize=(width, height), layout="constrained")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power(value: float, _: object = None) -> str:
    """The tick label of a power of ten.

    It is plain from 0.01 to 1000 and `10⁴` beyond: Unicode, no mathtext. A value that is no power
    of ten has an empty label.
    """
    if value <= 0:
        return "0"
    exponent = round(math.log10(value))
    if abs(value / 10.0**exponent - 1) > 1e-6:
        return ""
    if -2 <= exponent <= 3:
        return f"{value:g}"
    return "10" + str(exponent).translate(_RAISED)


def log_axis(axis: Axis, unit: str = "") -> None:
    """Label the decades of a logarithmic axis.

    With a unit, labels are like `1 ms`. If there are many decades, only some have a label.
    """
    axis.set_major_locator(LogLocator(numticks=8))
    if unit:
        axis.set_major_formatter(EngFormatter(unit))
    else:
        axis.set_major_formatter(FuncFormatter(power))
    axis.set_minor_formatter(NullFormatter())


def plain_log_axis(axis: Axis) -> None:
    """Label a logarithmic axis with plain numbers.

    The labels are at 1, 2, 5, 10, ...; they suit an axis of few decades.
    """
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def mark_limit(ax: Axes, place: float, across: str = "x") -> Line2D:
    """Draw a thin dotted line at a limit.

    Vertical for `across="x"`, horizontal for `"y"`.
    """
    dotted: Style = {"color": MUTED, "linewidth": 0.8, "linestyle": (0, (1, 2))}
    if across == "x":
        return ax.axvline(place, **dotted)
    return ax.axhline(place, **dotted)


def percent_axis(axis: Axis) -> None:
    """Label shares as percentages."""
    axis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")


_DPI = 200  # of pictures inside a figure; lines and letters stay lines and letters
_PLACE_DECIMALS = 6  # of the figure's size: less than a thousandth of a point


def fix_layout(figure: Figure) -> None:
    """Compute a figure's layout once, for all files.

    The figure is changed in place: its axes keep their places. The layout takes most of the time of
    saving.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        # At a low resolution the letters' widths are those of whole pixels.
        dpi = figure.dpi
        figure.set_dpi(_DPI)
        FigureCanvasAgg(figure)
        engine.execute(figure)
        figure.set_layout_engine(None)
        figure.set_dpi(dpi)
        # The layout's solver sorts its variables by their addresses, so that the last digits of a
        # place change from run to run; an SVG file's ids are made of them.
        for ax in figure.axes:
            ax.set_position(np.round(ax.get_position(original=True).bounds, _PLACE_DECIMALS))
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if not axis.get_label_text():
                # For the place of a label, empty or not, matplotlib measures all tick labels again.
                axis.set_label_coords(0, 0)


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """The bytes of a figure's file.

    `kind` is svg, pdf or png. The layout should be fixed before (`fix_layout`). Equal figures give
    equal bytes: a file has no date, and its ids are fixed.
    """
    buffer = BytesIO()
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    figure.savefig(buffer, format=kind, dpi=_DPI, metadata=dates.get(kind))
    return buffer.getvalue()
