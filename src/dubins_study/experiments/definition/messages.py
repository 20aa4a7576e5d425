"""Sentences about mistakes in an experiment's file.

A sentence names the key, and a message also the line.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from pydantic import ValidationError

from dubins_study.study.values import did_you_mean, nearest, plain, short

# Steps from the file to a value: keys of tables, numbers of items of lists, or an item's text.
KeyPath = tuple[str | int, ...]


def line_of(path: KeyPath, text: str) -> int | None:
    """The line of a value in a file.

    Lines count from 1. If the value is not there, the line is that of the innermost key around it;
    None if no key is there.
    The search goes from key to key, and reads no TOML: a key in a comment may mislead it.
    """
    place = 0
    for depth, step in enumerate(path):
        if isinstance(step, int):  # of a list of tables; no other list has keys in its items
            # the header `[[name]]` that has this number among those of its name
            name = re.escape(str(path[depth - 1]))
            headers = [*re.finditer(rf"^[ \t]*\[\[[ \t]*{name}[ \t]*\]", text, re.MULTILINE)]
            if step < len(headers):
                place = headers[step].end()
            continue
        # as a key: `name =`, `name.` or `[name]`; or as an item of a list: "name"
        name = re.escape(step)
        key = rf"""(?<![\w-])["']?{name}["']?[ \t]*[.=\]]"""
        item = rf"""["']{name}["']"""
        match = re.compile(f"{key}|{item}").search(text, place)
        if match is None:
            break
        place = match.end() - 1
    if not place:
        return None
    return text.count("\n", 0, place) + 1


_MAX_KEY_CHARS = 120
_MAX_MESSAGE_CHARS = 320
_MAX_PROBLEMS = 20  # that one refusal lists
SOLVER_ERROR = "solver"  # pydantic's type of an error about a solver's spec
# Name of a table of the file, "" for the file itself -> the keys that it may have.
TableKeys = Mapping[str, Iterable[str]]


class Problem(NamedTuple):
    """A mistake in a file: place and sentence.

    The sentence has the key, the value and the rule.
    """

    path: KeyPath
    sentence: str


def refusal(file: str, problems: list[Problem], text: str = "") -> str:
    """All problems of a file in one message.

    Each problem has a line of the message. If the file's `text` is given, problems have line
    numbers and are sorted by them. Equal lines are listed once.
    """
    placed = [(line_of(path, text) or 0, sentence) for path, sentence in problems]
    placed.sort(key=lambda place: place[0])
    lines = []
    for number, sentence in placed:
        if number:
            lines.append(f"line {number}: {sentence}")
        else:
            lines.append(sentence)
    sentences = list(dict.fromkeys(lines))
    if len(sentences) == 1:
        return f"{file}: {sentences[0]}"
    more = len(sentences) - _MAX_PROBLEMS
    lines = [f"{file}: {len(sentences)} mistakes", *sentences[:_MAX_PROBLEMS]]
    if more > 0:
        lines.append(f"and {more} more")
    return "\n  ".join(lines)


def problems_of(error: ValidationError, table_keys: TableKeys) -> list[Problem]:
    """Every mistake that pydantic found."""
    errors = [(each["loc"], each) for each in error.errors(include_url=False)]
    # paths of the keys that were probably meant by unknown keys
    misspelt = {
        (*path[:-1], nearest(path[-1], _keys_beside(path, table_keys)))
        for path, each in errors
        if each["type"] == "extra_forbidden"
    }
    problems = []
    for path, each in errors:
        if each["type"] == SOLVER_ERROR:  # on the line of the spec, in a list of several lines
            sentence = f"{_key(path[:-1])}: {each['msg']}"
            problems.append(Problem((*path[:-1], each["input"]), sentence))
        elif each["type"] != "missing":
            problems.append(Problem(path, _sentence(path, each, table_keys)))
        elif path not in misspelt:  # a key that is missing because it is misspelt is one mistake
            problems.append(Problem(path[:-1], f"{_key(path)}: missing"))
    return problems


def _keys_beside(path: KeyPath, table_keys: TableKeys) -> Iterable[str]:
    """The keys that may stand in a key's table."""
    table = ""
    for step in path[:-1]:
        if isinstance(step, str):
            table = step
    return table_keys.get(table, ())


def _sentence(path: KeyPath, error: Any, table_keys: TableKeys) -> str:
    """A sentence: the key, its value, what was expected."""
    kind = error["type"]
    key = _key(path)
    if kind == "extra_forbidden":
        near = did_you_mean(path[-1], _keys_beside(path, table_keys)).rstrip()
        if not near:
            return f"{key}: unknown key"
        return f"{key}: unknown key; {near}"
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "expected")
    if kind in ("model_type", "dict_type"):
        message = "expected a table"
    if not isinstance(error["input"], dict):
        key += f" is {short(error['input'])}"
    return f"{key}: {message:.{_MAX_MESSAGE_CHARS}}"


def _key(path: KeyPath) -> str:
    """The dotted key of a value, such as `scenarios.0.radius`."""
    return plain(".".join(map(str, path)))[:_MAX_KEY_CHARS]
