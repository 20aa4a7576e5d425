"""Texts of strangers' folders before anything is made of them: nothing in them is obeyed.

Escaping for HTML, Markdown or TeX is the templates' part. Control characters mean something to
terminals, XML and TeX alike and nothing to a reader, so they are written out here, once.
"""

from __future__ import annotations

from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.study.printable import plain

# honest manifests are a few levels deep, and what writes values out goes down level by level
_DEEPEST = 20


def visible(text: str) -> str:
    """The text with what cannot be printed written out; line breaks and tabs stay."""
    return plain(text, "\n\t")


def visible_values(value: Any, depth: int = 0) -> Any:
    """The same for all texts and keys of what JSON holds.

    Raises:
        ValueError: if it is nested too deeply.
    """
    if depth > _DEEPEST:
        raise ValueError(f"nested more than {_DEEPEST} levels deep")
    if isinstance(value, str):
        return visible(value)
    if isinstance(value, list):
        return [visible_values(item, depth + 1) for item in value]
    if isinstance(value, dict):
        return {visible(key): visible_values(item, depth + 1) for key, item in value.items()}
    return value


def visible_column(column: pa.Array) -> pa.Array:
    """The same for a column of texts, be it a dictionary."""
    if pa.types.is_dictionary(column.type):
        shown = visible_column(column.dictionary)
        if shown is column.dictionary:
            return column
        return pa.DictionaryArray.from_arrays(column.indices, shown)
    if pc.all(pc.utf8_is_printable(column)).as_py() is not False:
        return column
    texts = [None if text is None else visible(text) for text in column.to_pylist()]
    return pa.array(texts, column.type)
