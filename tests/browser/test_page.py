"""The page in a browser.

It is opened on a phone and a desk, in the dark, in print, and by keyboard.
"""

import re
from pathlib import Path

import pytest

from dubins_study import render
from dubins_study.study.words import Claim
from tests.browser_tab import DESK, PHONE, Tab
from tests.unit.report.results_folder import attempt, paper_scenarios, write_folder

LOST = [(scenario, solver) for scenario in paper_scenarios() for solver in ("slsqp", "ipopt")]


@pytest.mark.smoke
def test_an_error_on_the_page_fails_its_test(chromium, tmp_path: Path):
    """An error on the page fails its test.

    So does a request for something remote, or a dialog.
    """
    file = tmp_path / "page.html"
    file.write_text("<script>throw new Error('wrong')</script><script>alert('run')</script>")
    tab = Tab(chromium)
    tab.page.goto(file.as_uri())

    with pytest.raises(AssertionError, match="wrong"):
        tab.close()


@pytest.mark.parametrize(("viewport", "scheme"), [(PHONE, "dark"), (DESK, "light")])
def test_nothing_scrolls_sideways(new_tab, report_page: Path, viewport, scheme: str):
    """Nothing scrolls sideways.

    A part wider than the screen scrolls in a box of its own.
    """
    page = new_tab(viewport=viewport, color_scheme=scheme)
    page.goto(report_page.as_uri())
    # A section that is laid out only when it comes into view would hide what is too wide.
    page.add_style_tag(content="main > section { content-visibility: visible !important }")
    page.evaluate("document.querySelectorAll('details').forEach((part) => { part.open = true })")

    assert page.evaluate("document.scrollingElement.scrollWidth") <= viewport["width"]


def test_every_anchor_is_there_once(new_tab, report_page: Path):
    """Every anchor is there once.

    Ids are unique, in figures too; links, markers and patterns inside the page are there.
    """
    page = new_tab()
    page.goto(report_page.as_uri())
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map((part) => part.id)")
    links = page.evaluate(
        "[...document.querySelectorAll('a[href^=\"#\"]')].map((link) => link.hash.slice(1))"
    )
    used = page.evaluate(
        """[...document.querySelectorAll('svg use')].map(
            (part) => part.href.baseVal.slice(1))"""
    )
    fills = page.evaluate(
        "[...document.querySelectorAll('[fill]')].map((part) => part.getAttribute('fill'))"
    )
    patterns = {fill[5:-1] for fill in fills if fill.startswith("url(#")}

    assert len(ids) == len(set(ids)) > 50
    assert {*links, *used, *patterns} <= set(ids)
    assert len(used) > 50
    assert len(patterns) >= 3  # of the explorer's plane


def test_every_file_that_the_page_links_is_there(new_tab, report_page: Path):
    """Every file that the page links is there.

    Tables as CSV and LaTeX and figures as SVG and PDF lie below the page's folder.
    """
    page = new_tab()
    page.goto(report_page.as_uri())
    find = "[...document.querySelectorAll('a')].map((a) => a.getAttribute('href'))"
    links = page.evaluate(find)
    page.goto(report_page.with_name("paper.html").as_uri())
    links += page.evaluate(find)
    files = {link for link in links if not link.startswith("#") and ".html" not in link}
    written = {
        str(file.relative_to(report_page.parent))
        for folder in ("tables", "figures")
        for file in (report_page.parent / folder).iterdir()
    }

    assert files == written
    assert {Path(name).suffix for name in files} == {".csv", ".tex", ".svg", ".pdf"}


@pytest.mark.slow
@pytest.mark.parametrize(("width", "most"), [(1280, 6000), (400, 9400)])
def test_the_benchmark_is_read_in_one_sitting(new_tab, benchmark_page: Path, width: int, most: int):
    """The benchmark is read in one sitting.

    The page as it opens, details folded, is a few screens tall, on a desk and on a phone.
    """
    page = new_tab(viewport={"width": width, "height": 900})
    page.goto(benchmark_page.as_uri())
    page.wait_for_function("window.explorer")

    assert page.evaluate("document.scrollingElement.scrollHeight") <= most
    assert page.evaluate("document.scrollingElement.scrollWidth") <= width
    assert page.locator("main > section > details.part[open]").count() == 0


