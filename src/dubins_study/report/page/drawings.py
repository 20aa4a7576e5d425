"""Figures as elements of the page: colours that follow its mode, ids that no other figure has."""

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
_STYLE = re.compile(r' style="[^"]*"')
_FILL = re.compile(r' fill="(#\w{6})"')  # of hatches; only a style can hold a variable
_ID = re.compile(r' id="|href="#|url\(#')  # what stands before an id


def inline(svg: str, name: str, alt: str) -> Markup:
    """An SVG file's text as an element of the page; its ids begin with the figure's name."""

    def of_page(tag: re.Match[str]) -> str:
        text = _ID.sub(lambda before: f"{before.group()}{name}-", tag.group())
        return _STYLE.sub(_following, _FILL.sub(r' style="fill: \1"', text))

    body = _TAG.sub(of_page, _METADATA.sub("", svg[svg.index("<svg") :]))
    label = Markup("<svg role='img' aria-label='{}'").format(alt)
    return label + Markup(body.removeprefix("<svg"))


def _following(match: re.Match[str]) -> str:
    """A style with the page's variables for its colours, and the page's font."""
    text = _COLOUR.sub(lambda colour: f"var({_VARIABLES[colour.group()]})", match.group())
    return text.replace("'DejaVu Sans'", "inherit")
