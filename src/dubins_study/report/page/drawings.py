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
_FILL = re.compile(r' fill="(#\w{6})"')  # of hatches
_LONG_NUMBER = re.compile(r"(-?\d+\.\d\d)\d+")  # a hundredth of a point is enough
_DEFINED = re.compile(r' id="([^"]+)"')
_USED = re.compile(r'(?:href="#|url\(#)([^")]+)')
_NAMED = re.compile(r'(?P<before> id="|href="#|url\(#)(?P<name>[^")]+)')
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
        """An SVG file's text as an element of the page."""
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
        """A tag with a class for its style, and short names of what is used."""
        tag = _FILL.sub(r' style="fill: \1"', _LONG_NUMBER.sub(r"\1", tag))
        tag = _DEFINED.sub(lambda m: m.group() if m.group(1) in names else "", tag)
        tag = _NAMED.sub(lambda m: f"{m['before']}{names.get(m['name'], m['name'])}", tag)
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
