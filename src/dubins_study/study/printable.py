"""Texts from outside with nothing in them that a terminal, XML or TeX would obey.

Escaping for HTML, Markdown or TeX is up to the templates of the report. Control characters mean
something to terminals, XML and TeX and nothing to a reader, so they are written out here.
"""

from __future__ import annotations

from typing import Any


def plain(text: str, kept: str = "") -> str:
    """The text on one line: what cannot be printed is written out as Python does.

    Args:
        text: from outside.
        kept: characters that stay as they are.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in kept else repr(c)[1:-1] for c in text)


def short(value: Any) -> str:
    """The value's repr, shortened to what fits into a message."""
    try:
        text = repr(value)
    except Exception:  # an integer of more than 4300 digits, or a class of a plug-in
        return f"a value of type {type(value).__name__}"
    return text if len(text) <= _SHORT else f"{text[: _SHORT - 3]}..."


_SHORT = 60  # characters


def printable_text(text: str) -> str:
    """The text with what cannot be printed written out; line breaks and tabs stay."""
    return plain(text, "\n\t")


def printable_values(value: Any) -> Any:
    """A value of JSON with all its texts and keys made printable."""
    if isinstance(value, str):
        return printable_text(value)
    if isinstance(value, list):
        return [printable_values(item) for item in value]
    if isinstance(value, dict):
        return {printable_text(key): printable_values(item) for key, item in value.items()}
    return value
