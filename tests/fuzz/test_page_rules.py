"""The judge of pages forbids and allows rightly.

It sees what a page must not hold, and lets pass what our templates write.
"""

from html import escape

import pytest

from tests.fuzz.hostile import HOSTILE, MARK
from tests.fuzz.page import odd_parts

# those that are markup where they are not escaped
MARKUP = [text for text in HOSTILE if MARK in text and "<" in text]


@pytest.mark.smoke
@pytest.mark.parametrize("text", MARKUP)
def test_markup_is_seen_and_its_text_is_not(text):
    assert odd_parts(f"<p>{text}</p>")
    assert not odd_parts(f"<p title='{escape(text)}'>{escape(text)}</p>")


RUNS_OR_LOADS = (
    *(f"<button title='' onmouseover='{MARK}()'>", "<p onclick='f()'>", "<form onsubmit='f()'>"),
    *("<a href='javascript:f()'>", "<a href='https://other.example'>"),
    *("<a href='tables/../../x.csv'>", "<img src='x.png'>", "<img src='data:text/html,x'>"),
    *("<script src='x.js'></script>", f"<script>let name = '{MARK}';</script>"),
    *(
        f"<div style='color: {MARK}'>",
        f"<script type='application/json'>{{}}</script><b>{MARK}</b>",
    ),
    f"<script type='text/plain'></script><script>{MARK}</script>",
)
WRITTEN_BY_TEMPLATES = (
    *("<form onsubmit='return false'>", "<a href='tables/times.csv'>", "<a href='#times'>"),
    *(f"<script type='application/json'>\"{MARK}\"</script>", "<script>const ours = 1;</script>"),
)


@pytest.mark.smoke
def test_what_runs_or_loads_is_seen():
    assert [html for html in RUNS_OR_LOADS if not odd_parts(html)] == []
    assert [html for html in WRITTEN_BY_TEMPLATES if odd_parts(html)] == []
