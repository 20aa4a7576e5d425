"""The explorer, driven as a reader does: pointer, touch, keyboard, fields, examples."""

from __future__ import annotations

import math

import pytest
from browser_tab import PHONE
from explorer_page import agrees, centre, drag, scenario_in, shown

from dubins_study import Scenario
from dubins_study.report.explorer.fragment import PRESETS
from dubins_study.study.angle import parse_angle
from dubins_study.study.closed_form.shortest import region_of, shortest
from dubins_study.study.vehicle_frame import local


def test_every_example_shows_what_the_package_computes(explorer):
    page = explorer()
    for preset in PRESETS:
        page.get_by_role("button", name=preset.name, exact=True).click()
        x, y, heading, target_x, target_y, radius = preset.text.split(",")
        numbers = [float(n) for n in (target_x, target_y, radius)]
        assert scenario_in(page) == Scenario(float(x), float(y), parse_angle(heading), *numbers)
        agrees(page)


def test_the_examples_show_what_their_titles_say():
    """The tie, the disc, and the jump between just outside and just inside."""
    cases = {}
    for preset in PRESETS:
        x, y, heading, *rest = preset.text.split(",")
        cases[preset.name] = Scenario(float(x), float(y), heading, *map(float, rest))
    tie, disc = shortest(cases["Straight behind"]), shortest(cases["Inside a disc"])
    outside, inside = shortest(cases["Just outside"]), shortest(cases["Just inside"])
    assert tie is not None
    assert disc is not None
    assert outside is not None
    assert inside is not None

    assert tie.words == ("LS", "RS")
    assert disc.word == inside.word == "RL"
    assert outside.word == "LS"
    # the arcs of 0.3 on the circle and from inside, moved by 0.001 R each
    assert inside.total - outside.total == pytest.approx(6.235, abs=0.02)
    regions = [region_of(local(c).w, local(c).mirrored.w) for c in cases.values()]
    assert regions.count("left disc") == 2


def test_dragging_the_target_moves_it_and_everything_follows(explorer):
    """By the mouse: the handle stays under the pointer, the numbers are the package's."""
    page = explorer("0,0,0deg,2,1.5,1")
    before, (x, y) = scenario_in(page), centre(page, "target")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 40, y + 70, steps=4)
    assert centre(page, "target") == pytest.approx((x - 40, y + 70), abs=1)  # a pixel of rounding
    page.mouse.up()

    after = scenario_in(page)
    assert after.target_x < before.target_x
    assert after.target_y < before.target_y
    agrees(page)


@pytest.mark.slow
def test_dragging_across_the_circle_changes_the_word(explorer):
    """From outside into the left disc: LS ends to exist and RL is shortest."""
    page = explorer("0,0,0deg,1.3,1,1")
    assert shown(page)["LS"]["optimal"] == "true"
    x, _ = centre(page, "target")
    inside = page.locator("circle[data-word=RL]").bounding_box()
    drag(page, "target", inside["x"] + inside["width"] / 2 - x, 0)

    assert shown(page)["RL"]["optimal"] == "true"
    assert (
        shown(page)["LS"]["certificate"] == "no path: the target is inside the left turning circle"
    )
    agrees(page)


@pytest.mark.slow
def test_dragging_heading_and_radius(explorer):
    """The heading points where the pointer is; the radius grows away from the start."""
    page = explorer("0,0,0deg,4,3,1")
    drag(page, "heading", -62, -62)  # from 62 pixels ahead to 62 above
    assert scenario_in(page).heading == pytest.approx(math.pi / 2, abs=0.03)
    agrees(page)
    page = explorer("0,0,0deg,4,3,1")
    drag(page, "radius", 0, 30)
    assert scenario_in(page).radius > 1.1
    agrees(page)


def test_a_finger_drags_the_target(explorer):
    """Touch events reach the handle, and only handles keep the page from scrolling."""
    page = explorer("0,0,0deg,2,1.5,1", viewport=PHONE, has_touch=True, is_mobile=True)
    x, y = centre(page, "target")
    session = page.context.new_cdp_session(page)
    for kind, dx in (("touchStart", 0), ("touchMove", -15), ("touchMove", -30), ("touchEnd", None)):
        points = [] if dx is None else [{"x": x + dx, "y": y}]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    assert scenario_in(page).target_x < 2
    assert (
        page.evaluate("getComputedStyle(document.querySelector('.handle')).touchAction") == "none"
    )
    assert page.evaluate("getComputedStyle(document.querySelector('svg')).touchAction") == "auto"
    agrees(page)


