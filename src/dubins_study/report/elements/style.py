"""How figures look: colours, sizes and matplotlib's settings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

import matplotlib as mpl
from matplotlib.figure import Figure

from dubins_study.report.elements.colours import HUES

Style: TypeAlias = dict[str, Any]  # keywords of matplotlib

INK, MUTED, RULE, PAPER = "#1a1c1f", "#6a7079", "#d5d9de", "#ffffff"
BLUE, VERMILION, GREEN = (HUES[name].light for name in ("blue", "vermilion", "green"))
ORANGE, SKY, PURPLE = (HUES[name].light for name in ("orange", "sky", "purple"))
BROWN, OLIVE = (HUES[name].light for name in ("brown", "olive"))

# Colours for maps. The dark page replaces INK and PAPER, but must not replace these, so they differ
# by one digit.
ON_MAP, MAP_PAPER = "#1a1c20", "#fffffe"

# inches: 180 and 88 mm, two columns of a journal and one; on the page its column, and half of it
WIDE, HALF = 180 / 25.4, 88 / 25.4

_SETTINGS: Style = {
    "font.family": ["DejaVu Sans"],
    **dict.fromkeys(("font.size", "axes.labelsize"), 8.5),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8),
    **{"axes.titlesize": 9, "axes.titlelocation": "left", "axes.titleweight": "bold"},
    "axes.titlepad": 8,
    **dict.fromkeys(("axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), MUTED),
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.6),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **{"axes.grid": True, "axes.axisbelow": True, "grid.color": RULE, "grid.linewidth": 0.5},
    **dict.fromkeys(("xtick.major.size", "ytick.major.size"), 2.5),
    **dict.fromkeys(("xtick.minor.size", "ytick.minor.size"), 0),
    **{"legend.handlelength": 2.2, "lines.linewidth": 1.4, "lines.markersize": 4},
    "text.color": INK,
    "text.parse_math": False,  # a "$" in a name from outside must stay a "$"
    "svg.fonttype": "none",  # text stays text
    "pdf.fonttype": 42,  # TrueType: journals refuse matplotlib's default, Type 3
    "svg.hashsalt": "dubins-study",
    **{"hatch.linewidth": 0.5, "figure.facecolor": PAPER, "axes.facecolor": "none"},
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
}


@contextmanager
def drawing() -> Iterator[None]:
    """Use the study's matplotlib settings inside the `with` block, for drawing and for saving."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)  # type: ignore[arg-type]  # a plain dict of settings
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure (inches) that makes room for its labels."""
    return Figure(figsize=(width, height), layout="constrained")
