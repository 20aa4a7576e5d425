"""Tables that sort, filter and fold.

They are used by pointer, by keyboard, on a phone, and without scripts.
"""

from html import escape
from pathlib import Path as FilePath

import pytest

from dubins_study.report.page.environment import SCRIPTS, scripts, styles

VARIANTS = ["n=160", "n=10", "n=1000", "n=20", "tol=1e-8", "tol=1e-6", "", "n=20, b"]
HOSTILE = "<img src=x onerror=alert(1)></script>"


def table(lines: int) -> str:
    """Lines of a table.

    A line has a name, a number that its text hides, and one that is missing in every third line.
    """
    rows = ""
    for n in range(lines):
        value = (n * 37) % lines / 1000
        gap = (
            "<td class='number'>–</td>"
            if n % 3 == 0
            else (f"<td class='number' data-value='{value}'>{value * 1e3:.0f} ms</td>")
        )
        name = escape(f"{VARIANTS[n % len(VARIANTS)]} {HOSTILE if n == 5 else ''}".strip())
        count = f"<td class='number' data-value='{n}'>{n}</td>"
        rows += f"<tr><td title='Full{n}x'>{name}</td>{count}{gap}</tr>"
    heads = "".join(f"<th scope='col'>{title}</th>" for title in ("variant", "count", "gap"))
    return (
        f"<figure class='table'><div class='scroll tall'><table><thead><tr>{heads}</tr></thead>"
        f"<tbody>{rows}</tbody></table></div></figure>"
    )


@pytest.fixture
def page_of(new_tab, tmp_path: FilePath):
    """`page_of(lines, **options)`: a page with one table.

    It has the report's style and scripts.
    """

    def opened(lines: int, **options):
        code = dict(zip(SCRIPTS, scripts(), strict=True))["tables"]
        file = tmp_path / "tables.html"
        head = "<!doctype html><html lang='en'><meta charset='utf-8'>"
        head += "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        style = f"<style>{styles()}</style>"
        body = f"<main><div class='blocks'>{table(lines)}</div></main>"
        file.write_text(f"{head}{style}{body}<script>{code}</script>", encoding="utf-8")
        page = new_tab(**options)
        page.goto(file.as_uri())
        return page

    return opened


def column(page, place: int) -> list[str]:
    """Visible texts of a column's cells."""
    return page.locator(f"tbody tr:visible td:nth-child({place})").all_text_contents()


def header(page, name: str):
    return page.get_by_role("columnheader", name=name)


def test_text_is_sorted_with_its_numbers_as_numbers(page_of):
    """Numbers in text are sorted as numbers.

    10, 20, 160, 1000; 1e-8 before 1e-6; nothing comes last; a third click restores the order.
    """
    page = page_of(len(VARIANTS))
    before = column(page, 1)
    assert header(page, "variant").get_attribute("aria-sort") == "none"

    page.get_by_role("button", name="variant").click()
    assert header(page, "variant").get_attribute("aria-sort") == "ascending"
    ascending = [
        "n=10",
        "n=20",
        "n=20, b",
        "n=160",
        "n=1000",
        "tol=1e-8",
        f"tol=1e-6 {HOSTILE}",
        "",
    ]
    assert column(page, 1) == ascending

    page.get_by_role("button", name="variant").click()
    assert header(page, "variant").get_attribute("aria-sort") == "descending"
    assert column(page, 1) == [*reversed(ascending[:-1]), ""]

    page.get_by_role("button", name="variant").click()
    assert header(page, "variant").get_attribute("aria-sort") == "none"
    assert column(page, 1) == before


def test_numbers_are_sorted_by_their_values_by_keyboard(page_of):
    """Keys sort numbers by their values.

    They are Enter and Space. One column is sorted at a time; cells without a number come last in
    both orders.
    """
    page = page_of(40)
    values = [(n * 37) % 40 for n in range(40) if n % 3]
    absent = 40 - len(values)
    page.get_by_role("button", name="gap").focus()

    page.keyboard.press("Enter")
    assert column(page, 3) == [f"{v} ms" for v in sorted(values)] + ["–"] * absent

    page.keyboard.press("Space")
    assert column(page, 3) == [f"{v} ms" for v in sorted(values, reverse=True)] + ["–"] * absent

    page.get_by_role("button", name="count").click()
    assert column(page, 2) == [f"{n}" for n in range(40)]
    assert header(page, "gap").get_attribute("aria-sort") == "none"


