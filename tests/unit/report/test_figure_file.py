"""Files of figures: letters of a PDF file are those of the font."""

from __future__ import annotations

import re
import zlib
from io import BytesIO

from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib import TTFont
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont

from dubins_study.report.elements.style import drawing, figure_bytes


def outline(font, glyph):
    """The lines of a glyph, with the parts that it is made of drawn in their places."""
    pen = DecomposingRecordingPen(font.getGlyphSet())
    font.getGlyphSet()[glyph].draw(pen)
    return pen.value


def test_letters_of_a_pdf_file_are_those_of_the_font():
    """Whole outlines and widths of common letters, of one made of parts, and of a rare one."""
    letters = "aR≤é⠿"
    with drawing():
        figure = Figure(figsize=(2, 1))
        figure.text(0.1, 0.5, letters)
        content = figure_bytes(figure, "pdf")
        whole = TTFont(findfont(FontProperties(family="DejaVu Sans")))
    streams = [
        zlib.decompress(stream)
        for stream in re.findall(
            rb"/FlateDecode.*?stream\r?\n(.*?)\r?\nendstream", content, re.DOTALL
        )
    ]
    files = [stream for stream in streams if stream.startswith(b"\0\1\0\0")]  # TrueType's mark
    drawn = [
        (outline(font, glyph), font["hmtx"][glyph][0])
        for font in map(TTFont, map(BytesIO, files))
        for glyph in font.getGlyphOrder()
    ]

    for letter in letters:
        glyph = whole.getBestCmap()[ord(letter)]
        assert (outline(whole, glyph), whole["hmtx"][glyph][0]) in drawn, letter
