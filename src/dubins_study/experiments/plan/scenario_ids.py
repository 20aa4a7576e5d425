"""Ids of scenarios: the same on every machine for numbers and labels that are bitwise equal."""

from __future__ import annotations

import hashlib
import struct

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


def _utf8(label: str) -> bytes:
    return label.encode("utf-8", "replace")  # a lone surrogate cannot be encoded
