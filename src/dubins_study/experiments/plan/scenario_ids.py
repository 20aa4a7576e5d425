"""Ids of scenarios: the same on every machine for numbers and labels that are bitwise equal."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import NUMBERS, Scenario

_ID_DIGITS = 16
_PACKED_NUMBERS = struct.Struct(f"<{len(NUMBERS)}d")


def scenario_id(scenario: Scenario) -> str:
    """The id of a scenario: 16 hexadecimal digits.

    They are the first digits of the SHA-256 of the fields of `NUMBERS` as little-endian doubles,
    followed by the label in UTF-8.
    """
    packed = _PACKED_NUMBERS.pack(*(getattr(scenario, name) for name in NUMBERS))
    return hashlib.sha256(packed + _utf8(scenario.label)).hexdigest()[:_ID_DIGITS]


def scenario_ids(columns: Mapping[str, FloatArray], label: str) -> pa.StringArray:
    """The ids of many scenarios with one label, equal to those of `scenario_id`.

    Args:
        columns: the fields of `NUMBERS`, arrays of shape (n,).
        label: the label of all scenarios.
    """
    n = len(columns["x"])
    packed = np.stack([columns[name] for name in NUMBERS], axis=1).astype("<f8").tobytes()
    suffix, sha256, row_bytes = _utf8(label), hashlib.sha256, _PACKED_NUMBERS.size
    digests = [
        sha256(packed[i : i + row_bytes] + suffix).digest()[: _ID_DIGITS // 2]
        for i in range(0, len(packed), row_bytes)
    ]
    offsets: Any = np.arange(0, _ID_DIGITS * n + 1, _ID_DIGITS, dtype=np.int32)
    text = b"".join(digests).hex().encode()
    return pa.StringArray.from_buffers(n, pa.py_buffer(offsets), pa.py_buffer(text))


def _utf8(label: str) -> bytes:
    return label.encode("utf-8", "replace")  # a lone surrogate cannot be encoded
