"""A table as CSV and Markdown; all text from outside is escaped here."""

from __future__ import annotations

import re

from dubins_study.report.elements.content import Table

# Markdown's special characters: anywhere, at the start of a line, and after a list's number.
_MARKDOWN = re.compile(r"([\\`*_\[\]|~$]|^[#+=-]|(?<=^\d)[.)](?=\s))")

_RIGHT = ("number", "cell")  # kinds of columns that are aligned right

_FORMULA = tuple("=+-@\t")  # a spreadsheet reads text that starts with one of these as a formula


def markdown(text: str) -> str:
    """Escape text so that Markdown, and HTML made from it, show it unchanged."""
    plain = _one_line(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _MARKDOWN.sub(r"\\\1", plain)


def _one_line(text: str) -> str:
    return " ".join(text.split("\n")).replace("\r", " ")


def to_csv(table: Table) -> str:
    """The shown columns and those of `Table.numbers`: full digits, missing values empty.

    A text that a spreadsheet would read as a formula gets a leading apostrophe.
    """
    keys = dict.fromkeys([*(column.key for column in table.columns), *table.numbers])
    shown = table.frame[list(keys)].copy()
    for column in table.columns:
        if column.kind != "number":
            shown[column.key] = shown[column.key].map(_no_formula)
    return str(shown.to_csv(index=False, lineterminator="\n"))


def _no_formula(value: object) -> object:
    return f"'{value}" if isinstance(value, str) and value[:1] in _FORMULA else value


def to_markdown(table: Table) -> str:
    """A pipe table; numbers are aligned right."""
    rule = ["---:" if column.kind in _RIGHT else "---" for column in table.columns]
    rows = [[markdown(column.title) for column in table.columns], rule]
    rows += [[markdown(text) for text in row] for row in table.texts()]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)
