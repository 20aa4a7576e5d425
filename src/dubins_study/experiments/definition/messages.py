"""One sentence about what is wrong with an experiment, instead of pydantic's list of errors."""

from __future__ import annotations

import re
from typing import Any

from pydantic import ValidationError

_WHOLE, _NUMBER, _TEXT = "expected a whole number", "expected a number", "expected a text"
# pydantic's type of error -> the end of our sentence.
_EXPECTED = {
    "too_short": "expected at least one",
    "string_too_short": "expected a text that is not empty",
    "too_long": "expected at most {max_length}",
    "string_too_long": "expected a text of at most {max_length} characters",
    "string_pattern_mismatch": "expected a name of small letters, digits and hyphens",
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
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]{1,80}")
_MAX_QUOTED_CHARS = 80
_MAX_MESSAGE_CHARS = 320
_AXIS = (
    "expected a number, a list of numbers, { linear = [first, last, count] } "
    "or { log = [first, last, count] }"
)
_RANGE = "expected { linear = [low, high] } or { log = [low, high] }"


def first_error(error: ValidationError) -> str:
    """The key, its value and what was expected, for one of the errors that pydantic found."""
    # A value that fits no variant of a union causes one error per variant. The user most likely
    # meant the variant whose value was checked, or else the deepest one.
    first = max(
        error.errors(), key=lambda e: (e["type"] in ("value_error", "too_short"), len(e["loc"]))
    )
    kind, location, value = first["type"], first["loc"], first["input"]
    variants = [i for i, step in enumerate(location) if _is_variant(step)]
    if variants:
        message = _union_error(kind, location, variants[0], value)
        if message is not None:
            return message
    key = _key(location) or "the file"
    if kind == "missing":
        return f"{key}: missing"
    if kind == "extra_forbidden":
        return f"{key}: unknown key"
    message = first["msg"].removeprefix("Value error, ")
    if kind in _EXPECTED:
        message = _EXPECTED[kind].format(**first.get("ctx", {}))
    return f"{key}{_quoted(value)}: {message:.{_MAX_MESSAGE_CHARS}}"


def _union_error(kind: str, location: tuple[Any, ...], variant: int, value: object) -> str | None:
    """The message for a value that may be written in several ways and fits none of them.

    Args:
        kind: pydantic's type of the error.
        location: the steps to the value; one of them names a variant of the union, not a key.
        variant: index of that step in `location`.
        value: the value.

    Returns:
        None if the error is not about which variant was meant.
    """
    after = location[variant + 1 :]
    ways, items = _AXIS, "[first, last, count]"
    if "Range" in str(location[variant]):
        ways, items = _RANGE, "[low, high]"
    if kind in ("tuple_type", "too_long") or (kind == "missing" and len(after) == 2):
        return f"{_key((*location[:variant], *after[:1]))}{_quoted(value)}: expected {items}"
    if kind in ("missing", "extra_forbidden") or (not after and kind.endswith("_type")):
        quoted = "" if after else _quoted(value)
        return f"{_key(location[:variant])}{quoted}: {ways}"
    return None


def _key(location: tuple[Any, ...]) -> str:
    """The dotted key of a location, such as `scenarios.0.radius`."""
    return ".".join(_step(step) for step in location if not _is_variant(step))


def _step(step: object) -> str:
    """One step of a dotted key; quoted and shortened if it is not a plain key."""
    text = str(step)
    return text if _BARE_KEY.fullmatch(text) else f"{text[:_MAX_QUOTED_CHARS]!r}"


def _quoted(value: object) -> str:
    """` is VALUE`, shortened; nothing for a table."""
    if isinstance(value, dict):
        return ""
    try:
        return f" is {value!r:.{_MAX_QUOTED_CHARS}}"
    except ValueError:  # Python refuses to print an integer of more than 4300 digits
        return " holds an integer of thousands of digits"


def _is_variant(step: object) -> bool:
    """Whether a step of an error's location names a variant of a union and not a key."""
    return isinstance(step, str) and (step[:1].isupper() or "[" in step or step == "float")
