"""The plane of the explorer and its page: true, in view, in print, without scripts."""

from __future__ import annotations

import re

import pytest
from browser_tab import DESK, PHONE
from explorer_page import centre, scenario_in

from dubins_study import Scenario
from dubins_study.report.explorer.fragment import PRESETS
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import shortest


@pytest.mark.slow
def test_the_map_is_true(explorer):
    """The region under 400 points of the picture is named after the package's shortest word."""
    page = explorer("0.3,-0.2,25deg,1.4,1.1,0.9")
    places = page.evaluate(
        """() => {
          const svg = document.querySelector(".explorer-plane"), box = svg.getBoundingClientRect();
          const found = [];
          for (let i = 0; i < 20; i += 1) for (let j = 0; j < 20; j += 1) {
            const x = box.left + (i + 0.5) * box.width / 20;
            const y = box.top + (j + 0.5) * box.height / 20;
            const region = document.elementsFromPoint(x, y).find(e => e.dataset?.word);
            svg.dispatchEvent(new MouseEvent("click", {clientX: x, clientY: y}));
            const {target_x, target_y} = window.explorer.state();
            window.explorer.set({}, "keep");
            found.push([region.dataset.word, target_x, target_y]);
          }
          return found;
        }"""
    )
    scenario = scenario_in(page)
    compared = set()
    for word, x, y in places:
        case = Scenario(scenario.x, scenario.y, scenario.heading, x, y, scenario.radius)
        best = shortest(case)
        assert best is not None
        edge = min(abs(local(case).w), abs(local(case).mirrored.w), abs(local(case).Y))
        if edge > 0.03:  # a pixel of the picture, or two
            assert best.word == word, case
            compared.add(word)

    assert compared == {"LS", "RS", "LR", "RL"}


@pytest.mark.slow
@pytest.mark.parametrize("viewport", [PHONE, DESK], ids=["phone", "desk"])
def test_nothing_is_wider_than_the_screen(explorer, viewport):
    """No sideways scrolling, all handles in view."""
    page = explorer(viewport=viewport)
    for preset in PRESETS:
        page.get_by_role("button", name=preset.name, exact=True).click()
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), preset
        for name in ("target", "heading", "radius"):
            x, y = centre(page, name)
            box = page.locator(".explorer-plane").bounding_box()
            assert box["x"] < x < box["x"] + box["width"], preset
            assert box["y"] < y < box["y"] + box["height"], preset


def test_without_scripts_there_are_drawings(explorer):
    """Two pictures with a text; no dead buttons."""
    page = explorer(java_script_enabled=False)

    assert page.locator(".explorer-still img").count() == 2
    assert page.locator(".explorer-still").is_visible()
    assert page.get_by_text("needs JavaScript").is_visible()
    assert not page.locator(".explorer-live").is_visible()


@pytest.mark.slow
def test_in_print_there_are_no_buttons(explorer):
    """The picture and the table stay."""
    page = explorer()
    page.emulate_media(media="print")

    assert page.locator(".explorer-plane").is_visible()
    assert page.locator("table.explorer-words").is_visible()
    assert not page.get_by_role("button", name="Problem 1").is_visible()


def test_no_id_stands_twice_and_every_pattern_exists(explorer):
    page = explorer()
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map(e => e.id)")
    fills = page.evaluate(
        "[...document.querySelectorAll('[fill]')].map(e => e.getAttribute('fill'))"
    )

    assert len(ids) == len(set(ids))
    named = {match[1] for fill in fills if (match := re.match(r"url\(#(.*)\)", fill))}
    assert len(named) == 3
    assert named <= set(ids)


def test_forced_colours_leave_every_line_s_sample(explorer):
    """The table's samples keep colour and pattern, as the lines in the picture do."""
    page = explorer(forced_colors="active")
    assert page.evaluate("matchMedia('(forced-colors: active)').matches")
    samples = page.locator(".explorer .sample").evaluate_all(
        "all => all.map(e => { const s = getComputedStyle(e);"
        " return [s.backgroundImage, s.borderTopStyle, s.borderTopColor]; })"
    )

    plain = (
        explorer()
        .locator(".explorer .sample")
        .evaluate_all(
            "all => all.map(e => { const s = getComputedStyle(e);"
            " return [s.backgroundImage, s.borderTopStyle, s.borderTopColor]; })"
        )
    )
    assert samples == plain
    assert len({str(sample) for sample in samples}) == 4


def test_at_the_start_there_is_nothing_to_drive(explorer):
    """Said once, without a circle that an arc would reach."""
    page = explorer("3,-2,0.5rad,3,-2,1")
    page.wait_for_function("document.querySelector('[data-answer=summary]').textContent")

    assert page.locator(".explorer-place").text_content() == (
        "Shortest: nothing to drive, length 0. "
        "The target is the start, where both turning circles meet."
    )
