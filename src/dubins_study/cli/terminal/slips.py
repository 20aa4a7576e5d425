"""Slips on the command line: the option that was meant, what it takes, what was given."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice, takewhile
from typing import Any, NoReturn

import typer

_OPTION = re.compile(r"-[^\d.]")  # -6 and -.5 begin no option


def arranged(
    words: Iterable[str], params: Sequence[Any], refuse: Callable[[str], NoReturn]
) -> list[str]:
    """The words of a command, its arguments last behind `--`, so that -6 is no option.

    Refused are an unknown option, and an option with fewer values than it takes: a parser reads
    `--from 0 0 --radius 3` as the heading `--radius` and one argument too many.
    """
    options: dict[str, Any] = {}
    for param in params:
        if param.param_type_name == "option":
            options |= dict.fromkeys(param.opts, param)
    taken: list[str] = []
    seen: set[str] = set()  # options that are given once at most
    arguments: list[str] = []
    rest = iter(words)
    for word in rest:
        if word == "--":
            arguments += rest
            break
        if not _OPTION.match(word):
            arguments.append(word)
            continue
        taken.append(word)
        name, equals, value = word.partition("=")
        option = options.get(name)
        if option is None:
            if not all(f"-{letter}" in options for letter in word[1:]):  # as in -qv
                refuse(f"no option {name!r:.60}; {_meant(name, options)}")
        elif not option.is_flag:
            if option.name in seen and not option.multiple:
                refuse(f"{name} is given twice; expected it once")
            seen.add(option.name)
            first = [value] if equals else []
            following = list(islice(rest, option.nargs - len(first)))
            values = [*first, *takewhile(lambda v: v not in options and v[:2] != "--", following)]
            if len(values) < option.nargs:
                given = f"is {' '.join(values)!r:.60}" if values else "has no value"
                refuse(f"{name} {given}; expected {option.metavar}: {option.help}")
            taken += following
    wanted = [param for param in params if param.param_type_name == "argument"]
    helped = {"--help", "-h"} & {*taken}
    too_many = len(arguments) > len(wanted) and all(param.nargs == 1 for param in wanted)
    if too_many and not helped:
        names = " ".join(param.metavar or param.name.upper() for param in wanted) or "none"
        refuse(
            f"arguments are {' '.join(arguments)!r:.60}; expected {names}: a value with a space is "
            "quoted, and an option that may be repeated is written each time"
        )
    return [*taken, "--", *arguments]


def _meant(name: str, options: Mapping[str, Any]) -> str:
    """The option of the nearest name and what it takes; all names if none is near."""
    from dubins_study.study.values import nearest  # numpy, which no help waits for

    names = [known.removeprefix("--") for known in options if known.startswith("--")]
    longer = [known for known in names if known.startswith(name.lstrip("-"))]
    match = longer[0] if len(longer) == 1 else nearest(name.lstrip("-"), names)
    if match is None:
        return f"choose one of: {', '.join(_usage(known, options) for known in names)}"
    return f"did you mean {_usage(match, options)} ({options[f'--{match}'].help})?"


def _usage(name: str, options: Mapping[str, Any]) -> str:
    return f"--{name} {options[f'--{name}'].metavar or ''}".rstrip()


def unreadable(error: typer.BadParameter) -> str | None:
    """The value that is no number, and what it is for; None of another refusal."""
    mistakes = getattr(error.__cause__, "errors", None)  # pydantic's, which read the value
    if mistakes is None:
        return None
    mistake = mistakes()[0]
    kind = "an integer" if mistake["type"].startswith("int") else "a number"
    param: Any = error.param
    name = param.get_error_hint().strip("'")
    return f"{name} is {mistake['input']!r:.60}; expected {kind}: {param.help}"
