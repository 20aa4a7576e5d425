"""README's table of choices is the page's, counted from the committed benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.decision import decision_section

ROOT = Path(__file__).parents[2]
# Columns of the page's table that README shows.
SHOWN = ("where", "loose", "tight", "loose_proof")


def table_lines() -> list[str]:
    """The rows of README's table, as the committed rows have it."""
    section = decision_section(load([ROOT / "results" / "benchmark"]))
    table = section.blocks[0]
    texts = table.frame[list(SHOWN)].map(lambda text: " ".join(text.replace("\n", ": ").split()))
    return [f"| {' | '.join(line)} |" for line in texts.itertuples(index=False)]


@pytest.mark.slow
def test_the_table_of_choices_is_that_of_the_committed_rows():
    """Run `python -m tests.docs.test_readme` to print the lines that belong there."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")

    assert [line for line in table_lines() if line not in text] == []


if __name__ == "__main__":
    print("\n".join(table_lines()))
