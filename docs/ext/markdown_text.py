"""Markdown of any text.

It makes tables, inline code, and prose from docstrings.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

# what Markdown would take for markup, outside of inline code
_MARKUP = re.compile(r"([*_<>\[\]$~#])")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table of cells that are Markdown already."""
    lines = [_line(head), "|" + "---|" * len(head)]
    return "\n".join([*lines, *(_line(row) for row in rows)])


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in cells) + " |"


def code(text: object) -> str:
    """Inline code; a dash for an empty text."""
    return f"`{text}`" if str(text) else "–"


def prose(text: str) -> str:
    """A docstring's text as Markdown.

    Its inline code stays; nothing else is markup.
    """
    parts = " ".join(text.split()).split("`")
    parts[::2] = [_MARKUP.sub(r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)
