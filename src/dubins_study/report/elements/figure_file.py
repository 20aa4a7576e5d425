"""A figure as the bytes of a file."""

from __future__ import annotations

from io import BytesIO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

_DPI = 200  # of pictures inside a figure; lines and letters stay lines and letters


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
        figure: a drawn figure whose layout is fixed (`fix_layout`).
        kind: `svg`, `pdf` or `png`.
    """
    buffer = BytesIO()
    if kind not in ("svg", "pdf"):
        figure.savefig(buffer, format=kind, dpi=_DPI)
        return buffer.getvalue()
    # savefig would draw the figure twice, the first time only to compute its layout
    dpi = figure.dpi
    figure.set_dpi(_DPI)
    if kind == "svg":
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None})  # type: ignore[no-untyped-call]
    else:
        FigureCanvasPdf(figure).print_pdf(buffer, metadata={"CreationDate": None})  # type: ignore[no-untyped-call]
    figure.set_dpi(dpi)
    return buffer.getvalue()
