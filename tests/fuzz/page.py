"""Allowed contents of a page and a table.

They are told from the templates and not from what those say.
"""

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

from tests.fuzz.hostile import MARK
from tests.fuzz.watched import raw_controls

_ELEMENTS = """
    html head meta title style body header h1 h2 h3 p dl dt dd code strong em cite bdi small nav ol
    li a main section div span pre figure figcaption img table thead tbody tr th td
    details summary wbr br form label input output button script
    svg g defs path use text tspan rect clippath lineargradient image metadata pattern
""".split()  # noqa: SIM905
_ATTRIBUTES = """
    lang charset name content class id href src alt title scope aria-label aria-hidden aria-live
    role style tabindex open autocomplete onsubmit step min max
    data-answer data-branch data-cell data-copies data-copy data-explorer data-fit data-label
    data-add data-final data-order placeholder aria-pressed data-scenario data-title data-value
    d transform x y width height viewbox version xmlns xmlns:xlink xlink:href clip-path fill stroke
    opacity preserveaspectratio stroke-width type patternunits
""".split()  # noqa: SIM905
# what a template says there; anything else would run or load something
_VALUES = {
    "href": r"#.*|(index|paper)\.html(#.*)?|(tables|figures)/[a-z0-9-]+\.(csv|tex|svg|pdf)",
    "xlink:href": r"#.*|data:image/png;base64,[A-Za-z0-9+/=\s]+",
    "src": r"data:image/(png|svg\+xml);base64,[A-Za-z0-9+/=]+",
    "onsubmit": "return false",
    "clip-path": r"url\(#[\w-]+\)",
}
# attributes that a browser shows as text, or a script reads as text
_TEXTS = ("title", "alt", "aria-label", "content", "data-title", "data-value", "data-copy", "id")

# of TeX: commands that lay out a table or print a character, and do nothing else
_TEX = """
    begin end toprule midrule bottomrule endfirsthead endhead endfoot endlastfoot multicolumn
    textbackslash textasciitilde textasciicircum space
""".split()  # noqa: SIM905


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.odd: list[str] = []
        self._in_script = ""  # the type of the script that is read; "" outside of scripts

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in _ELEMENTS:
            self.odd.append(f"<{tag}>")
        for name, text in attrs:
            value = text or ""
            strange = name in _VALUES and not re.fullmatch(_VALUES[name], value)
            marked = MARK in value and name not in _TEXTS and name not in _VALUES
            if name not in _ATTRIBUTES or strange or marked:
                self.odd.append(f"<{tag} {name}={text!r}>")
        self._in_script = (dict(attrs).get("type") or "program") if tag == "script" else ""

    def handle_endtag(self, tag: str) -> None:
        self._in_script = ""

    def handle_data(self, data: str) -> None:
        if self._in_script == "program" and MARK in data:
            self.odd.append(f"<script>{data[:80]}")
        if self._in_script == "application/json":
            check_json(data)

    def handle_comment(self, data: str) -> None:
        if MARK in data:
            self.odd.append(f"<!--{data}-->")

    def handle_decl(self, decl: str) -> None:
        if MARK in decl:
            self.odd.append(f"<!{decl}>")

    def handle_pi(self, data: str) -> None:
        if MARK in data:
            self.odd.append(f"<?{data}>")


def odd_parts(html: str) -> list[str]:
    """Parts of a page that no template writes.

    They are elements, attributes and programs.
    """
    page = _Page()
    page.feed(html)
    page.close()
    return page.odd


def check_report(folder: Path) -> None:
    """Check that a report is harmless.

    Its rows and manifests may say anything.
    """
    html = (folder / "index.html").read_text(encoding="utf-8")
    assert not (odd := odd_parts(html)), odd[:5]
    assert not _controls(html)
    for file in (folder / "tables").glob("*.tex"):
        _check_tex(file.read_text(encoding="utf-8"))
    for file in (folder / "figures").glob("*.svg"):
        ElementTree.parse(file)
        assert "<script" not in file.read_text(encoding="utf-8")


def _check_tex(text: str) -> None:
    assert not _controls(text)
    assert set(re.findall(r"\\([a-zA-Z]+)", text)) <= set(_TEX)


def _controls(text: str) -> set[str]:
    """Control characters, and those that turn writing."""
    turning = set("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
    return raw_controls(text) | (turning & set(text))


def check_json(text: str) -> None:
    """Check JSON by its standard: no NaN, no infinity."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    json.loads(text, parse_constant=refuse)
