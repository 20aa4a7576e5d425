"""The explorer's HTML: complete without scripts, self-contained, in no printed document."""

from __future__ import annotations

import base64
import math
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

from dubins_study.report.elements.content import Section
from dubins_study.report.explorer.fragment import FIELDS, PRESETS, fragment
from dubins_study.report.explorer.section import explorer_section
from dubins_study.report.explorer.standalone import SCRIPTS as STANDALONE_SCRIPTS
from dubins_study.report.explorer.standalone import scripts, standalone, write_standalone
from dubins_study.report.page.environment import SCRIPTS
from dubins_study.report.paper.printed import PROBLEMS
from dubins_study.study.scenario import Scenario


class Elements(HTMLParser):
    """Every element with its attributes, and the names of those that are still open."""

    def __init__(self) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.depth: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in ("img", "input", "meta", "br", "wbr"):
            self.depth.append(tag)

    def handle_endtag(self, tag):
        assert self.depth.pop() == tag


def parsed(text: str) -> Elements:
    page = Elements()
    page.feed(text)
    assert page.depth == []
    return page


def test_the_examples_are_scenarios_and_the_paper_s_are_the_paper_s():
    """Written as the page's address has them."""
    scenarios = {}
    for preset in PRESETS:
        x, y, heading, *rest = preset.text.split(",")
        scenarios[preset.name] = Scenario(float(x), float(y), heading, *map(float, rest))

    for number in (1, 2, 3, 4):
        printed, shown = PROBLEMS[f"problem {number}"], scenarios[f"Problem {number}"]
        assert (shown.target_x, shown.target_y, shown.radius) == (*printed.target, printed.radius)
        # a third of pi in degrees and back: the last ulp
        assert shown.heading == pytest.approx(printed.heading * math.pi, rel=4e-16)


def test_the_fragment_holds_every_hook_of_its_scripts():
    """What the scripts ask for by selector, they find; every control has a name."""
    page = parsed(fragment())
    classes = {name for _, a in page.elements for name in (a.get("class") or "").split()}
    hooks = {key for _, a in page.elements for key in a if key.startswith("data-")}

    text = "\n".join(scripts())
    asked = set(re.findall(r'querySelector(?:All)?\("\.([\w-]+)"\)', text))
    assert {"explorer-stage", "explorer-sweep"} == asked & classes == asked
    wanted = set(re.findall(r'querySelector(?:All)?\("\w*\[(data-\w+)', text))
    assert len(wanted) >= 6
    assert wanted <= hooks
    inputs = [a["name"] for tag, a in page.elements if tag == "input"]
    assert inputs == [name for name, _ in FIELDS]


def test_without_scripts_there_are_two_drawings_with_a_text():
    """Embedded as images, so that their styles and ids stay their own."""
    images = [a for tag, a in parsed(fragment()).elements if tag == "img"]

    assert len(images) == 2
    for image in images:
        kind, _, content = (image["src"] or "").partition(",")
        assert kind == "data:image/svg+xml;base64"
        root = ElementTree.fromstring(base64.b64decode(content))
        assert image["alt"] == root.get("aria-label")
        assert (image["width"], image["height"]) == (root.get("width"), root.get("height"))


def test_the_page_of_its_own_asks_for_nothing(tmp_path):
    text = write_standalone(tmp_path / "explorer.html").read_text(encoding="utf-8")

    assert text == standalone()
    for _, attributes in parsed(text).elements:
        for name in ("src", "href"):
            assert (attributes.get(name) or "data:").startswith(("data:", "#"))
    assert "@import" not in text
    assert len(text) < 120_000


def test_the_report_runs_the_same_scripts_in_the_same_order():
    names = [name for name in SCRIPTS if name.startswith(("dubins", "svg", "explorer"))]

    assert names == list(STANDALONE_SCRIPTS)
    assert len(scripts()) == len(names) == 9


def test_a_printed_document_has_no_explorer():
    """Nor any other section of which scripts alone show something."""
    section = explorer_section(None)  # type: ignore[arg-type]  # the same for all results

    assert not section.printed
    assert Section("k", "T", "Text.", ()).printed
