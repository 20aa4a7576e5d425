"""Routes and tours in the explorer.

Via points and final heading are changed by mouse, finger and keys.
"""

import json
import math
import shlex
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from typing import Any

import pytest
from typer.testing import CliRunner

from dubins_study import Scenario, solve
from dubins_study.cli.app import app
from dubins_study.report.page.explorer import PRESETS
from dubins_study.study.closed_form.pose import shortest_to_pose
from dubins_study.study.scenario import Pose
from tests.browser_tab import PHONE, centre, drag, number, scenario_in

ROUTE = "0,0,30deg,10,5,1;via=4,1,6,-2;final=90deg"
POSE = "0,0,30deg,4,1,1;final=180deg"
TOUR = "0,0,30deg,12,3,1;via=9,-2,3,5,-3,4,4,-3,8,6;order=free"


def summary(page: Any) -> tuple[str, str, float]:
    """`Shortest` or `Found`, the words, the length.

    The summary line of the page holds them.
    """
    title, _, rest = page.locator("[data-answer=summary]").inner_text().partition(": ")
    words, _, length = rest.partition(", length ")
    return title, words, number(length.partition(" (")[0])


def legs(page: Any) -> list[list[str]]:
    """The cells of the table's rows that are shown."""
    rows: list[list[str]] = page.locator(".explorer-legs tbody tr:visible").evaluate_all(
        "rows => rows.map(row => [...row.cells].map(cell => cell.textContent))"
    )
    return rows


def clicked(page: Any, dx: float, dy: float, name: str = "target") -> None:
    """Click beside a handle."""
    x, y = centre(page, name)
    page.mouse.click(x + dx, y + dy)


def test_a_route_and_its_copies(explorer):
    """A route and its copies agree.

    The address, the command and the Python are of one route, whose length the page shows.
    """
    page = explorer(ROUTE)
    expected = Scenario(0, 0, "30deg", 10, 5, via=[(4, 1), (6, -2)], final_heading="90deg")
    assert scenario_in(page) == expected
    answer = solve(expected)
    assert summary(page) == ("Found", answer.word, pytest.approx(answer.length, rel=6e-6))
    assert [row[0] for row in legs(page)] == ["start → 1", "1 → 2", "2 → T"]
    assert sum(number(row[3]) for row in legs(page)) == pytest.approx(answer.length, rel=2e-5)
    assert page.locator("[data-answer=place]").inner_text().startswith("Not proved: ")
    page.wait_for_function("document.querySelector('[data-copy=link]').textContent")
    assert page.locator("[data-copy=link]").inner_text().endswith(f"#explore={ROUTE}")

    command = shlex.split(page.locator("[data-copy=command]").inner_text())  # in view
    printed = CliRunner().invoke(app, [*command[1:], "--json"])
    assert json.loads(printed.stdout)["length"] == pytest.approx(answer.length, rel=1e-9)
    names: dict[str, Any] = {}
    with redirect_stdout(StringIO()):
        exec(page.locator("[data-copy=python]").text_content(), names)  # our own text
    assert names["answer"].scenario == expected


def test_one_leg_with_a_final_heading_has_six_words(explorer):
    """Exact, and it says so."""
    page = explorer(POSE)
    best = shortest_to_pose(Pose(0, 0, math.radians(30)), Pose(4, 1, math.pi), 1.0)
    assert best is not None
    assert summary(page) == ("Shortest", best.word, pytest.approx(best.total, rel=6e-6))
    assert page.locator("[data-answer=place]").inner_text().startswith("Exact: ")
    assert [row[0].rstrip(" ✓") for row in legs(page)] == ["LSL", "RSR", "LSR", "RSL", "RLR", "LRL"]
    assert [row[0] for row in legs(page) if row[4] == "shortest"] == [f"{best.word} ✓"]
    drag(page, "final", 30, 40)
    turned = scenario_in(page)
    assert turned.final_heading != math.pi
    assert summary(page)[2] == pytest.approx(solve(turned).length, rel=6e-6)


def test_examples_of_routes(explorer):
    page = explorer()
    for preset in PRESETS:
        if ";" in preset.text:
            page.get_by_role("button", name=preset.name, exact=True).click()
            scenario = scenario_in(page)
            assert bool(scenario.via) == ("via" in preset.text)
            assert summary(page)[2] == pytest.approx(solve(scenario).length, rel=6e-6)


def test_click_to_add_drag_to_move_double_click_to_remove(explorer):
    """Clicks add, drags move, double clicks remove points.

    On the map of words a click still sets the target; twelve via points are the most.
    """
    page = explorer("0,0,0deg,8,0,1")
    clicked(page, -30, -60)
    assert scenario_in(page).one_free_leg
    page.get_by_role("button", name="Add a via point").click()
    assert len(scenario_in(page).via) == 1
    clicked(page, -60, 60)
    assert len(scenario_in(page).via) == 2
    before = scenario_in(page)
    length = summary(page)[2]
    assert before.via[1][1] < before.target_y
    drag(page, "via-2", 25, -90)
    after = scenario_in(page)
    assert (after.via[0], after.target_x) == (before.via[0], before.target_x)
    assert after.via[1][0] > before.via[1][0]
    assert after.via[1][1] > before.via[1][1]
    assert summary(page)[2] != length
    page.mouse.dblclick(*centre(page, "via-1"))
    assert scenario_in(page).via == (after.via[1],)
    for _ in range(11):
        page.get_by_role("button", name="Add a via point").click()
    assert len(scenario_in(page).via) == 12
    page.get_by_role("button", name="Add a via point").click()
    assert "expected at most 12" in page.locator("[data-answer=problem]").inner_text()
    assert len(legs(page)) == 13


