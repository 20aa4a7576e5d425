"""A figure as the bytes of a file."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def fix_layout(figure: Figure) -> None:
    """Lay the figure out once for all its files: layout takes most of the time of saving."""
    engine = figure.get_layout_engine()
    if engine is not None:
        FigureCanvasAgg(figure)
        engine.execute(figure)
        figure.set_layout_engine("none")


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """The figure as a file's bytes, without dates and with fixed ids: equal figures, equal bytes.

    Args:
        figure: drawn.
        kind: `svg`, `pdf` or `png`.
    """
    dates: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    buffer = BytesIO()
    figure.savefig(buffer, format=kind, metadata=dates.get(kind), dpi=200)
    return buffer.getvalue()
