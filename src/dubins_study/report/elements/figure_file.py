"""A figure as the bytes of a file."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def fix_layout(figure: Figure) -> None:
    """Compute the layout once for all files of a figure: it takes most of the time of saving."""
    engine = figure.get_layout_engine()
    if engine is not None:
        FigureCanvasAgg(figure)
        engine.execute(figure)
        figure.set_layout_engine("none")


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """The figure as the bytes of a file. Equal figures give equal bytes: no dates, fixed ids.

    Args:
        figure: a drawn figure.
        kind: `svg`, `pdf` or `png`.
    """
    dates: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    buffer = BytesIO()
    figure.savefig(buffer, format=kind, metadata=dates.get(kind), dpi=200)
    return buffer.getvalue()
