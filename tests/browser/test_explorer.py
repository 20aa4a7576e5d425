"""The explorer, driven as a reader does: pointer, touch, keyboard, fields, examples, address."""

from __future__ import annotations

import json
import math
import re
import shlex
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO

import pytest
from browser_tab import DESK, PHONE

from dubins_study import Scenario, solve
from dubins_study.report.explorer.fragment import PRESETS
from dubins_study.report.explorer.standalone import write_standalone
from dubins_study.study.angle import parse_angle
from dubins_study.study.closed_form.shortest import region_of, shortest
from dubins_study.study.vehicle_frame import local

FRAME_S = 1 / 60


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The explorer's own page."""
    return write_standalone(tmp_path_factory.mktemp("explorer") / "explorer.html").as_uri()


@pytest.fixture
def explorer(new_tab, address):
    """`explorer(text="", **options)`: the page opened at `#explore=text`."""

    def opened(text: str = "", **options):
        page = new_tab(**options)
        page.goto(f"{address}#explore={text}" if text else address)
        return page

    return opened


def scenario_in(page) -> Scenario:
    """The scenario that the page shows."""
    state = page.evaluate("window.explorer.state()")
    state.pop("written")
    return Scenario(**state)


def shown(page) -> dict[str, dict[str, str]]:
    """The table: branch -> cell -> text, and whether the row is marked as optimal."""
    rows = page.locator("tr[data-branch]").evaluate_all(
        """rows => rows.map(row => [row.dataset.branch, {
             optimal: String(row.classList.contains("optimal")),
             ...Object.fromEntries([...row.querySelectorAll("[data-cell]")]
                 .map(cell => [cell.dataset.cell, cell.textContent]))}])"""
    )
    return dict(rows)


def number(text: str) -> float:
    return float(text.replace("−", "-"))


def centre(page, name: str) -> tuple[float, float]:
    """Where a handle is on the screen."""
    page.locator(".explorer-stage").scroll_into_view_if_needed()
    box = page.locator(f".handle.{name} .knob").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page, name: str, dx: float, dy: float) -> None:
    x, y = centre(page, name)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx / 2, y + dy / 2, steps=3)
    page.mouse.move(x + dx, y + dy, steps=3)
    page.mouse.up()


def agrees(page) -> None:
    """What the table says is what the package says of the scenario that is shown."""
    scenario = scenario_in(page)
    best = shortest(scenario)
    assert best is not None
    for branch, cells in shown(page).items():
        optimum = shortest(scenario, branch)
        if optimum is None:
            assert cells["length"] == "–"
            assert cells["certificate"].startswith("no path")
            continue
        # six digits are shown
        assert number(cells["length"]) == pytest.approx(optimum.total * scenario.radius, rel=6e-6)
        assert number(cells["radii"]) == pytest.approx(optimum.total, rel=6e-6)
        assert cells["optimal"] == str(optimum.word in best.words).lower()
        assert (cells["over"] == "shortest") == (optimum.word in best.words)


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
    """And the link, the command and the Python that are offered lead to the same scenario."""
    page = explorer(text)
    x, y, heading, *rest = text.split(",")
    scenario = Scenario(float(x), float(y), parse_angle(heading), *map(float, rest))
    assert scenario_in(page) == scenario
    agrees(page)
    page.wait_for_function("document.querySelector('[data-copy=link]').textContent")
    link = page.locator("[data-copy=link]").text_content()
    assert link.endswith(f"#explore={text}")


def test_a_broken_address_is_left_alone(explorer):
    """Hostile or incomplete text is no scenario and no markup."""
    for text in ("1,2", "%3Cimg src=x onerror=alert(1)%3E,0,0,1,1,1", "%E0%A4%A", "0,0,0,1,1,0"):
        page = explorer(text)
        assert page.evaluate("window.explorer.state().written") == "120deg"  # the first example
        assert page.locator("img[src=x]").count() == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["0.5,0,-110deg,-0.3,0.2,1.5", "0,1e-7,7.5,-3,1,1", "0,0,30°,1,1,2"]
)
def test_the_offered_command_and_python_run(explorer, text):
    """As pasted; they print the length that the page shows."""
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


def shown_best(page) -> str:
    return next(branch for branch, cells in shown(page).items() if cells["optimal"] == "true")


def test_copy_puts_the_command_on_the_clipboard(explorer):
    page = explorer(permissions=["clipboard-read", "clipboard-write"])
    page.get_by_role("button", name="Copy: Command line").click()
    page.wait_for_function(
        "document.querySelector('[data-copies=command]').textContent == 'copied'"
    )

    expected = "dubins-study solve 10 5 --from 0 0 120deg --radius 1"
    assert page.evaluate("navigator.clipboard.readText()") == expected


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
def test_the_sweep_over_radii_is_the_package_s(explorer):
    """Every word's length at 160 radii, the shortest word, and where the chosen radius stands.

    Problem 5's target enters the left disc at R = 57.35: there LS ends and RL begins.
    """
    page = explorer("0,0,120deg,-80,20,25")
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


def test_big_and_small_numbers_are_short(explorer):
    """Powers of ten without zeros that say nothing: columns and ticks are narrow."""
    texts = explorer().evaluate(
        "[4e6, 1e12, 1.5e9, -2e-7, 1234567, 999999, 0.25].map((x) => explorerNumbers.number(x))"
    )

    assert texts == ["4e6", "1e12", "1.5e9", "−2e−7", "1.23457e6", "999999", "0.25"]


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


def test_in_the_report_it_answers_beside_the_other_scripts(new_tab, report_page):
    """Restored from the address, driven by keyboard, the address kept up to date."""
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
