"""What the explorer offers to copy: a scenario as an address, a command and Python."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO

import pytest
from browser_tab import PHONE, agrees, number, scenario_in, shown, shown_best

from dubins_study import Scenario, solve
from dubins_study.study.angle import parse_angle


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
    """Hostile or incomplete text is no scenario and no markup; the page says what is wrong."""
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
