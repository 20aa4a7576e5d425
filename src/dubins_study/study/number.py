"""A caller's value as a real number: the same values are taken wherever one is expected."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.printable import short

# `float` takes these, or loses a part of them; a text is a number on the command line alone
_NO_NUMBERS = (
    *(str, bytes, bytearray, memoryview, bool, complex),
    *(np.bool_, np.complexfloating, np.timedelta64, np.datetime64, np.ndarray),
)


def real_number(value: Any) -> float:
    """The value as a float: an int, float, Fraction or Decimal, one of numpy's, or the like.

    Raises:
        TypeError: if it is a boolean, complex, a text, bytes, a duration, a date or an array.
        Exception: whatever `float` raises, such as OverflowError for an integer of 400 digits.
    """
    if type(value) is float:  # as nearly all are
        return value
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, _NO_NUMBERS):
        raise TypeError
    return float(value)


def doubles(name: str, values: Any) -> NDArray[np.float64]:
    """Numbers as an array of doubles of this machine; what is masked is NaN.

    Raises:
        TypeError: naming the array, a value or its type, and what was expected.
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


def real_array(name: str, values: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """`doubles` of a given shape.

    Raises:
        TypeError: naming the array, its shape or type, and what was expected.
    """
    array = doubles(name, values)
    if array.shape != shape:
        raise TypeError(f"{name} has shape {array.shape}; expected {shape}")
    return array
