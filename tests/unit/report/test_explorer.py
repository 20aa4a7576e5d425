"""The explorer's HTML: complete without scripts, self-contained, in no printed document."""

from __future__ import annotations

import base64
import html
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from dubins_study.report.elements.content import Section
from dubins_study.report.page.environment import TEMPLATES
from dubins_study.report.page.explorer import explorer_section, write_explorer
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path as Driven
from dubins_study.study.scenario import Pose, Scenario
from tests.fuzz.page import odd_parts

ROOT = Path(__file__).parents[3]
NUMBER = re.compile(r"-?\d+\.?\d*")


@pytest.fixture
def explorer():
    """The explorer as the report shows it."""
    section = explorer_section(None)  # type: ignore[arg-type]  # the same for all results
    (widget,) = section.blocks
    return widget.body


def test_without_scripts_there_are_two_drawings_with_a_text(explorer):
    """Embedded as images, so that their styles and ids stay their own."""
    images = [
        dict(re.findall(r'([\w-]+)="([^"]*)"', tag)) for tag in re.findall("<img [^>]*>", explorer)
    ]

    assert len(images) == 2
    for image in images:
        kind, _, content = image["src"].partition(",")
        assert kind == "data:image/svg+xml;base64"
        root = ElementTree.fromstring(base64.b64decode(content))
        assert html.unescape(image["alt"]) == root.get("aria-label")
        assert (image["width"], image["height"]) == (root.get("width"), root.get("height"))


def test_the_page_of_its_own_asks_for_nothing(tmp_path, explorer):
    text = write_explorer(tmp_path / "explorer.html").read_text(encoding="utf-8")

    assert explorer in text
    assert odd_parts(text) == []
    assert "@import" not in text
    assert len(text) < 140_000  # of which the map 110 000, routes the rest


PROBLEM = Scenario(0, 0, "70deg", 3.7, -0.15, 1)
BESIDE = [Scenario(0, 0, 0, r * math.sin(0.9), 1 - r * math.cos(0.9)) for r in (0.95, 1.05)]
BEHIND = Driven(Pose(0, 0, 0), [1.0, 0.0], [4.0, 3.4]).end


@pytest.mark.parametrize(
    ("drawing", "scenario", "branch", "text"),
    [
        (TEMPLATES / "problem.svg", PROBLEM, "RS", "right, then straight: {:.2f} R, shortest<"),
        (TEMPLATES / "problem.svg", PROBLEM, "LS", "left, then straight: {:.2f} R<"),
        (ROOT / "docs/img/jump.svg", BESIDE[0], "RL", "just inside: RL, {:.2f} R<"),
        (ROOT / "docs/img/jump.svg", BESIDE[1], "LS", "just outside: LS, {:.2f} R<"),
        (ROOT / "docs/img/cut.svg", Scenario(0, 0, 0, *BEHIND[:2]), "LS", "LS: {:.2f} R<"),
        (ROOT / "docs/img/cut.svg", Scenario(0, 0, 0, *BEHIND[:2]), "RS", "RS: {:.2f} R<"),
    ],
)
def test_a_length_in_a_drawing_is_the_closed_form_s(drawing, scenario, branch, text):
    optimum = shortest(scenario, branch)

    assert optimum is not None
    assert text.format(optimum.total) in drawing.read_text(encoding="utf-8")


def test_the_map_shows_an_example_of_each_word():
    """The targets' dots lie where their paths end and in the region of their word."""
    root = ElementTree.parse(TEMPLATES / "words.svg").getroot()
    thin = [e for e in root if e.tag.endswith("path") and "thin" in e.get("class", "")]
    dots = [e for e in root if e.get("class") == "target"]

    assert len(thin) == len(dots) == 4
    words = set()
    for path, dot in zip(thin, dots, strict=True):
        x, y = (float(dot.get(name, "nan")) for name in ("cx", "cy"))
        end = list(map(float, NUMBER.findall(path.get("d", ""))))[-2:]
        assert end == pytest.approx([x, y], abs=0.02)
        best = shortest(Scenario(target_x=x / 100 - 3.6, target_y=2.45 - y / 100))
        assert best is not None
        words.add(best.word)
        assert path.get("class", "").startswith("left" if best.word[0] == "L" else "right")
    assert words == {"LS", "RS", "RL", "LR"}


def test_a_printed_document_has_no_explorer():
    """Nor any other section of which scripts alone show something."""
    assert not explorer_section(None).printed  # type: ignore[arg-type]
    assert Section("k", "T", "Text.", ()).printed
