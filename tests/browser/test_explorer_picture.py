"""The plane, the chart and handles of the explorer.

They are true and in view, work without scripts, and can be dragged.
"""

import math
import re
from itertools import combinations
from typing import Any

import pytest

from dubins_study import Scenario, solve
from dubins_study.report.page.explorer import PRESETS
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import shortest
from tests.browser_tab import DESK, PHONE, agrees, centre, drag, scenario_in


@pytest.mark.slow
def test_the_map_is_true(explorer):
    """The map names the package's shortest words.

    The regions under 400 points of the picture are compared.
    """
    page = explorer("0.3,-0.2,25deg,1.4,1.1,0.9")
    places = page.evaluate(
        """() => {
          const svg = document.querySelector(".explorer-plane"), found = [];
          for (let i = 0; i < 20; i += 1) for (let j = 0; j < 20; j += 1) {
            // a shorter table below moves the plane on a page that is scrolled to its end
            const box = svg.getBoundingClientRect();
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
        final = ("final",) if "final" in preset.text else ()
        for name in ("target", "heading", "radius", *final):
            x, y = centre(page, name)
            box = page.locator(".explorer-plane").bounding_box()
            assert box["x"] < x < box["x"] + box["width"], preset
            assert box["y"] < y < box["y"] + box["height"], preset


def test_forced_colours_leave_every_line_s_sample(explorer):
    """Forced colours leave every line's sample.

    The table's samples keep colour and pattern, as the lines in the picture do.
    """
    styles = (
        "all => all.map(e => { const s = getComputedStyle(e);"
        " return [s.backgroundImage, s.borderTopStyle, s.borderTopColor]; })"
    )
    forced = explorer(forced_colors="active")
    samples, plain = (
        page.locator(".explorer-words .sample").evaluate_all(styles)
        for page in (forced, explorer())
    )

    assert forced.evaluate("matchMedia('(forced-colors: active)').matches")
    assert samples == plain
    assert len({str(sample) for sample in samples}) == 4


def test_at_the_start_there_is_nothing_to_drive(explorer):
    """At the start there is nothing to drive.

    The page says so once, without a circle that an arc would reach.
    """
    page = explorer("3,-2,0.5rad,3,-2,1")
    page.wait_for_function("document.querySelector('[data-answer=summary]').textContent")

    assert page.locator(".explorer-place").text_content() == (
        "Shortest: nothing to drive, length 0. "
        "The target is the start, where both turning circles meet."
    )


@pytest.mark.slow
def test_the_sweep_over_radii_is_the_package_s(explorer):
    """The sweep over radii is the package's.

    It has every word's length at 160 radii, the shortest word, and where the chosen radius stands.

    Problem 5's target enters the left disc at R = 57.35: there LS ends and RL begins.
    """
    page = explorer("0,0,120deg,-80,20,25")
    page.locator(".explorer-more > summary").click()
    page.wait_for_function("window.explorer.sweep.data()")
    data = page.evaluate("window.explorer.sweep.data()")
    assert len(data["radii"]) == 160
    for i, radius in enumerate(data["radii"]):
        scenario = Scenario(0, 0, "120deg", -80, 20, radius)
        best = shortest(scenario)
        assert best is not None
        assert data["best"][i] == best.word
        for branch, lengths in data["lengths"].items():
            optimum = shortest(scenario, branch)
            if optimum is None:
                assert lengths[i] is None
            else:  # no target lies next to an edge
                assert lengths[i] == pytest.approx(optimum.total * radius, rel=1e-12)
    jump = data["best"].index("RL")
    assert data["radii"][jump - 1] < 57.352960 < data["radii"][jump]
    bold = page.locator(".explorer-sweep path.optimal.ls").get_attribute("d")
    assert bold.count("M") == 1
    assert bold.count("L") == jump - 1
    dot = page.locator(".explorer-sweep .start").bounding_box()
    page.locator(".explorer-sweep svg").click(position={"x": 500, "y": 60})
    page.wait_for_function("window.explorer.state().radius !== 25")
    agrees(page)
    moved = page.locator(".explorer-sweep .start")
    page.wait_for_function(
        "x => document.querySelector('.explorer-sweep .start').getBoundingClientRect().x !== x",
        arg=dot["x"],
    )
    plot = page.locator(".explorer-sweep svg").bounding_box()
    box = moved.bounding_box()
    assert box["x"] + box["width"] / 2 - plot["x"] == pytest.approx(500, abs=2)  # three digits of R


def test_big_and_small_numbers_are_short(explorer):
    """Big and small numbers are short.

    Powers of ten have no zeros that say nothing: columns and ticks are narrow.
    """
    texts = explorer().evaluate(
        "[4e6, 1e12, 1.5e9, -2e-7, 1234567, 999999, 999999.9, 0.25]"
        ".map((x) => explorerNumbers.number(x))"
    )

    assert texts == ["4e6", "1e12", "1.5e9", "−2e−7", "1.23457e6", "999999", "1e6", "0.25"]


LABELS = """() => {
  let seed = 7;
  const random = () => { seed = seed * 48271 % 2147483647; return seed / 2147483647; };
  const svg = document.querySelector(".explorer-sweep-plot"), pictures = [];
  document.querySelector(".explorer-more").open = true;
  for (let i = 0; i < 300; i += 1) {
    const far = 10 ** (12 * random() - 4), heading = 6 * random(), bearing = 6 * random();
    const radius = 10 ** (4 * random() - 2);
    const target = {target_x: far * Math.cos(bearing), target_y: far * Math.sin(bearing)};
    if (!window.explorer.set({heading, radius, ...target}, "fit")) throw new Error("refused");
    const best = window.explorer.entries().find((entry) => entry.optimal);
    window.explorer.sweep.draw(window.explorer.state(), best.length);
    const box = (shape) => {
      const {left, right, top, bottom} = shape.getBoundingClientRect();
      return [left, right, top, bottom];
    };
    const texts = svg.querySelectorAll("text:not([visibility=hidden])");
    pictures.push([box(svg), [...texts].map((text) => [text.textContent, ...box(text)])]);
  }
  return pictures;
}"""


@pytest.mark.slow
@pytest.mark.parametrize("viewport", [PHONE, DESK], ids=["phone", "desk"])
def test_no_label_lies_outside_of_the_chart_or_on_another(explorer, viewport):
    """Labels lie in the chart and overlap none.

    Checked are names and ticks of 300 targets, 1e-4 to 1e8 away at radii of 0.01 to 100.
    """
    words = 0
    for (left, right, top, bottom), labels in explorer(viewport=viewport).evaluate(LABELS):
        for text, x1, x2, y1, y2 in labels:
            assert left <= x1 < x2 <= right, text
            assert top <= y1 < y2 <= bottom, text
        for (text, x1, x2, y1, y2), (other, u1, u2, v1, v2) in combinations(labels, 2):
            assert x2 <= u1 or u2 <= x1 or y2 <= v1 or v2 <= y1, f"{text} on {other}"
        words += sum(text in ("LS", "RS", "LR", "RL") for text, *_ in labels)

    assert words > 2 * 300  # LS or RS is everywhere, mostly both


def test_dragging_the_target_moves_it_and_everything_follows(explorer):
    """Dragging the target changes everything.

    The mouse drags: the handle stays under the pointer, the numbers are the package's.
    """
    page = explorer("0,0,0deg,2,1.5,1")
    before = scenario_in(page)
    x, y = centre(page, "target")
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
    """A second finger moves nothing.

    It lies on another handle and slides, as for a zoom of the page; only handles keep the page
    from scrolling.
    """
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
    """The nearer of two handles is dragged.

    The target's finger-sized ring lies over the heading's handle, which stays in reach.
    """
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
    """A press beside a handle's middle moves nothing.

    The handle keeps its distance from the pointer; then it moves as far as the pointer does.
    """
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
    """Every frame of a drag shows its scenario.

    Word and length are right while nothing rests: only the texts for screen readers wait.
    """
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
    """The word that a frame of the page shows.

    It is the package's for its fields, like all.
    """
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