@pytest.mark.slow
def test_the_contents_follow_the_reading(new_tab, report_page: Path):
    """The contents follow the reading.

    On a desk they stay on the screen, and mark the section that is read.
    """
    page = new_tab(viewport=DESK, reduced_motion="reduce")
    page.goto(report_page.as_uri())
    current = page.locator("#contents a[aria-current]")
    first = current.text_content()
    page.evaluate("document.getElementById('decision').scrollIntoView()")
    page.wait_for_function(
        "document.querySelector('#contents a[aria-current]').hash === '#decision'"
    )

    assert current.count() == 1
    assert first != current.text_content()
    assert current.is_visible()
    assert page.locator("#contents").bounding_box()["y"] >= 0
    page.evaluate("window.scrollTo(0, document.scrollingElement.scrollHeight)")
    page.wait_for_function(
        "document.querySelector('#contents a[aria-current]').hash === '#glossary'"
    )


def test_the_contents_fold_away_on_a_phone(new_tab, report_page: Path):
    """The contents fold away on a phone.

    One line names the section that is read; a tap unfolds the list, a link folds it again.
    """
    page = new_tab(viewport=PHONE, reduced_motion="reduce")
    page.goto(report_page.as_uri())
    link = page.locator("#contents a[href='#decision']")

    assert not link.is_visible()
    page.locator("#contents summary").click()
    assert link.is_visible()
    link.click()
    assert not link.is_visible()
    page.wait_for_function("document.getElementById('here').textContent.includes('engine')")
    assert page.locator("#contents summary").bounding_box()["y"] >= 0


@pytest.mark.slow
def test_the_page_is_reached_by_keyboard(new_tab, report_page: Path):
    """The page is reached by keyboard.

    The first stop skips the contents. Every stop shows where the reader is: by an outline, and a
    handle of the explorer by its ring.
    """
    page = new_tab()
    page.goto(report_page.as_uri())
    page.keyboard.press("Tab")
    skip = page.locator(".skip")

    assert skip.evaluate("(link) => document.activeElement === link")
    assert skip.bounding_box()["x"] >= 0
    for _ in range(40):
        page.keyboard.press("Tab")
        sign = page.evaluate(
            """() => {
                const stop = document.activeElement, ring = stop.querySelector(".focus");
                return ring ? getComputedStyle(ring).stroke : getComputedStyle(stop).outlineStyle;
            }"""
        )
        here = page.evaluate("document.activeElement.outerHTML.slice(0, 200)")
        assert sign not in ("none", "rgba(0, 0, 0, 0)"), here


@pytest.mark.slow
def test_print_shows_all_rows_and_no_contents(new_tab, report_page: Path):
    """Print shows all rows and no contents.

    Boxes that scroll on a screen are whole on paper, in dark ink. The headings of tables, which
    scripts make buttons, stay.
    """
    page = new_tab(color_scheme="dark")
    page.goto(report_page.as_uri())
    page.emulate_media(media="print")
    hidden = page.evaluate(
        """[...document.querySelectorAll('.scroll')].filter(
            (box) => box.scrollHeight > box.clientHeight + 1).length"""
    )

    assert not page.locator("#contents").is_visible()
    assert not page.locator(".files").first.is_visible()
    headings = page.locator("#decision .blocks >> nth=0").locator("th .sort")

    assert hidden == 0
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
    assert headings.count() >= 2
    assert all(headings.nth(place).is_visible() for place in range(headings.count()))


def test_the_page_is_complete_without_scripts(new_tab, report_page: Path):
    """The page is complete without scripts.

    All text, tables and figures are in the file; the contents are open, and folds unfold.
    """
    page = new_tab(java_script_enabled=False, viewport=DESK)
    page.goto(report_page.as_uri())

    assert page.locator("#contents a[href='#glossary']").is_visible()
    page.locator("details.part > summary").first.click()
    assert page.locator("details.part[open] > :not(summary)").first.is_visible()
    assert page.locator("#belief svg").first.is_visible()


@pytest.mark.slow
def test_a_link_to_what_is_folded_unfolds_it(new_tab, report_page: Path):
    """A link to something folded unfolds it.

    Else a permalink to one of many figures would lead to nothing.
    """
    page = new_tab(reduced_motion="reduce")
    page.goto(report_page.as_uri())
    folded = page.locator("details.more figure").first
    anchor = folded.get_attribute("id")
    assert not folded.is_visible()

    page.evaluate("(anchor) => { window.location.hash = anchor }", anchor)
    folded.wait_for(state="visible")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([], "There is nothing to report yet."),
        ([attempt(paper_scenarios()[0], "slsqp")], "slsqp"),
        (
            [attempt(s, x, path=None, claim=Claim.FAILED) for s, x in LOST],
            "slsqp",
        ),
    ],
    ids=["empty", "one solver", "all failures"],
)
def test_a_run_of_little_is_a_page_too(new_tab, tmp_path: Path, rows, words):
    """A run of little is a page too.

    Its scripts find nothing to work on, and say nothing.
    """
    folder = write_folder(tmp_path / "mine", "mine", rows)
    page = new_tab(viewport=PHONE)
    page.goto(render([folder], tmp_path / "out").as_uri())

    assert words in page.locator("#decision").text_content()
    assert page.locator("#contents a[aria-current]").count() == 1
    assert page.evaluate("document.scrollingElement.scrollWidth") <= PHONE["width"]


