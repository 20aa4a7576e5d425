"""Values from outside, as numbers and in messages.

A misspelt name is answered with the nearest known name. Control characters mean something to
terminals, XML and TeX and nothing to a reader, so they are written out here. Escaping for HTML,
Markdown or TeX is up to the templates of the report.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from dubins_study.study.arrays import FloatArray

# `float` accepts these, or loses a part of them. Only on the command line a text is a number.
_NO_NUMBERS = (
    *(str, bytes, bytearray, memoryview, bool, complex),
    *(np.bool_, np.complexfloating, np.timedelta64, np.datetime64, np.ndarray),
)


def real_number(value: Any) -> float:
    """Value as a float.

    It may be an int, float, Fraction or Decimal, one of NumPy's numbers, or the like.

    Raises:
        TypeError: of a boolean, complex, text, bytes, duration, date or array. `float` may raise
            others, such as an OverflowError for an integer of 400 digits.
    """
    if type(value) is float:  # as nearly all are
        return value
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, _NO_NUMBERS):
        raise TypeError
    return float(value)


def number_of_text(text: str) -> float:
    """Number that a text states.

    `1_000`, which Python's `float` takes, is a ValueError.
    """
    return float(text.replace("_", "?"))


def doubles(name: str, values: Any) -> FloatArray:
    """Numbers as an array of native doubles.

    Masked numbers are NaN. Anything but numbers is a TypeError with the array's name.
    """
    if type(values) is np.ndarray and values.dtype == np.float64 and values.dtype.isnative:
        return values
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    array = np.asarray(values)
    if array.dtype == object:
        return np.array([_item(name, value) for value in array.flat]).reshape(array.shape)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} is an array of {array.dtype}; expected numbers, such as float64")
    with np.errstate(over="ignore"):
        return array.astype(np.float64, copy=False)


def _item(name: str, value: Any) -> float:
    try:
        return real_number(value)
    except Exception:
        raise TypeError(f"{name} holds {short(value)}; expected a number") from None


def real_array(name: str, values: Any, shape: tuple[int, ...]) -> FloatArray:
    """Array of `doubles` with a given shape.

    A TypeError names the array, its shape and the expected shape.
    """
    array = doubles(name, values)
    if array.shape != shape:
        raise TypeError(f"{name} has shape {array.shape}; expected {shape}")
    return array


def plain(text: str, kept: str = "") -> str:
    """Text on one line, without unprintable characters.

    Each of these is replaced by its escape in Python's notation. Those in `kept` stay.
    """
    if text.isprintable():
        return text
    for character in set(text):
        if not character.isprintable() and character not in kept:
            text = text.replace(character, repr(character)[1:-1])
    return text


def unwritable(file: Path) -> str | None:
    """Reason why a file cannot be written.

    None if it can. To find out, a file that does not exist is made and removed.
    """
    try:
        if file.is_dir():
            return os.strerror(errno.EISDIR)
        if file.exists():
            if not os.access(file, os.W_OK):
                return os.strerror(errno.EACCES)
        elif not file.is_symlink():  # a link to a file that is not there stays as it is
            file.touch()
            file.unlink()
    except OSError as error:
        return error.strerror
    return None


_SHORT = 60  # characters


def short(value: Any) -> str:
    """The value's repr, shortened to fit a message."""
    try:
        text = repr(value)
    except Exception:  # an integer of more than 4300 digits, or a class of a plug-in
        return f"a value of type {type(value).__name__}"
    if len(text) <= _SHORT:
        return text
    return f"{text[: _SHORT - 3]}..."


def printable_text(text: str) -> str:
    """Text with unprintable characters written out.

    Line breaks and tabs stay.
    """
    return plain(text, "\n\t")


def printable_values(value: Any) -> Any:
    """JSON value with all texts made printable.

    Keys are made printable too.
    """
    if isinstance(value, str):
        return printable_text(value)
    if isinstance(value, list):
        return [printable_values(item) for item in value]
    if isinstance(value, dict):
        return {printable_text(key): printable_values(item) for key, item in value.items()}
    return value


_LEAST_ALIKE = 0.65  # difflib's ratio: twice the letters in common, over all letters of both
_MAX_CHARS = 80  # of a name; a longer one is no misspelling


def nearest(name: object, known: Iterable[str]) -> str | None:
    """Known name that is most like a name.

    Upper and lower case count as equal. None if no known name is similar.
    """
    if not isinstance(name, str) or not 0 < len(name) <= _MAX_CHARS:
        return None
    from difflib import get_close_matches  # only a refusal needs it

    by_folded: dict[str, str] = {}
    for candidate in known:
        by_folded.setdefault(candidate.casefold(), candidate)
    matches = get_close_matches(name.casefold(), by_folded, n=1, cutoff=_LEAST_ALIKE)
    if not matches:
        return None
    return by_folded[matches[0]]


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Hint such as `did you mean 'ipopt'? `.

    It is empty if no name is near. It ends with a space, since a list of all names follows it.
    """
    match = nearest(name, known)
    if match is None:
        return ""
    return f"did you mean {match!r}? "
