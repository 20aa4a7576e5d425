"""Figures as elements of the page: small, with anchors and styles that no other figure has."""

from __future__ import annotations

import re

from markupsafe import Markup

from dubins_study.report.elements import style

# CSS variables for the figures' colours, so that figures follow the page's light or dark mode.
_VARIABLES = {
    style.INK: "--ink",
    style.MUTED: "--muted",
    style.RULE: "--rule",
    style.PAPER: "--paper",
    **style.VARIABLES,
}
_COLOUR = re.compile("|".join(map(re.escape, _VARIABLES)))
_METADATA = re.compile(r"<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)
_TAG = re.compile(r"<[^>]+>")
_BETWEEN = re.compile(r">\s+<")
_STYLE = re.compile(r' style="([^"]*)"')
_DEFINED = re.compile(r' id="([^"]+)"')
_USED = re.compile(r'(?:href="#|url\(#)([^")]+)')
_NAMED = re.compile(r'(?P<before> id="|href="#|url\(#)(?P<name>[^")]+)')
_PLACED = re.compile(r' (d|points|x|y|width|height|transform)="([^"]*)"')
_NO_TURN = re.compile(r"rotate\(-?0 [^)]*\)\s*")
_NUMBER = re.compile(r"-?\d+\.\d+")
_BESIDE_LETTER = re.compile(r"\s*([MLHVCSQTAZz])\s*")
# matplotlib writes a group for every artist; with neither name nor look it changes nothing.
_EMPTY = re.compile(r"<g></g>|<g/>|<defs></defs>")


class Drawings:
    """Makes SVG files into elements of one page.

    All figures share the classes of their styles, written by `css`; each has anchors of its own.
    """

    def __init__(self) -> None:
        self._classes: dict[str, str] = {}
        self._figures = 0

    def inline(self, svg: str, alt: str) -> Markup:
        """An SVG file's text as an element of the page; lengths rounded to 0.01 of a point."""
        self._figures += 1
        body = _METADATA.sub("", svg[svg.index("<svg") :])
        names = {name: f"f{self._figures}-{n}" for n, name in enumerate(_used(body), 1)}
        body = _TAG.sub(lambda tag: self._smaller(tag.group(), names), body)
        body = _BETWEEN.sub("><", body)
        while (shorter := _EMPTY.sub("", body)) != body:
            body = shorter
        label = Markup("<svg role='img' aria-label='{}'").format(alt)
        return label + Markup(body.removeprefix("<svg"))

    def css(self) -> Markup:
        """The rules of the classes of all figures made so far."""
        rules = [f"svg .{name}{{{text}}}" for text, name in self._classes.items()]
        return Markup("\n").join(Markup(rule) for rule in rules)

    def _smaller(self, tag: str, names: dict[str, str]) -> str:
        """A tag with a class for its style, short names of what is used, and few digits."""
        tag = _DEFINED.sub(lambda m: m.group() if m.group(1) in names else "", tag)
        tag = _NAMED.sub(lambda m: f"{m['before']}{names.get(m['name'], m['name'])}", tag)
        tag = _PLACED.sub(_rounded, tag)
        return _STYLE.sub(self._classed, tag)

    def _classed(self, match: re.Match[str]) -> str:
        text = _COLOUR.sub(lambda colour: f"var({_VARIABLES[colour.group()]})", match[1])
        text = text.replace("'DejaVu Sans'", "inherit").replace(": ", ":").replace("; ", ";")
        if "url(" in text:  # it names an anchor of its figure
            return f' style="{text}"'
        name = self._classes.setdefault(text, f"s{len(self._classes) + 1}")
        return f' class="{name}"'


def _used(body: str) -> list[str]:
    """The names that something in the figure refers to, each once."""
    return list(dict.fromkeys(_USED.findall(body)))


def _rounded(match: re.Match[str]) -> str:
    name, text = match.groups()
    text = _NO_TURN.sub("", text)
    text = _NUMBER.sub(lambda number: f"{float(number.group()):.2f}".rstrip("0").rstrip("."), text)
    if name == "d":
        text = _BESIDE_LETTER.sub(r"\1", text)
    return f' {name}="{text.strip()}"' if text else ""
