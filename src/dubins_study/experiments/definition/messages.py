"""Sentences about what is wrong with an experiment's file, with key and line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from itertools import accumulate
from typing import Any, NamedTuple

from pydantic import ValidationError

from dubins_study.study.values import did_you_mean, nearest

# Steps from the file to a value: keys of tables, and numbers of items of lists.
KeyPath = tuple[str | int, ...]

# What may begin a line: the header of a table or of an item of a list of tables, or a key.
_LINE = re.compile(r"""(?:\[(\[)?)?((?:[\w .-]|"[^"]*"|'[^']*')+)([\]=])""")


def key_lines(text: str) -> dict[KeyPath, int]:
    """The line, from 1, of each key and table that begins a line, and of a list's whole items."""
    lines: dict[KeyPath, int] = {}
    items: dict[KeyPath, int] = {}  # list of tables -> how many it has so far
    table: KeyPath = ()
    path: KeyPath = ()
    listed = 0  # items of the list at `path` so far
    for number, line in enumerate(text.splitlines(), 1):
        if (match := _LINE.match(line.lstrip())) is None:
            for _ in range(_items(line)):
                lines.setdefault((*path, listed), number)
                listed += 1
            continue
        is_item, written, end = match.groups()
        steps = _steps(written)
        if end == "=":
            path = (*table, *steps)
            listed = _items(line[line.index("=") + 1 :].strip().removeprefix("["))
        else:
            path = ()
            for step in steps:  # in a header, a list of tables means its last item
                path = (*path, items[path] - 1, step) if path in items else (*path, step)
            if is_item:
                lines.setdefault(path, number)
                items[path] = items.get(path, 0) + 1
                path = (*path, items[path] - 1)
            table = path
        for part in accumulate(((step,) for step in path), lambda a, b: (*a, *b)):
            lines.setdefault(part, number)
    return lines


def _items(line: str) -> int:
    """How many items of a list a line holds; 0 where it is no such line."""
    try:
        return len(tomllib.loads(f"x = [\n{line}\n]")["x"])
    except ValueError:
        return 0


def line_of(path: KeyPath, lines: dict[KeyPath, int]) -> int | None:
    """The line of a value, or of the innermost key around it that begins a line."""
    return next((lines[path[:n]] for n in range(len(path), 0, -1) if path[:n] in lines), None)


def _steps(written: str) -> KeyPath:
    """The steps of a dotted key; none where the line is part of a text of several lines."""
    try:
        value = tomllib.loads(f"{written} = 0")
    except ValueError:
        return ()
    steps: list[str] = []
    while isinstance(value, dict):
        [(step, value)] = value.items()
        steps.append(step)
    return tuple(steps)


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
# pydantic's type of an error that `key_conflicts` names with its key and line.
NAMED_BY_KEY = "named_by_key"
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]{1,80}")
_MAX_QUOTED_CHARS = 80
_MAX_MESSAGE_CHARS = 320
_MAX_PROBLEMS = 20  # that one refusal lists
_AXIS = (
    "expected a number, a list of numbers, { linear = [first, last, count] } "
    "or { log = [first, last, count] }"
)
_RANGE = "expected { linear = [low, high] } or { log = [low, high] }"
# Name of a table of the file, "" for the file itself -> the keys that it may have.
TableKeys = Mapping[str, Iterable[str]]


class Problem(NamedTuple):
    """Something wrong with a file: where, and a sentence with the key, the value and the rule."""

    path: KeyPath
    sentence: str


def refusal(file: str, problems: list[Problem], text: str = "") -> str:
    """All problems of a file in one message, with lines if there is a text; a line each."""
    lines = key_lines(text)
    placed = [(line_of(path, lines) or 0, sentence) for path, sentence in problems]
    placed.sort(key=lambda place: place[0])
    unique = dict.fromkeys(f"line {n}: {sentence}" if n else sentence for n, sentence in placed)
    sentences = list(unique)
    if len(sentences) == 1:
        return f"{file}: {sentences[0]}"
    more = len(sentences) - _MAX_PROBLEMS
    listed = sentences[:_MAX_PROBLEMS] + ([f"and {more} more"] if more > 0 else [])
    return "\n  ".join([f"{file}: {len(sentences)} mistakes", *listed])


def problems_of(error: ValidationError, known: TableKeys) -> list[Problem]:
    """Every mistake that pydantic found, once, but for those that `key_conflicts` names."""
    # A value that fits no variant of a union causes one error per variant. The user most likely
    # meant the variant whose value was checked, or else the deepest one.
    groups: dict[KeyPath, list[Any]] = {}
    for each in error.errors():
        groups.setdefault(_before_variant(each["loc"]), []).append(each)
    worst = [
        max(group, key=lambda e: (e["type"] in ("value_error", "too_short"), len(e["loc"])))
        for group in groups.values()
    ]
    misspelt = {_meant(each["loc"], known) for each in worst if each["type"] == "extra_forbidden"}
    return [
        Problem(_path(each["loc"]), _sentence(each, known))
        for each in worst
        # a key that is missing because it is misspelt is one mistake
        if each["type"] != NAMED_BY_KEY
        and not (each["type"] == "missing" and each["loc"] in misspelt)
    ]


def _before_variant(location: KeyPath) -> KeyPath:
    """The location up to the value that may be written in several ways; whole, if none may."""
    for place, step in enumerate(location):
        if _is_variant(step):
            return location[:place]
    return location


def _meant(location: KeyPath, known: TableKeys) -> KeyPath:
    """The location of the known key that an unknown one is most like."""
    return (*location[:-1], nearest(location[-1], _keys_beside(location, known)) or "")


def _keys_beside(location: KeyPath, known: TableKeys) -> Iterable[str]:
    """The keys that the table of a location may have."""
    names = [step for step in _path(location[:-1]) if isinstance(step, str)]
    return known.get(names[-1] if names else "", ())


def _sentence(error: Any, known: TableKeys) -> str:
    """The key, its value and what was expected."""
    kind, location, value = error["type"], error["loc"], error["input"]
    variant = len(_before_variant(location))
    if variant < len(location):
        message = _union_error(kind, location, variant, value)
        if message is not None:
            return message
    key = _key(location) or "the file"
    if kind == "missing":
        return f"{key}: missing"
    if kind == "extra_forbidden":
        near = did_you_mean(location[-1], _keys_beside(location, known)).rstrip()
        return f"{key}: unknown key{'; ' if near else ''}{near}"
    message = error["msg"].removeprefix("Value error, ")
    if location[-1:] == ("[key]",):  # the value is the key itself
        value = {}
    if kind in _EXPECTED:
        message = _EXPECTED[kind].format(**error.get("ctx", {}))
    return f"{key}{_quoted(value)}: {message:.{_MAX_MESSAGE_CHARS}}"


def _union_error(kind: str, location: KeyPath, variant: int, value: object) -> str | None:
    """The message for a value that may be written in several ways and fits none of them.

    The step of the location at `variant` names one of the ways. None if the error is not about
    which of them was meant.
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


def _path(location: KeyPath) -> KeyPath:
    """The steps of a location that are keys and numbers of the file."""
    return tuple(step for step in location if not _is_variant(step))


def _key(location: KeyPath) -> str:
    """The dotted key of a location, such as `scenarios.0.radius`."""
    return ".".join(map(_step, _path(location)))


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