def test_a_second_finger_does_not_move_what_the_first_drags(explorer):
    """It lies on another handle and slides, as for a zoom of the page."""
    page = explorer("0,0,0deg,2,1.5,1", viewport=PHONE, has_touch=True, is_mobile=True)
    x, y = centre(page, "target")
    other_x, other_y = centre(page, "radius")
    first, second = {"x": x, "y": y, "id": 1}, {"x": other_x, "y": other_y, "id": 2}
    session = page.context.new_cdp_session(page)
    moves = (
        ("touchStart", [first]),
        ("touchStart", [first, second]),
        ("touchMove", [first, second | {"x": other_x + 40}]),
    )
    for kind, points in moves:
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    assert scenario_in(page) == Scenario(0, 0, 0, 2, 1.5, 1)
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    for kind, points in (
        ("touchStart", [first]),
        ("touchMove", [first | {"x": x - 30}]),
        ("touchEnd", []),
    ):  # the next drag is one of its own
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    assert scenario_in(page).target_x < 2
    assert scenario_in(page).radius == 1
    agrees(page)


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
    page.get_by_label("heading, deg").fill("45")
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


@pytest.mark.slow
def test_a_drag_is_answered_within_a_frame(explorer):
    """Works 1000 random scenarios off; the times are printed (`pytest -s`), not asserted."""
    page = explorer()
    times = page.evaluate(
        """() => {
          let seed = 1;
          const random = () => { seed = seed * 48271 % 2147483647; return seed / 2147483647; };
          const times = [];
          for (let i = 0; i < 1000; i += 1) {
            const before = performance.now();
            window.explorer.set({target_x: 12 * random() - 6, target_y: 12 * random() - 6}, "keep");
            const best = window.explorer.entries().find((entry) => entry.optimal);
            window.explorer.sweep.draw(window.explorer.state(), best.length);
            document.body.getBoundingClientRect();  // the layout belongs to the answer
            times.push(performance.now() - before);
          }
          return times;
        }"""
    )
    times.sort()
    print(f"update: median {times[500]:.2f} ms, 99 % {times[990]:.2f} ms, most {times[-1]:.2f} ms")
    assert len(times) == 1000
    agrees(page)


def test_of_two_handles_the_nearer_one_is_dragged(explorer):
    """The target's finger-sized ring lies over the heading's handle, which stays in reach."""
    page = explorer("0,0,0deg,4,3,1")
    x, y = centre(page, "heading")
    tx, ty = centre(page, "target")
    drag(page, "target", x + 15 - tx, y - ty)
    before = scenario_in(page)
    x, y = centre(page, "heading")
    covering = f"document.elementFromPoint({x}, {y}).closest('.handle').matches('.target')"
    assert page.evaluate(covering)
    drag(page, "heading", -62, -62)

    after = scenario_in(page)
    assert after.heading == pytest.approx(math.pi / 2, abs=0.03)  # a pixel or two of 62
    assert (after.target_x, after.target_y) == (before.target_x, before.target_y)


def test_a_press_beside_a_handle_s_middle_moves_nothing(explorer):
    """The handle keeps its distance from the pointer; then it moves as far as the pointer does."""
    page = explorer("0,0,0deg,4,3,1")
    x, y = centre(page, "target")
    page.mouse.move(x + 7, y - 5)
    page.mouse.down()
    assert scenario_in(page) == Scenario(0, 0, 0, 4, 3, 1)
    page.mouse.move(x + 27, y - 5, steps=2)
    assert centre(page, "target") == pytest.approx((x + 20, y), abs=1)  # a pixel of rounding
    page.mouse.up()
    agrees(page)


@pytest.mark.slow
def test_by_keyboard_a_full_turn_comes_back(explorer):
    """36 turns of 10 degrees, by page up and by shift with an arrow; the address follows."""
    page = explorer("0,0,17deg,3,2,1")
    page.locator(".handle.heading").focus()
    for key in ("PageUp", "Shift+ArrowLeft"):
        for _ in range(36):
            page.keyboard.press(key)
            assert -math.pi <= scenario_in(page).heading <= math.pi
        assert scenario_in(page).heading == pytest.approx(math.radians(17), abs=1e-12)
        agrees(page)
    page.wait_for_function("location.hash === '#explore=0,0,17deg,3,2,1'")


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