def test_a_click_on_the_path_adds_to_that_leg(explorer):
    """A click on the path adds to that leg.

    Here it is in the middle of the first of two legs, which is straight.
    """
    page = explorer("0,0,0deg,12,4,1;via=8,0")
    to_x, to_y = centre(page, "via-1")
    start = page.locator(".explorer-plane .start").bounding_box()
    page.mouse.click((start["x"] + to_x) / 2 + 40, (start["y"] + to_y) / 2 + 3)
    first, second = scenario_in(page).via
    assert 3 < first[0] < 8
    assert second == (8, 0)


def test_a_route_by_keyboard(explorer):
    """A route is changed by keyboard.

    Tab goes from point to point in order; Delete removes a point, or sets the heading free.
    """
    page = explorer(ROUTE)
    page.locator(".handle.via-1").focus()
    assert page.locator(".handle.via-1").get_attribute("aria-valuetext").startswith("4, 1. Found: ")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+ArrowUp")
    assert scenario_in(page).via == ((3.95, 1), (6, -1.5))
    page.keyboard.press("Tab")
    page.keyboard.press("ArrowUp")
    assert scenario_in(page).final_heading == math.radians(91)
    assert page.get_by_role("slider").count() == 6
    page.keyboard.press("Delete")
    assert scenario_in(page).final_heading is None
    page.locator(".handle.via-1").focus()
    page.keyboard.press("Delete")
    page.keyboard.press("Delete")
    assert scenario_in(page).one_free_leg
    assert page.locator(".handle.target").evaluate("e => e === document.activeElement")
    assert summary(page)[0] == "Shortest"
    assert page.locator(".explorer-map").is_visible()


def test_the_final_heading_is_free_or_given(explorer):
    """The final heading is free or given.

    The button changes it and keeps the path. The field changes it too, where nothing is free.
    """
    page = explorer("0,0,0deg,6,3,1")
    length = summary(page)[2]
    button = page.get_by_role("button", name="Final heading", exact=True)
    assert button.get_attribute("aria-pressed") == "false"
    button.click()
    assert button.get_attribute("aria-pressed") == "true"
    assert summary(page)[2] == pytest.approx(length, rel=1e-3)  # whole degrees
    field = page.get_by_label("final heading, deg")
    field.fill("-45")
    assert scenario_in(page).final_heading == math.radians(-45)
    field.fill("")
    assert scenario_in(page).final_heading is None
    button.click()
    button.click()
    assert scenario_in(page).one_free_leg


def test_a_finger_adds_moves_and_removes(explorer):
    page = explorer(ROUTE, viewport=PHONE, has_touch=True, is_mobile=True)
    x, y = centre(page, "via-2")
    page.touchscreen.tap(x - 40, y + 30)
    assert len(scenario_in(page).via) == 3
    x, y = centre(page, "via-3")
    page.touchscreen.tap(x, y)
    page.touchscreen.tap(x, y)
    assert scenario_in(page).via == ((4, 1), (6, -2))
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_broken_route_is_refused_in_words(explorer):
    reasons = {
        "0,0,0,1,1,1;via=1,2,3": "via=1,2,3 is neither via=x,y,... nor final=heading",
        "0,0,0,1,1,1;to=3": "to=3 is neither",
        "0,0,0,1,1,1;via=a,b": "via point 1: target_x is NaN; expected a finite number",
        "0,0,0,1,1,1;via=2,2,2,2": "a via point is equal to the point before or after it",
        "0,0,0,9,1,1;via=2,2,5,5,2,2;order=free": "two points are equal",
        "0,0,0,9,1,1;via=2,2;order=best": "order=best is neither",
        "0,0,0,1,1,1;final=north": "final heading is not an angle",
        f"0,0,0,1,1,1;via={','.join(map(str, range(26)))}": "expected at most 12",
    }
    for text, reason in reasons.items():
        page = explorer(text)
        assert reason in page.locator("[data-answer=problem]").inner_text()
        assert scenario_in(page).one_free_leg  # the first example


def numbers(page: Any) -> list[str]:
    """Numbers on the handles of the via points.

    They come in the order of the list of points.
    """
    handles = page.locator(".handle[class*=via]:visible")
    texts: list[str] = handles.evaluate_all(
        "all => all.map(handle => handle.querySelector('text').textContent)"
    )
    return texts


def place(page: Any) -> str:
    """The sentence of the page about its answer."""
    text: str = page.locator("[data-answer=place]").inner_text()
    return text


