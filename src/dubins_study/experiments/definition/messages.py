"""Sentences about what is wrong with an experiment's file, with key and line."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from pydantic import ValidationError

from dubins_study.study.values import did_you_mean, nearest, plain, short

# Steps from the file to a value: keys of tables, numbers of items of lists, or an item's text.
KeyPath = tuple[str | int, ...]


def line_of(path: KeyPath, text: str) -> int | None:
    """The line, from 1, of a value, or of the innermost key around it that a search finds.

    The search goes from key to key, and reads no TOML: a key in a comment may mislead it.
    """
    place = 0
    for depth, step in enumerate(path):
        if isinstance(step, int):  # of a list of tables; no other list has keys in its items
            name = re.escape(str(path[depth - 1]))
            headers = [*re.finditer(rf"^[ \t]*\[\[[ \t]*{name}[ \t]*\]", text, re.MULTILINE)]
            if step < len(headers):
                place = headers[step].end()
            continue
        name = re.escape(step)
        key = rf"""(?<![\w-])["']?{name}["']?[ \t]*[.=\]]"""
        item = rf"""["']{name}["']"""
        found = re.compile(f"{key}|{item}").search(text, place)
        if found is None:
            break
        place = found.end() - 1
    return text.count("\n", 0, place) + 1 if place else None


_MAX_KEY_CHARS, _MAX_MESSAGE_CHARS = 120, 320
_MAX_PROBLEMS = 20  # that one refusal lists
SOLVER_ERROR = "solver"  # pydantic's type of an error about a solver's spec
# Name of a table of the file, "" for the file itself -> the keys that it may have.
TableKeys = Mapping[str, Iterable[str]]


class Problem(NamedTuple):
    """Something wrong with a file: where, and a sentence with the key, the value and the rule."""

    path: KeyPath
    sentence: str


def refusal(file: str, problems: list[Problem], text: str = "") -> str:
    """All problems of a file in one message, with lines if there is a text; a line each."""
    placed = [(line_of(path, text) or 0, sentence) for path, sentence in problems]
    placed.sort(key=lambda place: place[0])
    unique = dict.fromkeys(f"line {n}: {sentence}" if n else sentence for n, sentence in placed)
    sentences = list(unique)
    if len(sentences) == 1:
        return f"{file}: {sentences[0]}"
    more = len(sentences) - _MAX_PROBLEMS
    listed = sentences[:_MAX_PROBLEMS] + ([f"and {more} more"] if more > 0 else [])
    return "\n  ".join([f"{file}: {len(sentences)} mistakes", *listed])


def problems_of(error: ValidationError, known: TableKeys) -> list[Problem]:
    """Every mistake that pydantic found."""
    errors = [(each["loc"], each) for each in error.errors(include_url=False)]
    misspelt = {
        (*path[:-1], nearest(path[-1], _keys_beside(path, known)))
        for path, each in errors
        if each["type"] == "extra_forbidden"
    }
    problems = []
    for path, each in errors:
        if each["type"] == SOLVER_ERROR:  # on the line of the spec, in a list of several lines
            sentence = f"{_key(path[:-1])}: {each['msg']}"
            problems.append(Problem((*path[:-1], each["input"]), sentence))
        elif each["type"] != "missing":
            problems.append(Problem(path, _sentence(path, each, known)))
        elif path not in misspelt:  # a key that is missing because it is misspelt is one mistake
            problems.append(Problem(path[:-1], f"{_key(path)}: missing"))
    return problems


def _keys_beside(path: KeyPath, known: TableKeys) -> Iterable[str]:
    """The keys that the table of a key may have."""
    tables = [step for step in path[:-1] if isinstance(step, str)]
    return known.get(tables[-1] if tables else "", ())


def _sentence(path: KeyPath, error: Any, known: TableKeys) -> str:
    """The key, its value and what was expected."""
    kind, key = error["type"], _key(path)
    if kind == "extra_forbidden":
        near = did_you_mean(path[-1], _keys_beside(path, known)).rstrip()
        return f"{key}: unknown key{'; ' if near else ''}{near}"
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "expected")
    if kind in ("model_type", "dict_type"):
        message = "expected a table"
    value = "" if isinstance(error["input"], dict) else f" is {short(error['input'])}"
    return f"{key}{value}: {message:.{_MAX_MESSAGE_CHARS}}"


def _key(path: KeyPath) -> str:
    """The dotted key of a value, such as `scenarios.0.radius`."""
    return plain(".".join(map(str, path)))[:_MAX_KEY_CHARS]