def test_a_cell_that_begins_with_no_number_is_below_those_that_do(page_of):
    """Cells without a leading number come below.

    They are reasons in brackets, `none` and dashes, whichever way the numbers go.
    """
    page = page_of(8)
    texts = ["[2]", "90.4 %\n87.0–92.9", "none\n(3 to 4)", "100 %\n99.0–100"]
    texts += ["[11]", "–", "8.5 %", ""]
    page.evaluate(
        """texts => [...document.querySelectorAll("tbody tr")].forEach((line, n) => {
            line.cells[0].className = "cell";
            line.cells[0].textContent = texts[n];
        })""",
        texts,
    )
    ascending = [texts[6], texts[1], texts[3]]
    rest = [text for text in texts if text not in ascending]

    page.get_by_role("button", name="variant").click()
    assert column(page, 1) == ascending + rest
    page.get_by_role("button", name="variant").click()
    assert column(page, 1) == ascending[::-1] + rest


def test_a_heading_without_text_is_no_button(page_of):
    """A heading without text is no button.

    A button without a name says nothing to those who only hear it. Up to twelve lines have no
    filter.
    """
    page = page_of(12)
    assert page.get_by_role("searchbox").count() == 0
    page.evaluate("""() => {
      const table = document.querySelector("table").cloneNode(true);
      delete table.dataset.enhanced;
      table.tHead.rows[0].cells[0].replaceChildren();
      document.querySelector(".scroll").replaceChildren(table);
      studyTables.enhance(table);
    }""")

    assert page.locator("th").nth(0).locator("button").count() == 0
    assert page.locator("th").nth(1).locator("button").count() >= 1


def test_a_filter_shows_the_lines_with_all_of_its_words(page_of):
    """A filter shows the lines with all words.

    Case does not matter, and full names count too. It says how many of how many, and keeps the
    sorting.
    """
    page = page_of(40)
    box = page.get_by_role("searchbox", name="filter")
    count = page.get_by_role("status")
    assert count.text_content() == "40 lines"

    box.fill("N=20 b")
    assert set(column(page, 1)) == {"n=20, b"}
    assert count.text_content() == "5 of 40"

    page.get_by_role("button", name="count").click()
    page.get_by_role("button", name="count").click()
    assert column(page, 2) == ["39", "31", "23", "15", "7"]

    box.fill("FULL17X")
    assert column(page, 2) == ["17"]

    box.fill("no such words")
    assert column(page, 1) == []
    assert count.text_content() == "0 of 40"

    box.fill("")
    assert len(column(page, 1)) == 40


def test_a_long_table_is_folded(page_of):
    """A long table is folded to twelve lines.

    That holds in any order; one button shows the rest and folds them again.
    """
    page = page_of(160)
    count = page.get_by_role("status")
    fold = page.get_by_role("button", name="show")
    assert len(column(page, 1)) == 12
    assert count.text_content() == "160 lines, the first 12 shown"
    assert (fold.text_content(), fold.get_attribute("aria-expanded")) == ("show all 160", "false")

    for _ in range(2):
        page.get_by_role("button", name="count").click()
    assert column(page, 2)[0] == "159"

    fold.press("Enter")
    assert len(column(page, 1)) == 160
    assert (fold.text_content(), fold.get_attribute("aria-expanded")) == ("show fewer", "true")
    fold.click()
    assert len(column(page, 1)) == 12

    page.get_by_role("searchbox", name="filter").fill("FULL17X")
    assert len(column(page, 1)) == 1
    assert count.text_content() == "1 of 160"
    assert not fold.is_visible()


def test_tables_of_a_report_are_sorted(new_tab, report_page: FilePath):
    """Tables of a report are sorted.

    Every table of the page has its buttons, and cells of text from outside stay text.
    """
    page = new_tab()
    page.goto(report_page.as_uri())
    tables = page.locator("figure.table table")

    assert tables.count() >= 10
    heads = page.locator("figure.table thead tr:first-child th")
    assert heads.count() == page.locator("figure.table th > button.sort").count()
    page.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
    head = page.locator("figure.table").first.locator("th:has(button.sort)").last
    for order in ("ascending", "descending", "none"):
        head.locator("button.sort").click()
        assert head.get_attribute("aria-sort") == order
