"""What the page's templates use.

These are filters, scripts, style sheets and embedded data.
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
    """A text as HTML, its first line bold.

    The first line is code if `kind` contains `spec`: a spec to be typed. A text of one line is only
    escaped.
    """
    first, *others = text.split("\n")
    if not others:
        return Markup.escape(text)
    if "spec" in kind:
        first = Markup("<code>{}</code>").format(breakable(first))
    return Markup("<strong>{}</strong><br>{}").format(first, Markup("<br>").join(others))


def linked(text: str, sections: Sequence[Section], page: str) -> Markup:
    """A section's title as a link from `page`.

    `text` is the title, which may be followed by a colon and more text. It stays without a link if
    the page has the section once per experiment. If the report has no such section, "(not on this
    page)" is added.
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
    """Bytes as a text: compressed by gzip, in base64.

    Equal bytes give equal texts.
    """
    return base64.b64encode(gzip.compress(content, compresslevel=9, mtime=0)).decode("ascii")


def scripts(names: Sequence[str] = SCRIPTS) -> list[Markup]:
    """The texts of scripts, in running order."""
    return [*map(_script, names)]


def _script(name: str) -> Markup:
    """The text of a script.

    The script `tolerances` is made from the check's constants, which certificates of the page's
    paths use too.
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
    """The page's style sheets as one text.

    The figures' hues come first. Then follow the files of `STYLES`; later rules win.
    """
    light = f":root {{ {style.css_values('light')} }}"
    dark = f":root {{ {style.css_values('dark')} }}"
    hues = f"{light}\n@media (prefers-color-scheme: dark) {{ {dark} }}\n@media print {{ {light} }}"
    return Markup("\n").join([Markup(hues), stylesheets(STYLES)])


def stylesheets(names: Sequence[str]) -> Markup:
    """Style sheets of the templates as one text.

    A later rule wins.
    """
    return Markup("\n").join(_text(f"{name}.css") for name in names)


def _text(name: str) -> Markup:
    """The text of a template's file, not escaped."""
    return Markup((TEMPLATES / name).read_text(encoding="utf-8"))


class Folded(NamedTuple):
    """A section's blocks: those shown, and those folded.

    A line of the page names the folded blocks (`more`) and opens them.
    """

    shown: tuple[Block, ...]
    more: tuple[Block, ...]


def folded(section: Section) -> Folded:
    """Split a section's blocks into shown and folded.

    Shown are the first block, or two half figures side by side, and all widgets. The page about the
    paper is read from top to bottom, so nothing is folded there.
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
    """What a block shows, in a few words.

    It is the first sentence or clause of a figure's alternative text, or of a table's caption.
    """
    text = block.caption
    if isinstance(block, Picture):
        text = block.alt
    return " ".join(re.split(r"[.:;] ", text)[0].split()).rstrip(".")


def environment() -> Environment:
    """A jinja environment for one page.

    All values are escaped. The filter `glossed` remembers which words it has linked, so each page
    needs a new environment.
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
