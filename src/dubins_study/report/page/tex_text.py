"""Text from outside as TeX prints it: escaped, with places to break a line, nothing left out."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

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
_GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
    *("lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi"),
    "omega",
)
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
    name = unicodedata.name(character, "").replace("LAMDA", "LAMBDA")
    script, _, letter = name.partition(" LETTER ")
    if letter.lower() not in _GREEK or script not in ("GREEK SMALL", "GREEK CAPITAL"):
        return ""
    return rf"$\{letter.lower() if script == 'GREEK SMALL' else letter.capitalize()}$"
