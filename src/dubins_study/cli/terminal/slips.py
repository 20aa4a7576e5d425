"""The words of a command, rearranged for a parser.

For the parser, -6 is a number and no option.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import Any, NoReturn

_OPTION = re.compile(r"-[^\d.]")  # -6 and -.5 begin no option


def arranged(
    words: Iterable[str], params: Sequence[Any], refuse: Callable[[str], NoReturn]
) -> list[str]:
    """The words of a command, arguments behind `--`.

    Options with their values come first, then `--`, then all arguments: `-6 3 --radius 2` becomes
    `--radius 2 -- -6 3`. `refuse` is called with a message and does not return.

    An option is refused if it is given twice, or with fewer values than it takes: a parser reads
    `--from 0 0 --radius 3` as the heading `--radius` and one argument too many.
    """
    options: dict[str, Any] = {}
    for param in params:
        if param.param_type_name == "option" and not param.is_flag:
            options |= dict.fromkeys(param.opts, param)
    option_words: list[str] = []
    arguments: list[str] = []
    seen: set[str] = set()
    remaining = iter(words)
    for word in remaining:
        if word == "--":
            arguments += remaining
            break
        if not _OPTION.match(word):
            arguments.append(word)
            continue
        name, equals, value = word.partition("=")
        option = options.get(name)
        if option is None:  # a flag, or unknown
            option_words.append(word)
            continue
        if option.name in seen and not option.multiple:
            refuse(f"{name} is given twice; expected it once")
        seen.add(option.name)
        values = []
        if equals:
            values.append(value)
        following = list(islice(remaining, option.nargs - len(values)))
        values += following
        if len(values) < option.nargs or any(each.startswith("--") for each in following):
            text = " ".join(values)
            refuse(f"{name} is {text!r:.60}; expected {option.metavar}: {option.help}")
        option_words += [word, *following]
    return [*option_words, "--", *arguments]
