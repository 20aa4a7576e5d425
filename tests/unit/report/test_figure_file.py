"""Files of figures: the drawing in few bytes, every text as it is."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
import zlib
from io import BytesIO

import numpy as np
import pytest
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib import TTFont
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont

from dubins_study.report.elements.figure_file import figure_bytes
from dubins_study.report.elements.style import BLUE, drawing

PART = re.compile(r"([MLHV])\s*([^MLHVz]*)")
SVG = "{http://www.w3.org/2000/svg}"


def vertices(path):
    """The points of a path of straight parts, as the SVG specification reads M, L, H and V."""
    points, here = [], [0.0, 0.0]
    for kind, numbers in PART.findall(path):
        given_numbers = [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", numbers)]
        if kind == "H":
            here = [given_numbers[0], here[1]]
        elif kind == "V":
            here = [here[0], given_numbers[0]]
        else:
            here = given_numbers
        points.append(here)
    return np.array(points)


@settings(max_examples=20)
@given(st.lists(st.floats(0.05, 0.95), min_size=3, max_size=12, unique=True))
def test_a_path_keeps_its_points(heights):
    """To a hundredth of a point: a 72nd of a hundredth of an inch."""
    x = np.linspace(0.1, 0.9, len(heights))
    with drawing():
        figure = Figure(figsize=(2, 1))
        ax = figure.add_axes((0, 0, 1, 1), xlim=(0, 1), ylim=(0, 1), frame_on=False)
        ax.plot(x, heights, drawstyle="steps-post", gid="curve", clip_on=False)
        root = ET.fromstring(figure_bytes(figure, "svg"))  # made here
    (curve,) = root.iterfind(f".//{SVG}g[@id='curve']/{SVG}path")
    across = np.repeat(x, 2)[1:] * 144
    down = 72 - np.repeat(heights, 2)[:-1] * 72
    drawn, meant = vertices(curve.attrib["d"]), np.column_stack([across, down])

    # Matplotlib joins neighbours on one line; each coordinate is cut to a hundredth of a point.
    for point in drawn:
        assert np.abs(meant - point).max(axis=1).min() < 0.02
    assert drawn[0] == pytest.approx(meant[0], abs=0.02)
    assert drawn[-1] == pytest.approx(meant[-1], abs=0.02)


@pytest.mark.parametrize(
    "text", ["1.23456789", 'fill="#0072b2" d="M 0 0L 1.23456 2"', "font-family: 'DejaVu Sans'; x"]
)
def test_texts_stay_as_they_are(text):
    """Whatever they look like: only tags are shortened."""
    with drawing():
        figure = Figure(figsize=(2, 1))
        figure.text(0.1, 0.5, text)
        root = ET.fromstring(figure_bytes(figure, "svg"))  # made here

    assert text in [element.text for element in root.iter(f"{SVG}text")]


def test_colours_of_hatches_are_styles():
    """The page's modes replace colours in styles alone."""
    with drawing():
        figure = Figure(figsize=(2, 1))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.bar([0], [1], color=BLUE, hatch="//")
        svg = figure_bytes(figure, "svg").decode("utf-8")

    assert "<pattern" in svg
    assert f'style="fill: {BLUE}"' in svg
    assert not re.search(r'fill="#', svg)


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
