"""README's table is the page's, counted from the committed benchmark."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.decision import decision_section

ROOT = Path(__file__).parents[2]
# Columns of the page's table that README shows.
SHOWN = ("method", "knows", "suite_0", "suite_1", "suite_2", "false_claims", "stops")


def table_lines() -> list[str]:
    """All lines of the page's table as README writes them."""
    frame = decision_section(load([ROOT / "results" / "benchmark"])).blocks[1].frame
    texts = frame.reindex(columns=SHOWN).fillna("–").astype(str)
    for suite in ("suite_0", "suite_1", "suite_2"):
        asked = frame[f"{suite}_solver"].notna()
        share = texts[suite].str.partition("\n")[2]
        texts[suite] = ("`" + frame[f"{suite}_solver"] + "` " + share).where(asked, "–")
    cells = texts.map(lambda text: " ".join(text.replace("\n", " ").split()))
    return [f"| {' | '.join(line)} |" for line in cells.itertuples(index=False)]


@pytest.mark.slow
def test_the_table_is_that_of_the_committed_rows():
    """Run `python -m tests.docs.test_readme` to print the lines, of which README shows five."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = re.search(r"\| formulation.*?\n\n", text, re.S)[0].strip().split("\n")[2:]

    assert len(shown) == 5
    assert [line for line in shown if line not in table_lines()] == []


if __name__ == "__main__":
    print("\n".join(table_lines()))
