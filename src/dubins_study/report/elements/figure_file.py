"""A figure as the bytes of a file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from io import BytesIO

from fontTools import subset
from fontTools.ttLib import TTFont
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontPath

_DPI = 200  # of pictures inside a figure; lines and letters stay lines and letters


def fix_layout(figure: Figure) -> None:
    """Compute the layout once for all files of a figure: it takes most of the time of saving."""
    engine = figure.get_layout_engine()
    if engine is not None:
        # At a low resolution the letters' widths are those of whole pixels.
        dpi = figure.dpi
        figure.set_dpi(_DPI)
        FigureCanvasAgg(figure)
        engine.execute(figure)
        figure.set_layout_engine("none")
        figure.set_dpi(dpi)
    for axis in (axis for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)):
        if not axis.get_label_text():
            # For the place of a label, empty or not, matplotlib measures all tick labels again.
            axis.set_label_coords(0, 0)


def figure_bytes(figure: Figure, kind: str) -> bytes:
    """A figure whose layout is fixed (`fix_layout`) as the bytes of a file: svg, pdf or png.

    Equal figures give equal bytes: no dates, fixed ids.
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
        with _fonts_without_layout():
            FigureCanvasPdf(figure).print_pdf(buffer, metadata={"CreationDate": None})  # type: ignore[no-untyped-call]
    figure.set_dpi(dpi)
    return buffer.getvalue()


# The tables of a TrueType font that a PDF file reads (ISO 32000-1, sec. 9.9).
_TABLES = {"cvt ", "fpgm", "glyf", "head", "hhea", "hmtx", "loca", "maxp", "prep"}


@contextmanager
def _fonts_without_layout() -> Iterator[None]:
    """Inside the `with` block matplotlib cuts the fonts of PDF files from smaller ones.

    Most of the time of cutting a font goes to tables that set text, which matplotlib has done.
    """
    load = subset.load_font
    subset.load_font = lambda file, options: load(BytesIO(_drawn_part(file)), options)
    try:
        yield
    finally:
        subset.load_font = load


@cache
def _drawn_part(file: FontPath) -> bytes:
    """The font with all its letters, and with those tables alone that draw them."""
    buffer = BytesIO()
    with TTFont(file, fontNumber=file.face_index, recalcTimestamp=False) as font:
        for table in set(font.keys()) - _TABLES - {"GlyphOrder"}:
            del font[table]
        font.save(buffer, reorderTables=False)
    return buffer.getvalue()
