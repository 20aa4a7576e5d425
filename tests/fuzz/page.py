"""What a page, a text and a table may hold, told from the templates and not from what they say."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

from tests.fuzz.hostile import MARK

_ELEMENTS = """
    html head meta title style body header h1 h2 h3 p dl dt dd code strong nav ol li a main
    section div figure figcaption table thead tbody tr th td footer details summary pre wbr
    svg g defs path use text tspan rect clippath lineargradient image metadata pattern
    span bdi br button label input form output small em cite img script
""".split()  # noqa: SIM905
_ATTRIBUTES = """
    lang charset name content class id href scope aria-label role style d transform x y width
    height viewbox version xmlns xmlns:xlink xlink:href clip-path fill stroke opacity
    preserveaspectratio stroke-width type patternunits
    open title tabindex src alt step min autocomplete aria-live aria-hidden
""".split()  # noqa: SIM905
_HANDLERS = [("onsubmit", "return false")]
# to a place on the page, a picture in it, or a file of the report
_LINK = re.compile(
    r"#|data:image/(png|svg\+xml);base64,|(tables|figures)/[a-z0-9-]+\.[a-z]+$|report\.[a-z]+$"
)
_DATA = ("application/json", "text/plain")  # of scripts that are not run

# of TeX
_TEX = """
    begin end toprule midrule bottomrule texttt textbackslash textasciitilde textasciicircum
    textless textgreater textbar leq geq infty times cdot mu pi zeta surd checkmark frac
    textasciigrave begingroup endgroup setlength tabcolsep tiny footnotesize raggedright
    tabularnewline addlinespace endhead endfoot allowbreak ldots ding pm
""".split()  # noqa: SIM905


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.odd: list[str] = []
        self._runs = False  # inside a script that a browser runs, not one that holds data

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._runs = tag == "script" and dict(attrs).get("type") not in _DATA
        if tag not in _ELEMENTS:
            self.odd.append(f"<{tag}>")
        for name, said in attrs:
            link = name.endswith(("href", "src")) and not _LINK.match(said or "")
            known = name in _ATTRIBUTES or name.startswith("data-") or (name, said) in _HANDLERS
            if not known or link:
                self.odd.append(f"<{tag} {name}={said!r}>")

    def handle_endtag(self, tag: str) -> None:
        self._runs = False

    def handle_data(self, data: str) -> None:
        if self._runs and MARK in data:
            self.odd.append(f"<script>{data}")

    def handle_comment(self, data: str) -> None:
        if MARK in data:
            self.odd.append(f"<!--{data}-->")

    def handle_decl(self, decl: str) -> None:
        if MARK in decl:
            self.odd.append(f"<!{decl}>")

    def handle_pi(self, data: str) -> None:
        if MARK in data:
            self.odd.append(f"<?{data}>")


def check_report(folder: Path) -> None:
    """A report that nobody has to fear, whatever its rows and manifests say."""
    html = (folder / "index.html").read_text(encoding="utf-8")
    page = _Page()
    page.feed(html)
    page.close()
    assert not page.odd, page.odd[:5]
    assert not _controls(html)
    _check_markdown((folder / "report.md").read_text(encoding="utf-8"))
    for file in (folder / "tables").glob("*.md"):
        _check_markdown(file.read_text(encoding="utf-8"))
    for file in (folder / "tables").glob("*.tex"):
        _check_tex(file.read_text(encoding="utf-8"))
    for file in (folder / "figures").glob("*.svg"):
        ElementTree.parse(file)
        assert "<script" not in file.read_text(encoding="utf-8")


def _check_markdown(text: str) -> None:
    assert not _controls(text)
    assert "<" not in re.sub(r"<(?=\d)", "", text)  # our own table says `<0.1 %`, escaped
    for given in text.splitlines():
        line = re.sub(r"^!\[(.*)\]\(figures/[a-z0-9-]+\.svg\)$", r"\1", given)
        if MARK in line:
            assert not re.search(r"(?<!\\)[\[\]`$]", line.replace("\\\\", "")), line


def _check_tex(text: str) -> None:
    assert not _controls(text)
    assert set(re.findall(r"\\([a-zA-Z]+)", text)) <= set(_TEX)


def _controls(text: str) -> set[str]:
    """Control characters, and those that turn the direction of writing."""
    turning = set("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
    return {c for c in text if (ord(c) < 32 and c not in "\n\t") or 127 <= ord(c) < 160} | (
        turning & set(text)
    )


def check_json(text: str) -> None:
    """JSON as its standard has it: no NaN, no infinity."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    json.loads(text, parse_constant=refuse)
