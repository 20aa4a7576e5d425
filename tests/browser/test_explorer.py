"""The explorer, driven as a reader does: keyboard, fields, examples."""

from __future__ import annotations

import math

import pytest
from browser_tab import agrees, scenario_in

from dubins_study import Scenario
from dubins_study.report.page.explorer import PRESETS
from dubins_study.study.angle import parse_angle
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import region_of, shortest

# Of one leg with a free final heading; the others are tested with routes.
ON_MAP = [preset for preset in PRESETS if ";" not in preset.text]


def test_every_example_shows_what_the_package_computes(explorer):
    page = explorer()
    for preset in ON_MAP:
        page.get_by_role("button", name=preset.name, exact=True).click()
        x, y, heading, target_x, target_y, radius = preset.text.split(",")
        numbers = [float(n) for n in (target_x, target_y, radius)]
        assert scenario_in(page) == Scenario(float(x), float(y), parse_angle(heading), *numbers)
        agrees(page)


def test_the_examples_show_what_their_titles_say():
    """The tie, the disc, and the jump between just outside and just inside."""
    cases = {}
    for preset in ON_MAP:
        x, y, heading, *rest = preset.text.split(",")
        cases[preset.name] = Scenario(float(x), float(y), heading, *map(float, rest))
    best = {name: shortest(case) for name, case in cases.items()}
    outside, inside = best["Just outside"], best["Just inside"]

    assert best["Straight behind"].words == ("LS", "RS")
    assert best["Inside a disc"].word == inside.word == "RL"
    assert outside.word == "LS"
    # the arcs of 0.3 on the circle and from inside, moved by 0.001 R each
    assert inside.total - outside.total == pytest.approx(6.235, abs=0.02)
    regions = [region_of(local(c).w, local(c).mirrored.w) for c in cases.values()]
    assert regions.count("left disc") == 2


@pytest.mark.slow
def test_by_keyboard(explorer):
    """Arrows move a handle, shift makes them ten times as strong, + and - change the radius."""
    page = explorer("0,0,0deg,3,2,1")
    page.locator(".handle.target").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowDown")
    assert (scenario_in(page).target_x, scenario_in(page).target_y) == (3.05, 1.5)
    page.keyboard.press("+")
    assert scenario_in(page).radius == 1.01
    page.keyboard.press("-")
    page.keyboard.press("-")
    assert scenario_in(page).radius < 1
    page.locator(".handle.heading").focus()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Shift+ArrowRight")
    assert scenario_in(page).heading == pytest.approx(math.radians(-9), abs=1e-12)
    agrees(page)
    handle = page.locator(".handle.heading")
    assert handle.get_attribute("role") == "slider"
    assert handle.get_attribute("aria-valuenow") == "-9"
    spoken = handle.get_attribute("aria-valuetext")
    assert spoken.startswith("−9 degrees. Shortest: ")
    assert page.get_by_role("slider").count() == 3


@pytest.mark.slow
def test_fields_and_their_refusals(explorer):
    """A number that no scenario may have is refused in words; the picture stays as it was."""
    page = explorer("0,0,0deg,3,2,1")
    page.get_by_label("target x").fill("-7.5")
    page.get_by_label("heading, deg", exact=True).fill("45")
    page.get_by_label("start y").fill("0.25")
    scenario = scenario_in(page)
    assert (scenario.target_x, scenario.heading, scenario.y) == (-7.5, math.radians(45), 0.25)
    agrees(page)
    page.get_by_label("radius R").fill("0")
    assert page.locator("[data-answer=problem]").text_content() == (
        "radius is 0; expected a number above 0"
    )
    assert scenario_in(page).radius == 1
    page.get_by_label("target x").focus()
    assert page.get_by_label("radius R").input_value() == "1"
    assert page.locator("[data-answer=problem]").text_content() == ""


@pytest.mark.parametrize("radius", ["25", "0.0099", "1e+40"])
def test_arrow_keys_in_the_radius_field_keep_it_above_zero(explorer, radius):
    """A step is a hundredth to a tenth of the radius, down and up; no step is refused."""
    page = explorer(f"0,0,0deg,{radius},{radius},{radius}")
    field = page.get_by_label("radius R")
    field.focus()
    for key, sign in (("ArrowDown", -1), ("ArrowUp", 1)):
        for _ in range(12):
            before = scenario_in(page).radius
            page.keyboard.press(key)
            after = scenario_in(page).radius
            # the difference of two doubles next to each other: 1e-16 of a hundredth
            assert 0.01 < sign * (after - before) / before < 0.1 + 1e-13
            assert float(field.input_value()) == after
            assert page.locator("[data-answer=problem]").text_content() == ""
            assert field.evaluate("input => input.validity.valid")
    agrees(page)


FUZZ = """() => {
  let seed = 11;
  const random = () => { seed = seed * 48271 % 2147483647; return seed / 2147483647; };
  const power = () => (random() < 0.6 ? 100 : 308) * 2 * (random() - 0.5);
  const number = () => (random() < 0.5 ? -1 : 1) * 10 ** power();
  const shown = [], broken = [], refusals = [];
  for (let i = 0; i < 400; i += 1) {
    const radius = Math.abs(number()), size = random() < 0.5 ? radius : number();
    const heading = random() < 0.8 ? 6 * random() : number(), x = random() < 0.5 ? 0 : size;
    const target_x = 3 * (random() - 0.5) * size;
    const target_y = random() < 0.2 ? 0 : (random() - 0.5) * size;
    const scenario = i % 10 ? {x, y: 0, heading, target_x, target_y, radius}
      : {x: 0, y: 0, heading, target_x: 0, target_y: number(), radius: 8e307};
    if (!window.explorer.set(scenario, "fit")) {
      refusals.push(document.querySelector("[data-answer=problem]").textContent);
      continue;
    }
    const best = window.explorer.entries().find((entry) => entry.optimal);
    window.explorer.sweep.draw(window.explorer.state(), best.length);
    shown.push(scenario);
    for (const element of document.querySelectorAll(".explorer-live *")) {
      const own = element.children.length ? "" : element.textContent;
      const texts = [own, ...[...element.attributes].map(({value}) => value)];
      if (texts.some((text) => /NaN|Infinity|undefined/.test(text))) broken.push(element.outerHTML);
    }
  }
  return [shown.length, broken, refusals];
}"""


@pytest.mark.slow
def test_whatever_the_numbers_a_picture_or_a_reason(explorer):
    """400 scenarios of 1e-308 to 1e308: no NaN anywhere, and refusals say what is expected."""
    shown_scenarios, broken, refusals = explorer().evaluate(FUZZ)

    assert broken == []
    assert shown_scenarios > 150
    assert len(refusals) > 10
    assert all("; expected " in text for text in refusals)