@pytest.mark.parametrize("viewport", [PHONE, DESK])
def test_links_land_on_their_heading(new_tab, report_page: Path, viewport):
    """Links land on their heading.

    It lies below the bar that stays on a phone, and near it. There is no smooth scrolling, which
    stopped short of late sections: sections get their heights only when they come near.
    """
    page = new_tab(viewport=viewport, reduced_motion="reduce")
    page.goto(report_page.as_uri())
    landed = page.evaluate(
        """async () => {
            const places = [];
            for (const link of document.querySelectorAll('#contents a[href^="#"]')) {
                window.location.hash = link.hash;
                let heading = {top: NaN};
                for (let still = 0, looks = 0; still < 4 && looks < 50; looks++) {
                    await new Promise((done) => setTimeout(done, 60));
                    const before = heading.top;  // what comes near is drawn, and then it is still
                    heading = document.querySelector(`${link.hash} h2`).getBoundingClientRect();
                    still = heading.top === before ? still + 1 : 0;
                }
                const bar = document.getElementById("contents").getBoundingClientRect();
                const all = document.scrollingElement;
                places.push([link.hash, heading.top - (innerWidth < 1100 ? bar.bottom : 0),
                    all.scrollTop + innerHeight >= all.scrollHeight - 2]);
            }
            return places;
        }"""
    )

    assert page.evaluate("getComputedStyle(document.documentElement).scrollBehavior") == "auto"
    assert len(landed) > 10
    assert [place for place in landed if not (-1 <= place[1] < 60 or place[2])] == []


@pytest.mark.slow
def test_no_panel_of_the_front_is_off_a_phones_screen(new_tab, benchmark_page: Path):
    """No panel of the front leaves a phone's screen.

    The figures are whole, and their letters can be read.
    """
    page = new_tab(viewport=PHONE)
    page.goto(benchmark_page.as_uri())
    page.wait_for_function("window.explorer")
    figures = page.evaluate(
        """[...document.querySelectorAll("main > section > .blocks figure.wide svg")]
            .filter((svg) => svg.checkVisibility()).map((svg) => {
                const letters = [...svg.querySelectorAll("text")].filter(
                    (text) => text.textContent.trim()).map(
                    (text) => text.getBoundingClientRect().height);
                return [svg.getBoundingClientRect().right, Math.min(...letters)];
            })"""
    )

    assert len(figures) == 2
    for right, letter in figures:
        assert right <= PHONE["width"]
        assert letter >= 7


@pytest.mark.slow
def test_the_front_prints_on_few_sheets(new_tab, benchmark_page: Path):
    """Folded parts stay folded on paper."""
    page = new_tab()
    page.goto(benchmark_page.as_uri())
    page.wait_for_function("window.explorer")
    sheets = page.pdf(format="A4")
    page.emulate_media(media="print")

    assert len(re.findall(rb"/Type\s*/Page[^s]", sheets)) <= 12
    assert not page.locator("#summary table").first.is_visible()
    assert not page.locator("#belief details.more figure").first.is_visible()


@pytest.mark.slow
@pytest.mark.parametrize("anchor", ["limits", "attempts", "widget-worst", "glossary"])
def test_a_link_arrives_when_the_page_is_opened(new_tab, report_page: Path, anchor: str):
    """A link arrives when the page is opened.

    Sections above get their heights, and scripts fill them, after the browser's own jump.
    """
    page = new_tab()
    page.goto(f"{report_page.as_uri()}#{anchor}")
    page.wait_for_function(
        """(anchor) => {
            const top = document.getElementById(anchor).getBoundingClientRect().top;
            const all = document.scrollingElement;
            const end = all.scrollTop + window.innerHeight >= all.scrollHeight - 2;
            return Math.abs(top) < 120 || end;
        }""",
        arg=anchor,
        timeout=10_000,
    )
