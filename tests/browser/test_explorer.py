"""The explorer, driven as by a reader.

Used are the keyboard, fields, examples, and the texts that it offers to copy.
"""

import json
import math
import shlex
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO

import pytest

from dubins_study import Scenario, solve
from dubins_study.report.page.explorer import PRESETS
from dubins_study.study.angle import parse_angle
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import region_of, shortest
from tests.browser_tab import PHONE, agrees, number, scenario_in, shown, shown_best

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
    """The examples show what their titles say.

    They are the tie, the disc, and the jump between just outside and just inside.
    """
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
    """Keys move a handle and change the radius.

    Arrows move a handle, shift makes them ten times as strong, + and - change the radius.
    """
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
    """Impossible numbers are refused in words.

    The picture stays as it was.
    """
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
    """Arrow keys keep the radius above zero.

    A step is a hundredth to a tenth of the radius, down and up; no step is refused.
    """
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
    """Any numbers give a picture or a reason.

    400 scenarios of 1e-308 to 1e308 show no NaN anywhere, and refusals say what is expected.
    """
    shown_scenarios, broken, refusals = explorer().evaluate(FUZZ)

    assert broken == []
    assert shown_scenarios > 150
    assert len(refusals) > 10
    assert all("; expected " in text for text in refusals)


@pytest.mark.parametrize(
    "text",
    [
        "1,2,30deg,-4,5.5,0.75",
        "0,0,2.0943951023931953,-80,20,25",  # rad, as rows of results have it
        "0,0,0deg,1000000,20,1",
        "3,-2,0.5rad,3,-2,1",  # at the start
        "0,0,0deg,1,1,1",  # on the circle
    ],
)
def test_the_address_restores_a_scenario(explorer, text):
    """The address restores a scenario.

    The link, the command and the Python that are offered lead to the same scenario.
    """
    page = explorer(text)
    x, y, heading, *rest = text.split(",")
    scenario = Scenario(float(x), float(y), parse_angle(heading), *map(float, rest))
    assert scenario_in(page) == scenario
    agrees(page)
    page.wait_for_function("document.querySelector('[data-copy=link]').textContent")
    link = page.locator("[data-copy=link]").text_content()
    assert link.endswith(f"#explore={text}")


def test_a_broken_address_is_left_alone(explorer):
    """A broken address changes nothing.

    Hostile or incomplete text is no scenario and no markup; the page says what is wrong.
    """
    reasons = {
        "1,2": "1,2 has not six parts",
        "%3Cimg src=x onerror=alert(1)%3E,0,0,1,1,1": "x is NaN; expected a finite number",
        "%E0%A4%A": "URI malformed",
        "0,0,0,1,1,0": "radius is 0; expected a number above 0",
    }
    for text, reason in reasons.items():
        page = explorer(text)
        assert page.evaluate("window.explorer.state().written") == "120deg"  # the first example
        assert page.locator("img[src=x]").count() == 0
        problem = page.locator("[data-answer=problem]")
        assert reason in problem.text_content()
        page.set_viewport_size({"width": 700, "height": 600})  # drawn anew, still said
        page.wait_for_function("document.querySelector('.explorer-plane').clientWidth < 700")
        assert reason in problem.text_content()
        page.get_by_role("button", name="Problem 1", exact=True).click()
        assert problem.text_content() == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["0.5,0,-110deg,-0.3,0.2,1.5", "0,1e-7,7.5,-3,1,1", "0,0,30°,1,1,2"]
)
def test_the_offered_command_and_python_run(explorer, text):
    """The offered command and Python run as pasted.

    They print the length that the page shows.
    """
    page = explorer(text)
    command = shlex.split(page.locator("[data-copy=command]").text_content())
    length = number(shown(page)[shown_best(page)]["length"])
    assert command[0] == "dubins-study"
    call = [sys.executable, "-m", "dubins_study", *command[1:], "--json"]
    answer = json.loads(subprocess.run(call, check=True, capture_output=True).stdout)
    assert answer["length"] == pytest.approx(length, rel=6e-6)

    names: dict = {}
    printed = StringIO()
    with redirect_stdout(printed):
        exec(page.locator("[data-copy=python]").text_content(), names)  # our own text
    assert names["answer"].length == pytest.approx(length, rel=6e-6)
    assert printed.getvalue().endswith("optimal\n")
    assert solve(scenario_in(page)).word in printed.getvalue()


def test_copy_puts_the_command_on_the_clipboard(explorer):
    page = explorer(permissions=["clipboard-read", "clipboard-write"])
    page.locator(".explorer-more > summary").click()
    page.get_by_role("button", name="Copy: Command line").click()
    page.wait_for_function(
        "document.querySelector('[data-copies=command]').textContent == 'copied'"
    )

    expected = "dubins-study solve 10 5 --from 0 0 120deg --radius 1"
    assert page.evaluate("navigator.clipboard.readText()") == expected


def test_in_the_report_it_answers_beside_the_other_scripts(new_tab, report_page):
    """The explorer works within the report.

    It is restored from the address and driven by keyboard, and keeps the address up to date.
    """
    page = new_tab(viewport=PHONE)
    page.goto(f"{report_page.as_uri()}#explore=0,0,60deg,-2,-5,1")
    assert scenario_in(page) == Scenario(0, 0, "60deg", -2, -5, 1)
    top = page.locator("#explore").bounding_box()["y"]
    assert -5 <= top < PHONE["height"] / 2
    agrees(page)
    page.locator(".handle.target").focus()
    page.keyboard.press("ArrowUp")
    page.wait_for_function("location.hash === '#explore=0,0,60deg,-2,-4.95,1'")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.evaluate("location.hash = '#explore=0,0,0deg,0,1,2'")  # as a link of another section does
    page.wait_for_function("window.explorer.state().radius === 2")
    agrees(page)
