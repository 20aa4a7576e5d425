"""Fixtures of a real Chromium for report pages.

Pages are opened from files, without a network.
"""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from dubins_study import render
from dubins_study.report.page.explorer import write_explorer
from tests.browser_report import small_report
from tests.browser_tab import DESK, Tab
from tests.unit.report.topic_page import without_pdf_files


@pytest.fixture(autouse=True, scope="module")
def svg_alone() -> Iterator[None]:
    """No page shows the PDF files of its figures."""
    with without_pdf_files():
        yield


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """Debian's or another Chromium on PATH.

    Continuous integration must have one.
    """
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None and not os.environ.get("CI"):
        pytest.skip("needs chromium on PATH")
    with sync_playwright() as playwright:
        arguments = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        browser = playwright.chromium.launch(executable_path=program, args=arguments)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def report_page(tmp_path_factory: pytest.TempPathFactory) -> FilePath:
    """`index.html` of a small report.

    It has a benchmark, the paper's problems and a radius sweep.
    """
    with without_pdf_files():
        return small_report(tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="session")
def benchmark_page(tmp_path_factory: pytest.TempPathFactory) -> FilePath:
    """`index.html` of the committed benchmark."""
    results = FilePath(__file__).parents[2] / "results" / "benchmark"
    with without_pdf_files():
        return render([results], tmp_path_factory.mktemp("benchmark") / "report")


@pytest.fixture
def new_tab(chromium: Browser) -> Iterator[Any]:
    """`new_tab(viewport=PHONE, color_scheme="dark", ...)` -> a playwright `Page`."""
    tabs: list[Tab] = []

    def opened(**options: Any) -> Page:
        tabs.append(Tab(chromium, **({"viewport": DESK} | options)))
        return tabs[-1].page

    yield opened
    for tab in tabs:
        tab.close()


@pytest.fixture(scope="session")
def explorer_address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The explorer's own page."""
    return write_explorer(tmp_path_factory.mktemp("explorer") / "explorer.html").as_uri()


@pytest.fixture
def explorer(new_tab: Any, explorer_address: str) -> Any:
    """`explorer(text="", **options)`: the page opened at `#explore=text`."""

    def opened(text: str = "", **options: Any) -> Page:
        page: Page = new_tab(**options)
        place = f"#explore={text}" if text else ""
        page.goto(f"{explorer_address}{place}")
        return page

    return opened
