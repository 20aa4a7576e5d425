"""A page in Chromium, and the explorer on it.

A page may log no error and ask for nothing remote.
"""

from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from dubins_study import Scenario
from dubins_study.study.closed_form.shortest import shortest

PHONE, DESK = {"width": 400, "height": 800}, {"width": 1280, "height": 900}


class Tab:
    """A page in the browser.

    `close` fails if it logged an error or asked for anything remote.
    """

    def __init__(self, browser: Browser, **options: Any) -> None:
        self.context: BrowserContext = browser.new_context(**options)
        self.page: Page = self.context.new_page()
        self.errors: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda line: line.type == "error" and self.errors.append(line.text))
        self.page.on(
            "request",
            lambda request: request.url.startswith("http") and self.errors.append(request.url),
        )
        self.page.on("dialog", self._dialog)

    def _dialog(self, dialog: Any) -> None:
        self.errors.append(f"a dialog: {dialog.message}")  # text from outside was run as a script
        dialog.dismiss()

    def close(self) -> None:
        self.context.close()
        assert not self.errors, self.errors


def scenario_in(page: Page) -> Scenario:
    """The scenario that the page shows."""
    state = page.evaluate("window.explorer.state()")
    return Scenario(**{name: state[name] for name in state if not name.endswith("written")})


def shown(page: Page) -> dict[str, dict[str, str]]:
    """The table of the explorer, by branch and cell.

    Each row also says whether it is marked as optimal.
    """
    rows = page.locator("tr[data-branch]").evaluate_all(
        """rows => rows.map(row => [row.dataset.branch, {
             optimal: String(row.classList.contains("optimal")),
             ...Object.fromEntries([...row.querySelectorAll("[data-cell]")]
                 .map(cell => [cell.dataset.cell, cell.textContent]))}])"""
    )
    return dict(rows)


def number(text: str) -> float:
    return float(text.replace("−", "-"))


def centre(page: Page, name: str) -> tuple[float, float]:
    """Position of a handle on the screen."""
    page.locator(".explorer-stage").scroll_into_view_if_needed()
    box = page.locator(f".handle.{name} .knob").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page: Page, name: str, dx: float, dy: float) -> None:
    x, y = centre(page, name)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + dx / 2, y + dy / 2, steps=3)
    page.mouse.move(x + dx, y + dy, steps=3)
    page.mouse.up()


def agrees(page: Page) -> None:
    """Check that the table agrees with the package.

    Both answer the scenario that is shown.
    """
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


def shown_best(page: Page) -> str:
    return next(branch for branch, cells in shown(page).items() if cells["optimal"] == "true")
