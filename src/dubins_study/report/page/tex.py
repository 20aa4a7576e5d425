r"""The report as TeX for pdfTeX: escaped text, tables that fit on a page, and `report.tex`."""

from __future__ import annotations

import math
import re
import textwrap
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from jinja2 import Environment

from dubins_study.report.data.results import Folder
from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.paper.printed import CITATION

_SYMBOLS = {symbol: f"\\{symbol}" for symbol in "&%$#_{}"} | {
    "\\": r"\textbackslash{}",
    **{"~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "|": r"\textbar{}"},
    **{"<": r"\textless{}", ">": r"\textgreater{}", "`": r"\textasciigrave{}"},
    **{"≤": r"$\leq$", "≥": r"$\geq$", "≠": r"$\neq$", "≈": r"$\approx$", "±": r"$\pm$"},
    **{"−": r"$-$", "×": r"$\times$", "·": r"$\cdot$", "√": r"$\surd$", "∞": r"$\infty$"},
    **{"→": r"$\rightarrow$", "←": r"$\leftarrow$", "∈": r"$\in$", "∂": r"$\partial$"},
    **{"–": "--", "—": "---", "…": r"\ldots{}", "°": r"$^{\circ}$", "½": r"$\frac12$"},
    **{"“": "``", "”": "''", "‘": "`", "’": "'", "„": ",,", "«": "<<", "»": ">>"},
    **{"µ": r"$\mu$", "ς": r"$\varsigma$", "ο": "o", "§": r"\S{}", "©": r"\copyright{}"},
    **{"✓": r"\ding{51}", "✗": r"\ding{55}", "\u202f": r"\,", "\u2009": r"\,", "\u00a0": "~"},
    **{"ß": r"\ss{}", "æ": r"\ae{}", "Æ": r"\AE{}", "œ": r"\oe{}", "Œ": r"\OE{}"},
    **{"ø": r"\o{}", "Ø": r"\O{}", "ł": r"\l{}", "Ł": r"\L{}", "ı": r"\i{}"},
    **{letter: rf"$^{{{'0123456789-+np'[i]}}}$" for i, letter in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ⁿᵖ")},
    **{letter: rf"$_{{{i}}}$" for i, letter in enumerate("₀₁₂₃₄₅₆₇₈₉")},
}
# Combining mark -> TeX's accent.
_ACCENTS = {
    **{"\u0300": "`", "\u0301": "'", "\u0302": "^", "\u0303": "~", "\u0304": "=", "\u0306": "u"},
    **{"\u0307": ".", "\u0308": '"', "\u030a": "r", "\u030b": "H", "\u030c": "v", "\u0327": "c"},
}
_DOTLESS = {"i": r"\i", "j": r"\j"}
# Greek capitals that look like Latin letters have no command.
_LATIN_SHAPES = str.maketrans("ΑΒΕΖΗΙΚΜΝΟΡΤΧ", "ABEZHIKMNOPTX")
_JOINED = "-,'"  # two of these in a row are one character to TeX

_LONG_RUN = re.compile(r"(\S{13,})")  # a word that may not fit into a column
# Breaks come after punctuation; where there is none, every twelve letters of a very long part.
_PART = re.compile(r"[^\[,=_/.;:|\\-]*[\[,=_/.;:|\\-]{1,12}|[^\[,=_/.;:|\\-]+")
_LONG_PART, _PIECE = 24, re.compile(r".{1,12}")


def tex(text: str) -> str:
    r"""Escape text so that pdfTeX prints it unchanged, on one line.

    What pdfTeX's fonts have no letter for, such as Chinese or a mark that turns the direction of
    writing, is printed as its code point: `[U+202E]`. Long words may break after punctuation and
    after every twelve letters. Needs no package, except pifont for ✓ and ✗.
    """
    one_line = " ".join(text.split("\n")).replace("\r", " ").replace("\t", " ")
    parts = _LONG_RUN.split(one_line)
    parts[1::2] = [r"\allowbreak{}".join(map(_escaped, _pieces(run))) for run in parts[1::2]]
    parts[0::2] = map(_escaped, parts[0::2])
    return "".join(parts)


def _pieces(run: str) -> list[str]:
    """A long word in pieces between which a line may break."""
    parts = _PART.findall(run)
    split = [_PIECE.findall(part) if len(part) > _LONG_PART else [part] for part in parts]
    return [piece for pieces in split for piece in pieces]


def _escaped(text: str) -> str:
    letters = [_letter(character) for character in text]
    for place in range(1, len(text)):
        if text[place] in _JOINED and text[place] == text[place - 1]:
            letters[place - 1] += "{}"
    return "".join(letters)


@lru_cache(maxsize=4096)
def _letter(character: str) -> str:
    if character in _SYMBOLS:
        return _SYMBOLS[character]
    latin = character.translate(_LATIN_SHAPES)
    if latin.isascii() and latin.isprintable():
        return latin
    return _accented(character) or _greek(character) or f"[U+{ord(character):04X}]"


def _accented(character: str) -> str:
    """An accented Latin letter; empty for anything else."""
    parts = unicodedata.normalize("NFD", character)
    base, accent = parts[0], _ACCENTS.get(parts[1:])
    if accent is None or not (base.isascii() and base.isalpha()):
        return ""
    return rf"\{accent}{{{_DOTLESS.get(base, base)}}}"


def _greek(character: str) -> str:
    """A Greek letter without accents; empty for anything else."""
    if not ("Α" <= character <= "Ω" or "α" <= character <= "ω"):
        return ""
    letter = unicodedata.name(character, "").rpartition(" ")[2].replace("LAMDA", "LAMBDA")
    return rf"$\{letter.lower() if character >= 'α' else letter.capitalize()}$" if letter else ""


# mm: what is printed of a page of A4. The width is that of two columns of a journal.
PAGE_WIDTH, PAGE_HEIGHT = 180.0, 250.0
GAP = 2.2  # mm between two columns
ROW_GAP = 0.7  # mm between two rows of several lines
RIGHT = ("number", "cell")  # kinds of columns that are aligned right
_PT = 0.3515  # mm
# Commands of TeX -> width of a digit and height of a line (pt), the largest letters first. Of the
# fonts lmr8, lmr7 and lmr5; typewriter letters are hardly wider, other letters are narrower.
_SIZES = {"footnotesize": (4.25, 9.5), "scriptsize": (3.99, 8.0), "tiny": (3.41, 6.0)}
_BROAD, _MORE = frozenset("%∞−×✗✓→mwMW@"), 0.6  # letters broader than a digit, and by how much
_CAPTION = 25.0  # mm that the caption may take
_NARROWEST = 14  # letters of a column whose lines may break


@dataclass(frozen=True)
class Layout:
    """How a table fits on a page."""

    size: str  # of the letters, a command of TeX without its backslash
    # of the columns whose lines break (mm); None for a column as wide as its text
    widths: tuple[float | None, ...]
    turned: bool  # whether the page is turned by a quarter
    long: bool  # whether the table may go over several pages


def printed_texts(table: Table) -> list[list[str]]:
    """Every cell as text, row by row, solvers by their short names."""
    short = [column.kind == "solver" for column in table.columns]
    return [
        [table.labels.get(t, t) if s else t for t, s in zip(row, short, strict=True)]
        for row in table.texts()
    ]


def layout_of(table: Table) -> Layout:
    """The layout with the largest letters that fits, on an upright page if there is one."""
    texts = printed_texts(table)
    digits = [_width(column, texts, i) for i, column in enumerate(table.columns)]
    breaks = [column.kind not in RIGHT for column in table.columns]
    for turned in (False, True):
        across, down = (PAGE_HEIGHT, PAGE_WIDTH) if turned else (PAGE_WIDTH, PAGE_HEIGHT)
        for size, (digit, line) in _SIZES.items():
            widths = _fitted(digits, breaks, across, digit * _PT)
            if widths is not None:
                height = _lines(texts, widths, digit * _PT) * line * _PT + ROW_GAP * len(texts)
                return Layout(size, widths, turned, height > down - _CAPTION)
    # So many columns that the lines of all of them break.
    width = PAGE_HEIGHT / len(digits) - GAP
    return Layout("tiny", (width,) * len(digits), turned=True, long=True)


def _digits(text: str) -> float:
    """Width of a cell's widest line over that of a digit."""
    return max(
        len(line) + _MORE * sum(letter in _BROAD for letter in line) for line in text.split("\n")
    )


def heading_lines(column: Column, texts: Sequence[Sequence[str]], place: int) -> list[str]:
    """A heading in lines that are hardly wider than the column below it."""
    widest = max((_digits(row[place]) for row in texts), default=1)
    return textwrap.wrap(column.title, max(int(widest), 6), break_long_words=False) or [""]


def _width(column: Column, texts: Sequence[Sequence[str]], place: int) -> float:
    """Width of a column, its heading included, over that of a digit."""
    heading = "\n".join(heading_lines(column, texts, place))
    return max(_digits(heading), *(_digits(row[place]) for row in texts), 1)


def _fitted(
    digits: Sequence[float], breaks: Sequence[bool], across: float, digit: float
) -> tuple[float | None, ...] | None:
    """Widths (mm) of the columns; None if the table is wider than `across` (mm) all the same.

    `digits` are the columns' widths over that of one digit, which is `digit` (mm).
    """
    room = across - GAP * (len(digits) - 1)
    full = [digit * number for number in digits]
    if sum(full) <= room:
        return (None,) * len(digits)
    least = [
        digit * min(number, _NARROWEST + number / 12) if may_break else digit * number
        for number, may_break in zip(digits, breaks, strict=True)
    ]
    spare = room - sum(least)
    if spare < 0:
        return None
    share = spare / (sum(full) - sum(least))
    return tuple(
        low + share * (high - low) if low < high else None
        for low, high in zip(least, full, strict=True)
    )


def _lines(texts: list[list[str]], widths: tuple[float | None, ...], digit: float) -> int:
    """Lines of text in the body of a table."""
    return sum(
        max(
            text.count("\n") + 1 if width is None else math.ceil(len(text) * digit / width)
            for text, width in zip(row, widths, strict=True)
        )
        for row in texts
    )


# Package -> what shows that a table needs it.
_PACKAGES = {
    "amssymb": r"\checkmark",
    "booktabs": r"\toprule",
    "longtable": "{longtable}",
    "pifont": r"\ding",
}


def to_tex(table: Table) -> str:
    """A `tabular` with booktabs rules; a `longtable` if it is longer than a page."""
    layout, texts = layout_of(table), printed_texts(table)
    columns = list(zip(table.columns, layout.widths, strict=True))
    heading = [
        _cell(heading_lines(column, texts, place), column, width, "b")
        for place, (column, width) in enumerate(columns)
    ]
    head = [r"\toprule", _row(heading), r"\midrule"]
    several = any("\n" in text for row in texts for text in row) or any(layout.widths)
    rows = [
        _row(
            [
                _cell(text.split("\n"), column, width, "t")
                for text, (column, width) in zip(row, columns, strict=True)
            ],
            rf"\addlinespace[{ROW_GAP:g}mm]" if several else "",
        )
        for row in texts
    ]
    if layout.long:
        kind, inside = "longtable", [*head, r"\endhead", r"\bottomrule", r"\endfoot", *rows]
    else:
        kind, inside = "tabular", [*head, *rows, r"\bottomrule"]
    place = "[l]" if layout.long else ""
    spec = "".join(_column(column, width) for column, width in columns)
    body = "\n".join(
        [
            rf"\begingroup\{layout.size}\setlength{{\tabcolsep}}{{{GAP / 2:g}mm}}%",
            rf"\begin{{{kind}}}{place}{{@{{}}{spec}@{{}}}}",
            *inside,
            rf"\end{{{kind}}}%",
            r"\endgroup",
        ]
    )
    packages = ", ".join(name for name, sign in _PACKAGES.items() if sign in body)
    return f"% Needs the packages {packages}.\n{body}\n"


def _column(column: Column, width: float | None) -> str:
    if width is not None:
        return f"p{{{width:.1f}mm}}"
    return "r" if column.kind in RIGHT else "l"


def _row(cells: list[str], gap: str = "") -> str:
    """A line of the table; `gap` is a command for the distance to the next one."""
    row = " & ".join(cells) + r" \tabularnewline" + gap
    return "{}" + row if row.startswith("[") else row  # or TeX would read it as a distance


def _cell(lines: list[str], column: Column, width: float | None, place: str) -> str:
    """One cell; `place`, b or t, is the line of several that stands beside the other cells."""
    escaped = [tex(line) for line in lines]
    if column.kind in ("code", "command") and place == "t":
        escaped = [rf"\texttt{{{line}}}" for line in escaped]
    if width is not None:
        return rf"\raggedright {' '.join(escaped)}"
    if len(escaped) == 1:
        return escaped[0]
    stack = r" \\ ".join(escaped)
    return rf"\begin{{tabular}}[{place}]{{@{{}}{_column(column, None)}@{{}}}}{stack}\end{{tabular}}"


_MM = 25.4  # in an inch
_FIGURE_CAPTION = 30.0  # mm


def document(
    environment: Environment, sections: Sequence[Section], runs: Sequence[Folder], heading: str
) -> str:
    """The text of `report.tex`, which pdflatex compiles in the report's folder."""
    # Braces mean something to TeX, so the template's commands stand in `<< >>` and `<% %>`.
    latex = environment.overlay(
        block_start_string="<%",
        block_end_string="%>",
        variable_start_string="<<",
        variable_end_string=">>",
        comment_start_string="<#",
        comment_end_string="#>",
        autoescape=False,
    )
    latex.filters |= {"tex": tex, "layout": layout_of, "shrunk": _shrunk}
    page = {"width": PAGE_WIDTH, "height": PAGE_HEIGHT}
    template = latex.get_template("report.tex.j2")
    printed = [section for section in sections if section.printed]
    known = {"runs": runs, "citation": CITATION, "heading": heading}
    return template.render(sections=printed, **known, **page)


def _shrunk(picture: Picture) -> str:
    """Options that make a figure fit if it is larger than the page; else it keeps its size."""
    width, height = (float(size) * _MM for size in picture.figure.get_size_inches())
    room = PAGE_HEIGHT - _FIGURE_CAPTION
    if height <= room and width <= PAGE_WIDTH + 0.01:  # mm; widths are rounded to points
        return ""
    return f"[width={PAGE_WIDTH:g}mm,height={room:g}mm,keepaspectratio]"
