"""The explorer's handles, dragged by mouse and finger."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest
from browser_tab import PHONE, agrees, centre, drag, scenario_in

from dubins_study import Scenario, solve


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
    drag(page, "radius", 0, 30)  # away from the start
    assert scenario_in(page).radius > 1.1
    agrees(page)


def test_a_second_finger_does_not_move_what_the_first_drags(explorer):
    """It lies on another handle and slides, as for a zoom of the page; only handles keep the page
    from scrolling."""
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
    touch = "name => getComputedStyle(document.querySelector(name)).touchAction"
    assert page.evaluate(touch, ".handle") == "none"
    assert page.evaluate(touch, "svg") == "auto"
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


_FRAMES = """() => {
  const text = (name) => document.querySelector(`[data-answer=${name}]`).textContent;
  window.frames_seen = [];
  const look = () => {
    const fields = {};
    for (const input of document.querySelectorAll("input[name]")) fields[input.name] = input.value;
    window.frames_seen.push({fields, summary: text("summary"), place: text("place"),
      spoken: text("spoken"), link: document.querySelector("[data-copy=link]").textContent});
  };
  const paint = () => {  // before each painting of the page
    look();
    requestAnimationFrame(paint);
  };
  paint();
  addEventListener("pointermove", look);  // behind the handle's own, painted or not
}"""


def test_in_every_frame_of_a_drag_the_line_is_that_of_its_scenario(explorer):
    """Word and length, while nothing rests: only what screen readers hear waits for that."""
    page = explorer("0,0,0deg,1.3,1,1")
    page.wait_for_function("document.querySelector('[data-answer=spoken]').textContent")
    before = page.locator("[data-answer=spoken]").text_content()
    assert before == page.locator("[data-answer=summary]").inner_text()  # as it is seen
    x, y = centre(page, "target")
    discs = [page.locator(f"circle[data-word={word}]").bounding_box() for word in ("RL", "LR")]
    page.evaluate(_FRAMES)
    page.mouse.move(x, y)
    page.mouse.down()
    for disc in discs:  # into both turning circles, and between them across both half-planes
        page.mouse.move(disc["x"] + disc["width"] * 0.7, disc["y"] + disc["height"] / 2, steps=5)
    page.mouse.move(x + 30, y + 150, steps=3)
    during = page.evaluate("[...frames_seen]")
    summary = page.locator("[data-answer=summary]").inner_text()
    page.mouse.up()

    words = {_word_of_frame(frame) for frame in during}
    assert words == {"LS", "RL", "LR", "RS"}
    first = next(frame for frame in during if frame["summary"] != before)
    assert first["spoken"] == before
    page.wait_for_function(
        "text => document.querySelector('[role=status]').textContent === text", arg=summary
    )


def _word_of_frame(frame: dict[str, Any]) -> str:
    """The word that a frame of the page shows, which is the package's for its fields, like all."""
    values = {name: float(text) for name, text in frame["fields"].items() if text}
    scenario = Scenario(**values | {"heading": math.radians(values["heading"])})
    answer = solve(scenario)
    match = re.fullmatch(r"Shortest: (\w+), length (\S+) \((\S+) R\)\.", frame["summary"])
    assert match, frame
    assert match[1] == answer.word, frame
    # six digits are shown
    assert float(match[2]) == pytest.approx(answer.length, rel=6e-6), frame
    assert float(match[3]) == pytest.approx(answer.length / scenario.radius, rel=6e-6), frame
    place = {"RL": "inside the left", "LR": "inside the right"}.get(answer.word, "outside both")
    assert frame["place"].startswith(f"The target lies {place}"), frame
    target = f"{frame['fields']['target_x']},{frame['fields']['target_y']},"
    assert target in frame["link"], frame
    return match[1]
