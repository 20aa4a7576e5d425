"""Texts from outside with nothing in them that a terminal, or XML, would obey."""

from __future__ import annotations


def plain(text: str, kept: str = "") -> str:
    """The text with what cannot be printed written out as Python does, but for the letters kept."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in kept else repr(c)[1:-1] for c in text)
