"""The dictionary of a report's tables: what every column of their CSV files is."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.content import Section, Table

_SHOWN = (
    Column("file", "table", kind="code"),
    Column("column", "column", kind="code"),
    Column("heading", "heading on the page", kind="text"),
    Column("section", "section", kind="text"),
)
# What the ends of a key say of a column that the page shows as part of another one.
_ENDS = {
    "_low": "lower end of the 95 % interval",
    "_high": "upper end of the 95 % interval",
    "_share": "as a share of 1",
    "_of": "number of questions",
    "_s": "seconds",
}


def dictionary(sections: Iterable[Section]) -> Table:
    """One line for every column of every CSV file, in the order of the page."""
    lines = [
        {"file": block.name, "column": key, "heading": heading, "section": section.title}
        for section in sections
        for block in section.blocks
        if isinstance(block, Table)
        for key, heading in _headings(block).items()
    ]
    frame = pd.DataFrame(lines, columns=["file", "column", "heading", "section"])
    return Table("dictionary", "The columns of the tables.", frame, _SHOWN)


def _headings(table: Table) -> dict[str, str]:
    shown = {column.key: " ".join(column.title.split()) for column in table.columns}
    hidden = [key for key in table.numbers if key not in shown]
    return shown | {key: _meaning(key) for key in hidden}


def _meaning(key: str) -> str:
    """The end of a key in words; the page shows no heading of such a column."""
    return next((text for end, text in _ENDS.items() if key.endswith(end)), "")
