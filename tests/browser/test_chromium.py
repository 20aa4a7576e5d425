"""The browser itself: it opens a file, runs its script, and the fixture sees errors."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser_tab import Tab


def test_a_file_is_opened_and_its_script_runs(new_tab, tmp_path: Path):
    """Pages are opened from disk, as a reader does, with scripts."""
    file = tmp_path / "page.html"
    file.write_text("<p id=a>1</p><script>a.textContent = String(1 + 1)</script>")
    page = new_tab()
    page.goto(file.as_uri())

    assert page.text_content("#a") == "2"


def test_an_error_on_the_page_fails_its_test(chromium, tmp_path: Path):
    """A page that logs an error, asks for something remote or opens a dialog fails its test."""
    file = tmp_path / "page.html"
    file.write_text("<script>throw new Error('wrong')</script><script>alert('run')</script>")
    tab = Tab(chromium)
    tab.page.goto(file.as_uri())

    with pytest.raises(AssertionError, match="wrong"):
        tab.close()
