"""The line of every key of a TOML file, which the standard library's reader does not tell."""

from __future__ import annotations

import re
import tomllib
from itertools import accumulate

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
