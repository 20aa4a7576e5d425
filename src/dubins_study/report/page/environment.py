"""What the templates of the page are written with: filters, scripts and embedded data."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Sequence
from importlib.resources import files
from itertools import groupby
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from dubins_study.report.elements import style
from dubins_study.report.elements.content import Block, Picture, Section, Table, Widget
from dubins_study.report.page.markup import markdown, to_markdown

_PACKAGE = "dubins_study.report.page"
# `base` is the explorer's own page's too; what is printed has the last word.
STYLES = (
    *("styles/base", "style", "styles/tables", "styles/attempts", "styles/drawer"),
    *("styles/explorer", "styles/print"),
)
# The order in which the scripts run: later ones use what earlier ones hand out.
SCRIPTS = (
    *("dubins", "dubins-certificate", "svg", "page", "tables"),
    *("attempts-data", "attempts-fields", "path-picture", "drawer", "attempts-solvers"),
    *("attempts-choice", "attempts-plot", "attempts-list", "attempts", "worst"),
    *("explorer-scene", "explorer-handles", "explorer-answers", "explorer-sweep"),
    *("explorer-copies", "explorer"),
)


def breakable(text: str) -> Markup:
    """A solver's name as HTML in which a line may break between settings."""
    escaped = str(Markup.escape(text))
    return Markup(escaped.replace("[", "<wbr>[").replace(",", ",<wbr>"))


def choice(text: str) -> Markup:
    """A choice as HTML: the first line stands out."""
    first, _, rest = text.partition("\n")
    return Markup("<strong>{}</strong><br>{}").format(first, rest) if rest else Markup.escape(text)


def linked(text: str, sections: Sequence[Section]) -> Markup:
    """The title of a section, and what may follow a colon, as a link to that section.

    Without a link if the page has the section for each of several experiments, or not at all; the
    text says the latter.
    """
    title = text.partition(":")[0]
    for section in sections:
        if section.title == title:
            return Markup('<a href="#{}">{}</a>').format(section.key, text)
    named = any(section.title.startswith(f"{title}:") for section in sections)
    return Markup.escape(text if named else f"{text} (not on this page)")


def as_json(value: Any) -> Markup:
    """A value as JSON that no text in it can end the script element of."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def packed(content: bytes) -> str:
    """Bytes as gzip in base64; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(content, compresslevel=9, mtime=0)).decode("ascii")


def scripts() -> list[Markup]:
    """The texts of the page's scripts, in the order in which they run."""
    return _texts("scripts", [f"{name}.js" for name in SCRIPTS])


def styles() -> Markup:
    """The page's style, in the order in which rules win; the figures' hues come first."""
    return Markup("\n").join([_hues(), *_texts("", [f"{name}.css" for name in STYLES])])


def _hues() -> Markup:
    """The variables of the figures' hues, light, dark, and light again in print."""
    light, dark = (f":root {{ {style.css_values(mode)} }}" for mode in ("light", "dark"))
    return Markup(
        f"{light}\n@media (prefers-color-scheme: dark) {{ {dark} }}\n@media print {{ {light} }}"
    )


def _texts(folder: str, names: Sequence[str]) -> list[Markup]:
    """The texts of those of these files that the templates' folder holds."""
    place = files(_PACKAGE).joinpath("templates", folder)
    present = [file for name in names if (file := place / name).is_file()]
    return [Markup(file.read_text(encoding="utf-8")) for file in present]


# As many pictures in a row are shown; the rest is folded away behind a line that names them.
_SHOWN_PICTURES = 4
# A table of more lines is folded away if another table of its section comes before it.
_SHOWN_LINES = 40


class Blocks(NamedTuple):
    """Blocks of a section that stand together; `summary` stands for them while they are folded."""

    blocks: tuple[Block, ...]
    summary: str = ""


def grouped(blocks: Sequence[Block]) -> list[Blocks]:
    """The blocks in order; all but the first of many pictures, and long tables, are folded."""
    groups: list[Blocks] = []
    tables = 0
    for is_picture, run in groupby(blocks, lambda block: isinstance(block, Picture)):
        each = tuple(run)
        if is_picture:
            shown = _SHOWN_PICTURES if len(each) > _SHOWN_PICTURES + 1 else len(each)
            groups.append(Blocks(each[:shown]))
            if each[shown:]:
                names = "; ".join(block.alt for block in each[shown:] if isinstance(block, Picture))
                groups.append(Blocks(each[shown:], f"{len(each) - shown} more figures: {names}"))
            continue
        for block in each:
            long = isinstance(block, Table) and len(block.frame) > _SHOWN_LINES and tables > 0
            groups.append(Blocks((block,), _summary(block) if long else ""))
            tables += isinstance(block, Table)
    return groups


def _summary(block: Block) -> str:
    """A long table in a line: its lines and the beginning of its caption."""
    lines = len(block.frame) if isinstance(block, Table) else 0
    caption = " ".join(block.caption.removeprefix(f"All {lines} lines. ").split())
    first = caption.partition(". ")[0].rstrip(".")
    return f"All {lines} lines: {first[:1].lower()}{first[1:]}"


def height_of(section: Section) -> int:
    """About how tall a section is (CSS px): what a browser assumes until it comes into view."""
    heights = [
        150 + 45 * min(len(block.frame), 12) if isinstance(block, Table) else 500
        for group in grouped(section.blocks)
        for block in (() if group.summary else group.blocks)
    ]
    return 200 + sum(heights)


def environment() -> Environment:
    """Autoescape is on for HTML; Markdown escapes through its own filter."""
    made = Environment(
        loader=PackageLoader(_PACKAGE, "templates"),
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"breakable": breakable, "markdown": markdown, "pipe_table": to_markdown}
    made.filters |= {"grouped": grouped, "height_of": height_of}
    made.filters |= {"as_json": as_json, "choice": choice, "linked": linked, "packed": packed}
    made.tests |= {
        "picture": lambda block: isinstance(block, Picture),
        "table": lambda block: isinstance(block, Table),
        "widget": lambda block: isinstance(block, Widget),
    }
    return made
