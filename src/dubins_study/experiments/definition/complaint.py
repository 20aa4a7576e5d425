"""What is wrong with an experiment, in one sentence of our own words instead of pydantic's."""

from __future__ import annotations

import re
from typing import Any

from pydantic import ValidationError

_WHOLE, _NUMBER, _TEXT = "expected a whole number", "expected a number", "expected a text"
_EXPECTED = {
    "too_short": "expected at least one",
    "string_too_short": "expected a text that is not empty",
    "list_type": "expected a list",
    "tuple_type": "expected a list",
    "string_type": _TEXT,
    "model_type": "expected a table",
    "dict_type": "expected a table",
    "int_type": _WHOLE,
    "int_parsing": _WHOLE,
    "int_parsing_size": _WHOLE,
    "int_from_float": _WHOLE,
    "float_type": _NUMBER,
    "float_parsing": _NUMBER,
    "finite_number": "expected a finite number",
    "greater_than": "expected a number above {gt}",
    "greater_than_equal": "expected a number of at least {ge}",
    "less_than": "expected a number below {lt}",
    "less_than_equal": "expected a number of at most {le}",
    "literal_error": "expected {expected}",
}
_BARE = re.compile(r"[A-Za-z0-9_-]{1,80}")
_LONGEST = 80  # characters of what is quoted
_AXIS = (
    "expected a number, a list of numbers, { linear = [first, last, count] } "
    "or { log = [first, last, count] }"
)
_RANGE = "expected { linear = [low, high] } or { log = [low, high] }"


def complaint(error: ValidationError) -> str:
    """The first thing that is wrong: key, value, and what was expected."""
    # Of a union's complaints, one about a value or else the deepest is about the variant meant.
    first = max(
        error.errors(),
        key=lambda e: (e["type"] in ("value_error", "too_short"), len(e["loc"])),
    )
    kind, place = first["type"], first["loc"]
    variants = [i for i, part in enumerate(place) if _is_variant(part)]
    if variants:
        known = _variant(kind, place, variants[0], first["input"])
        if known is not None:
            return known
    key = _key(place) or "the file"
    if kind == "missing":
        return f"{key}: missing"
    if kind == "extra_forbidden":
        return f"{key}: unknown key"
    said = first["msg"].removeprefix("Value error, ")
    if kind in _EXPECTED:
        said = _EXPECTED[kind].format(**first.get("ctx", {}))
    return f"{key}{_shown(first['input'])}: {said:.{4 * _LONGEST}}"


def _variant(kind: str, place: tuple[Any, ...], variant: int, value: object) -> str | None:
    """Complaints about a value that may be written in several ways, and fits none of them."""
    after = place[variant + 1 :]
    ways, items = _AXIS, "[first, last, count]"
    if "Range" in str(place[variant]):
        ways, items = _RANGE, "[low, high]"
    if kind in ("tuple_type", "too_long") or (kind == "missing" and len(after) == 2):
        return f"{_key((*place[:variant], *after[:1]))}{_shown(value)}: expected {items}"
    if kind in ("missing", "extra_forbidden") or (not after and kind.endswith("_type")):
        shown = "" if after else _shown(value)
        return f"{_key(place[:variant])}{shown}: {ways}"
    return None


def _key(place: tuple[Any, ...]) -> str:
    return ".".join(_step(part) for part in place if not _is_variant(part))


def _step(part: object) -> str:
    """A key as a file would write it: whoever wrote this one may have put anything into it."""
    text = str(part)
    return text if _BARE.fullmatch(text) else f"{text[:_LONGEST]!r}"


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return ""
    try:
        return f" is {value!r:.{_LONGEST}}"
    except ValueError:  # Python does not write integers of thousands of digits
        return " holds an integer of thousands of digits"


def _is_variant(part: object) -> bool:
    """Whether a step of an error's location names a variant of a union and not a key."""
    return isinstance(part, str) and (part[:1].isupper() or "[" in part or part == "float")
