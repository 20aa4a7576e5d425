"""The words of a command in an order that a parser reads: -6 is a number, and no option."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Any, NoReturn

_OPTION = re.compile(r"-[^\d.]")  # -6 and -.5 begin no option


def arranged(
    words: Iterable[str], params: Sequence[Any], refuse: Callable[[str], NoReturn]
) -> list[str]:
    """The words of a command, its arguments last behind `--`.

    Refused are an option that is given twice, and one with fewer values than it takes: a parser
    reads `--from 0 0 --radius 3` as the heading `--radius` and one argument too many.
    """
    takers = [param for param in params if param.param_type_name == "option" and not param.is_flag]
    options = {name: param for param in takers for name in param.opts}
    taken: list[str] = []
    arguments: list[str] = []
    seen: set[str] = set()
    rest = iter(words)
    for word in rest:
        if word == "--":
            arguments += rest
            break
        if not _OPTION.match(word):
            arguments.append(word)
            continue
        name, equals, value = word.partition("=")
        option = options.get(name)
        if option is None:  # a flag, or unknown
            taken.append(word)
            continue
        if option.name in seen and not option.multiple:
            refuse(f"{name} is given twice; expected it once")
        seen.add(option.name)
        given_first = [value] if equals else []
        following = list(islice(rest, option.nargs - len(given_first)))
        values = given_first + following
        if len(values) < option.nargs or any(each.startswith("--") for each in following):
            given = " ".join(values)
            refuse(f"{name} is {given!r:.60}; expected {option.metavar}: {option.help}")
        taken += [word, *following]
    return [*taken, "--", *arguments]
