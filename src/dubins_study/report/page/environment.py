"""Tools of the page's templates.

Filters, scripts and embedded data.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
from collections.abc import Sequence
from importlib.resources import files
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from dubins_study.report.elements import style
from dubins_study.report.elements.content import Block, Picture, Place, Section, Table, Widget
from dubins_study.report.page.glossary import Glossed
from dubins_study.study.check.two_arcs import ABNORMAL, NO_LENGTH, NO_TURN
from dubins_study.study.judging.certify import CUT_TOLERANCE, PMP_ROUNDING, PMP_TOLERANCE
from dubins_study.study.tolerances import ARRIVES, DRIVEN

FRONT_PAGE = "index.html"
PAPER_PAGE = "paper.html"
TEMPLATES = files("dubins_study.report.page") / "templates"
# The style for printing comes last, so that its rules win.
STYLES = (
    "styles/base",
    "style",
    "styles/tables",
    "styles/attempts",
    "styles/drawer",
    "styles/explorer",
    "styles/print",
)
# The order in which the scripts run: later ones use the names of earlier ones.
SCRIPTS = (
    "tolerances",
    "dubins",
    "dubins-certificate",
    "dubins-pose",
    "dubins-route",
    "dubins-tour",
    "svg",
    "page",
    "tables",
    "attempts-data",
    "attempts-fields",
    "path-picture",
    "drawer",
    "attempts-solvers",
    "attempts-choice",
    "attempts-plot",
    "attempts-list",
    "attempts",
    "worst",
    "explorer-answers",
    "explorer-legs",
    "explorer-route",
    "explorer-scene",
    "explorer-handles",
    "explorer-sweep",
    "explorer-copies",
    "explorer",
)
EXPLORER_STYLES = ("styles/base", "styles/explorer")
EXPLORER_SCRIPTS = tuple(
    name for name in SCRIPTS if name.startswith(("tolerances", "dubins", "svg", "explorer"))
)


def breakable(text: str) -> Markup:
    """A solver's name as HTML with break points.

    A line may break between settings, and before a value.
    """
    escaped = str(Markup.escape(text))
    return Markup(escaped.replace("[", "<wbr>[").replace(",", ",<wbr>").replace("=", "=<wbr>"))


def choice(text: str, kind: str) -> Markup:
    """A choice as HTML.

    The first line stands out, as a spec to be typed if its kind says so.
    """
    first, *others = text.split("\n")
    if not others:
        return Markup.escape(text)
    if "spec" in kind:
        first = Markup("<code>{}</code>").format(breakable(first))
    return Markup("<strong>{}</strong><br>{}").format(first, Markup("<br>").join(others))


def linked(text: str, sections: Sequence[Section], page: str) -> Markup:
    """Link the title of a section from `page`.

    The title may be followed by a colon and more text. There is no link if the page has the section
    once per experiment, or not at all; the text says so in the latter case.
    """
    title = text.partition(":")[0]
    for section in sections:
        if section.title in (text, title):
            file = FRONT_PAGE
            if section.place is Place.PAPER:
                file = PAPER_PAGE
            if file == page:
                file = ""
            return Markup('<a href="{}#{}">{}</a>').format(file, section.key, text)
    if any(section.title.startswith(f"{title}:") for section in sections):
        return Markup.escape(text)
    return Markup.escape(f"{text} (not on this page)")


def packed(content: bytes) -> str:
    """Bytes as gzip in base64.

    The same bytes give the same text.
    """
    return base64.b64encode(gzip.compress(content, compresslevel=9, mtime=0)).decode("ascii")


def scripts(names: Sequence[str] = SCRIPTS) -> list[Markup]:
    """The texts of scripts, in running order."""
    return [*map(_script, names)]


def _script(name: str) -> Markup:
    """The text of a script.

    `tolerances` has those of the check; the certificates of the page's paths use them too.
    """
    if name != "tolerances":
        return _text(f"scripts/{name}.js")
    values = {
        "ARRIVES": ARRIVES,
        "DRIVEN": DRIVEN,
        "NO_TURN": NO_TURN,
        "NO_LENGTH": NO_LENGTH,
        "PMP_TOLERANCE": PMP_TOLERANCE,
        "PMP_ROUNDING": PMP_ROUNDING,
        "CUT_TOLERANCE": CUT_TOLERANCE,
        "ABNORMAL": ABNORMAL,
    }
    return Markup(f'"use strict";\nwindow.tolerances = {json.dumps(values)};\n')


def styles() -> Markup:
    """The page's style, in the order of rules.

    Later rules win; the figures' hues come first.
    """
    light = f":root {{ {style.css_values('light')} }}"
    dark = f":root {{ {style.css_values('dark')} }}"
    hues = f"{light}\n@media (prefers-color-scheme: dark) {{ {dark} }}\n@media print {{ {light} }}"
    return Markup("\n").join([Markup(hues), stylesheets(STYLES)])


def stylesheets(names: Sequence[str]) -> Markup:
    """The texts of style sheets, in order.

    Rules of later ones win.
    """
    return Markup("\n").join(_text(f"{name}.css") for name in names)


def _text(name: str) -> Markup:
    return Markup((TEMPLATES / name).read_text(encoding="utf-8"))


class Folded(NamedTuple):
    """A section's blocks, shown and folded.

    The folded ones are behind a line that names them.
    """

    shown: tuple[Block, ...]
    more: tuple[Block, ...]


def folded(section: Section) -> Folded:
    """Split a section's blocks into shown and folded.

    Shown are the first block, or two half figures side by side, and all widgets. On the page about
    the paper, a document to be read from top to bottom, nothing is folded.
    """
    blocks = section.blocks
    if section.place is Place.PAPER:
        return Folded(blocks, ())
    halves = [isinstance(block, Picture) and block.half for block in blocks[:2]]
    first = 1
    if halves == [True, True]:
        first = 2
    shown = [*blocks[:first], *(b for b in blocks[first:] if isinstance(b, Widget))]
    return Folded(tuple(shown), tuple(b for b in blocks if b not in shown))


def summary(block: Table | Picture) -> str:
    """The content of a block in a few words.

    A figure's alternative text, or a caption's beginning.
    """
    text = block.caption
    if isinstance(block, Picture):
        text = block.alt
    return " ".join(re.split(r"[.:;] ", text)[0].split()).rstrip(".")


def environment() -> Environment:
    """The environment of the templates.

    All values are escaped.
    """
    templates = Environment(
        loader=PackageLoader("dubins_study.report.page", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters |= {
        "breakable": breakable,
        "choice": choice,
        "folded": folded,
        "glossed": Glossed(),
        "linked": linked,
        "packed": packed,
        "summary": summary,
    }
    templates.tests |= {
        "picture": lambda block: isinstance(block, Picture),
        "table": lambda block: isinstance(block, Table),
        "widget": lambda block: isinstance(block, Widget),
    }
    return templates
