"""The drawings of README and documentation: as committed, and true to the closed form."""

from __future__ import annotations

import math
import re
import runpy
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from dubins_study.report.explorer.canvas import Canvas
from dubins_study.report.explorer.drawings import problem_svg, words_svg
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path as Driven
from dubins_study.study.scenario import Pose, Scenario

ROOT = Path(__file__).parents[3]
NUMBER = re.compile(r"-?\d+\.?\d*")


def test_the_committed_drawings_are_what_the_script_draws(tmp_path, monkeypatch):
    """`python docs/draw.py` changes nothing; to a hundredth of a pixel on any machine."""
    script = ROOT / "docs" / "draw.py"
    monkeypatch.setattr(sys, "argv", [str(script), str(tmp_path)])
    runpy.run_path(str(script), run_name="__main__")

    for name in ("problem.svg", "words.svg"):
        drawn, committed = ((folder / name).read_text() for folder in (tmp_path, ROOT / "docs/img"))
        assert NUMBER.sub("#", drawn) == NUMBER.sub("#", committed), name
        numbers = [list(map(float, NUMBER.findall(text))) for text in (drawn, committed)]
        assert numbers[0] == pytest.approx(numbers[1], abs=0.011), name  # one step of rounding


@pytest.mark.parametrize("draw", [problem_svg, words_svg])
def test_a_drawing_stands_alone(draw):
    """Well-formed, named for those who cannot see it, on its own paper, asking for nothing."""
    text = draw()
    root = ElementTree.fromstring(text)

    assert root.get("role") == "img"
    assert len(root.get("aria-label", "")) > 80
    assert root[2].tag.endswith("rect")
    assert "href" not in text
    assert set(re.findall(r"url\((.)", text)) <= {"#"}


def test_the_lengths_beside_the_paths_are_the_closed_form_s():
    text = problem_svg()
    scenario = Scenario(0, 0, "70deg", 3.7, -0.15, 1)
    for branch, turn in (("LS", "left"), ("RS", "right")):
        optimum = shortest(scenario, branch)
        assert optimum is not None
        assert f"{turn}, then straight: {optimum.total:.2f} R" in text
    best = shortest(scenario)
    assert best is not None
    assert best.word == "RS"
    assert "R, shortest" in text[text.index("right, then") :][:60]


def test_the_map_shows_an_example_of_each_word():
    """The targets' dots lie where their paths end and in the region of their word."""
    root = ElementTree.fromstring(words_svg())
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


def test_a_path_is_drawn_of_arcs_that_end_where_it_ends():
    """A turn by 350 degrees is two arcs of half that; the straight is a line."""
    canvas = Canvas((-2, -2), (4, 4), 10, "test")
    path = Driven(Pose(0, 0, 0), [1.0, 0.0], [math.radians(350), 1.0])
    canvas.path(path, "p")
    text = canvas.parts[-1]

    assert text.count("A10 10 0 0 0 ") == 2
    assert text.count("L") == 2
    end = list(map(float, NUMBER.findall(text)))[-2:]
    assert end == pytest.approx([20 + 10 * path.end.x, 20 - 10 * path.end.y], abs=0.006)
