"""Names for scenarios that depend on their numbers to the last bit, and on their label."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import NUMBERS, Scenario

_DIGITS = 16
_PACKED = struct.Struct(f"<{len(NUMBERS)}d")


def scenario_id(scenario: Scenario) -> str:
    """SHA-256 of x, y, ..., speed as little-endian doubles and the label's UTF-8: 16 hex digits."""
    packed = _PACKED.pack(*(getattr(scenario, name) for name in NUMBERS))
    return hashlib.sha256(packed + _utf8(scenario.label)).hexdigest()[:_DIGITS]


def scenario_ids(columns: Mapping[str, FloatArray], label: str) -> pa.StringArray:
    """The same of many scenarios with one label.

    Args:
        columns: the fields of `NUMBERS`, arrays of shape (n,).
        label: of all of them.
    """
    n = len(columns["x"])
    packed = np.stack([columns[name] for name in NUMBERS], axis=1).astype("<f8").tobytes()
    suffix, sha256, width = _utf8(label), hashlib.sha256, _PACKED.size
    digests = [
        sha256(packed[i : i + width] + suffix).digest()[: _DIGITS // 2]
        for i in range(0, len(packed), width)
    ]
    offsets = np.arange(0, _DIGITS * n + 1, _DIGITS, dtype=np.int32)
    text = b"".join(digests).hex().encode()
    return pa.StringArray.from_buffers(n, pa.py_buffer(offsets), pa.py_buffer(text))


def _utf8(label: str) -> bytes:
    return label.encode("utf-8", "replace")  # a lone surrogate has none


def marks(columns: Mapping[str, FloatArray]) -> NDArray[np.uint64]:
    """Numbers that are equal where scenarios are, and else hardly ever; far quicker than names.

    Args:
        columns: the fields of `NUMBERS`, arrays of shape (n,).
    """
    mixed = np.zeros(len(columns["x"]), np.uint64)
    for name in NUMBERS:
        mixed ^= np.ascontiguousarray(columns[name], np.float64).view(np.uint64)
        mixed *= np.uint64(0x9E3779B97F4A7C15)
        mixed ^= mixed >> np.uint64(31)
    return mixed
