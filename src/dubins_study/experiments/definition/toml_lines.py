"""The line of every key of a TOML file, which the standard library's reader does not tell."""

from __future__ import annotations

import contextlib
import re
import tomllib
from collections.abc import Iterator
from typing import NamedTuple

# Steps from the file to a value: keys of tables, and numbers of items of lists.
KeyPath = tuple[str | int, ...]

_TOKEN = re.compile(
    r'"""(?:\\[\s\S]|[^\\])*?"{3,5}'
    r"|'''[\s\S]*?'{3,5}"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'"
    r"|\#[^\n]*"
    r"|\n|[\[\]{}=,.]"
    r"|[^\s\[\]{}=,.\#\"']+"
)


class _Token(NamedTuple):
    text: str
    line: int


class KeyLines:
    """The lines of a TOML text that the standard library has read without an error."""

    def __init__(self, text: str) -> None:
        self._lines: dict[KeyPath, int] = {}
        self._tables: dict[KeyPath, int] = {}  # array of tables -> how many it has so far
        self._tokens = _tokens(text)
        # what has been read when the text ends, or nests too deep, is right all the same
        with contextlib.suppress(StopIteration, RecursionError):
            self._read()

    def line(self, path: KeyPath) -> int | None:
        """The line, from 1, of a value or of the innermost table around it that has a line."""
        for end in range(len(path), 0, -1):
            if path[:end] in self._lines:
                return self._lines[path[:end]]
        return None

    def order(self, path: KeyPath) -> int:
        """How many keys and tables of the file stand before a value or the table around it."""
        paths = {known: place for place, known in enumerate(self._lines)}
        return next((paths[path[:n]] for n in range(len(path), 0, -1) if path[:n] in paths), 0)

    def _note(self, path: KeyPath, line: int) -> None:
        """Keep the first line of a path, and of the tables that a dotted key names on its way."""
        for end in range(len(path), 0, -1):
            if path[:end] in self._lines:
                return
            self._lines[path[:end]] = line

    def _read(self) -> None:
        table: KeyPath = ()
        for token in self._tokens:
            if token.text == "\n" or token.text.startswith("#"):
                continue
            if token.text == "[":
                table = self._header(token.line)
            else:
                path, line = self._key(token, table), token.line
                self._note(path, line)
                self._value(self._next(), path)
            while self._next().text != "\n":  # the rest of a number, or a comment
                pass

    def _header(self, line: int) -> KeyPath:
        """The path of the table whose header begins."""
        token = self._next()
        is_item = token.text == "["
        path = self._key(self._next() if is_item else token, (), closing="]")
        if is_item:
            self._next()  # the second closing bracket
            self._note(path, line)
            number = self._tables.get(path, 0)
            self._tables[path] = number + 1
            path = (*path, number)
        self._note(path, line)
        return path

    def _key(self, token: _Token, table: KeyPath, closing: str = "=") -> KeyPath:
        """The path of a key that begins with a token and ends before `closing`."""
        path = table
        while token.text != closing:
            if token.text != ".":
                # of an array of tables, a key of a header means the last one
                count = self._tables.get(path) if closing == "]" else None
                path = path if count is None else (*path, count - 1)
                path = (*path, _name(token.text))
            token = self._next()
        return path

    def _value(self, token: _Token, path: KeyPath) -> None:
        if token.text == "[":
            self._list(path)
        elif token.text == "{":
            self._inline_table(path)

    def _list(self, path: KeyPath) -> None:
        number = 0
        for token in self._tokens:
            if token.text == "]":
                return
            if token.text == ",":
                number += 1
            elif token.text != "\n" and not token.text.startswith("#"):
                item = (*path, number)
                if item not in self._lines:  # a number such as 1.5 is several tokens
                    self._lines[item] = token.line
                    self._value(token, item)

    def _inline_table(self, path: KeyPath) -> None:
        key_follows = True
        for token in self._tokens:
            if token.text == "}":
                return
            if token.text == ",":
                key_follows = True
            elif key_follows and token.text != "\n" and not token.text.startswith("#"):
                key_follows = False
                key = self._key(token, path)
                self._note(key, token.line)
                self._value(self._next(), key)

    def _next(self) -> _Token:
        return next(self._tokens)


def _tokens(text: str) -> Iterator[_Token]:
    line, place = 1, 0
    for match in _TOKEN.finditer(text):
        line += text.count("\n", place, match.start())
        yield _Token(match[0], line)
        line += match[0].count("\n")
        place = match.end()


def _name(text: str) -> str:
    """A key as the standard library reads it."""
    if text[:1] not in ('"', "'"):
        return text
    try:
        return str(tomllib.loads(f"key = {text}")["key"])
    except ValueError:
        return text
