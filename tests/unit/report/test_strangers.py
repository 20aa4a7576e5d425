"""What strangers' folders hold is shown as text, or refused before numbers are made of it."""

from __future__ import annotations

from dubins_study import render
from dubins_study.study.values import printable_text as visible
from tests.unit.report.results_folder import attempt, paper_scenarios

ESCAPES = "\x1b[31m\x07\x9b\u202e\ud800"


def test_what_cannot_be_printed_is_written_out():
    assert visible(ESCAPES) == "\\x1b[31m\\x07\\x9b\\u202e\\ud800"
    assert visible("a\n\tπ ≤ 2") == "a\n\tπ ≤ 2"


def test_no_control_character_reaches_a_page(results, tmp_path):
    """In the manifest halves of pairs too, which no file can hold."""
    experiment = {"name": "x" + ESCAPES, "title": ESCAPES, "question": ESCAPES, "text": "a\n\x1b"}
    said = ESCAPES.replace("\ud800", "")
    rows = [attempt(s, "s" + said, message=said, path=None) for s in paper_scenarios()]
    folder = results("f", rows, experiment=experiment, machine={ESCAPES: [ESCAPES]})

    page = render([folder], tmp_path / "out")

    for file in (page, page.parent / "report.md", page.parent / "tables" / "summary.tex"):
        text = file.read_text(encoding="utf-8")
        assert "\\x1b" in text or "textbackslash{}x1b" in text
        assert not {c for c in text if not c.isprintable()} & set(ESCAPES)