def test_a_tour_and_its_copies(explorer):
    """A tour and its copies agree.

    Points are numbered by their visits. The page says what is proved, and what the list would
    cost.
    """
    page = explorer(TOUR)
    expected = scenario_in(page)
    assert expected.order == "free"
    answer = solve(expected)
    assert summary(page) == ("Found", answer.word, pytest.approx(answer.length, rel=6e-6))
    assert answer.order == [2, 1, 4, 3, 0]
    assert numbers(page) == ["5", "2", "1", "4", "3"]
    assert [row[0] for row in legs(page)] == [
        *("start → 1", "1 → 2", "2 → 3", "3 → 4", "4 → 5", "5 → T")
    ]
    given = solve(replace(expected, order="given"))
    assert place(page).startswith("The best order found, not proved.")
    cost = f"the route found in the given order is {given.length:.4f} long"
    assert f"It is 3, 2, 5, 4, 1 of the given points; {cost}" in place(page)
    assert "All 120 orders" in place(page)
    page.wait_for_function("document.querySelector('[data-copy=link]').textContent")
    assert page.locator("[data-copy=link]").inner_text().endswith(f"#explore={TOUR}")

    command = shlex.split(page.locator("[data-copy=command]").inner_text())
    printed = json.loads(CliRunner().invoke(app, [*command[1:], "--json"]).stdout)
    assert printed["length"] == pytest.approx(answer.length, rel=1e-9)
    assert printed["order"] == [2, 1, 4, 3, 0]
    names: dict[str, Any] = {}
    with redirect_stdout(StringIO()):
        exec(page.locator("[data-copy=python]").text_content(), names)  # our own text
    assert names["answer"].scenario == expected


def test_the_order_is_free_or_given(explorer):
    """The order is free or given.

    The button changes it, with keys too; the list of points stays, and the address follows.
    """
    page = explorer(TOUR.removesuffix(";order=free"))
    button = page.get_by_role("button", name="Any order", exact=True)
    assert button.get_attribute("aria-pressed") == "false"
    assert numbers(page) == ["1", "2", "3", "4", "5"]
    length = summary(page)[2]
    points = scenario_in(page).via
    button.focus()
    page.keyboard.press("Space")
    assert button.get_attribute("aria-pressed") == "true"
    assert scenario_in(page).via == points
    assert summary(page)[2] < length
    page.wait_for_function("location.hash.endsWith(';order=free')")
    handle = page.locator(".handle.via-3")
    assert handle.get_attribute("aria-label").startswith("Via point 3, visit 1: arrow keys")
    page.keyboard.press("Enter")
    assert summary(page)[2] == length
    assert numbers(page) == ["1", "2", "3", "4", "5"]
    assert handle.get_attribute("aria-label").startswith("Via point 3: arrow keys")


def test_points_of_a_tour_are_added_dragged_and_removed(explorer):
    """Points of a tour are added, dragged and removed.

    A new point is the last of the list; without points there is no order to be free.
    """
    page = explorer(TOUR)
    before = scenario_in(page)
    x, y = centre(page, "via-3")
    page.mouse.click(x + 60, y + 40)
    page.get_by_role("button", name="Add a via point").click()
    added = scenario_in(page)
    assert added.via[:5] == before.via
    assert len(added.via) == 7
    drag(page, "via-1", -150, -60)
    moved = scenario_in(page)
    assert moved.via[1:] == added.via[1:]
    answer = solve(moved)
    assert summary(page)[2] == pytest.approx(answer.length, rel=6e-6)
    visits = {point: str(visit + 1) for visit, point in enumerate(answer.order or ())}
    assert numbers(page) == [visits[point] for point in range(7)]
    page.locator(".handle.via-1").focus()
    for _ in range(6):
        page.keyboard.press("Delete")
    assert len(scenario_in(page).via) == 1
    assert place(page).startswith("Not proved: ")  # of one point there is one order
    page.keyboard.press("Delete")
    page.get_by_role("button", name="Add a via point").click()
    assert scenario_in(page).order == "given"


def test_the_given_order_may_be_the_best(explorer):
    page = explorer("0,0,0deg,12,0,1;via=4,1,8,-1;order=free")
    assert "It is the given order. All 2 orders" in place(page)


def test_the_first_view_knows_no_order(explorer):
    """The first view knows no order.

    The map of words, its copies and handles are of one leg; the button waits for points.
    """
    page = explorer()
    assert page.get_by_role("button", name="Any order", exact=True).count() == 0
    assert page.get_by_role("button", name="Final heading", exact=True).count() == 1
    assert page.get_by_role("slider").count() == 3
    assert page.locator(".explorer-place").text_content() == (
        "Shortest: RS, length 11.8681 (11.8681 R). "
        "The target lies outside both turning circles, 9.182 R from the nearer one."
    )
    assert page.locator("[data-copy=command]").text_content() == (
        "dubins-study solve 10 5 --from 0 0 120deg --radius 1"
    )
    assert "order" not in page.locator("[data-copy=python]").text_content()
    assert page.locator("[data-copy=link]").text_content().endswith("#explore=0,0,120deg,10,5,1")
