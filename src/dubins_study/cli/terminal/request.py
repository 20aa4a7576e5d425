"""The words of a command line, checked before Typer reads them: one sentence for each mistake.

Each sentence says what is wrong, what was expected and, if one is near, the name that was meant.
"""

from __future__ import annotations

import itertools
import os
import re
import sys
from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple

import typer

from dubins_study.errors import DubinsStudyError

PROGRAM = "dubins-study"
_LEAST_WIDTH = 20  # characters of a line that any terminal has


class CommandError(DubinsStudyError, ValueError):
    """The command line cannot be read, or its result cannot be printed or saved."""


class Given(NamedTuple):
    """One option of a command line with its values, or one argument.

    Args:
        parameter: Typer's declaration of the option; None for an argument.
        name: the option as it was written; empty for an argument.
        values: what belongs to it.
    """

    parameter: Any
    name: str
    values: tuple[str, ...]


def checked_words(context: typer.Context, words: list[str]) -> list[str]:
    """The words after a command's name, for Typer to read; those for its help if it is asked for.

    Raises:
        CommandError: if an option is unknown, has too few values or is given twice, or if there are
            too few or too many arguments.
    """
    for word in itertools.takewhile(lambda word: word != "--", () if is_group(context) else words):
        if word in context.help_option_names:  # whatever else is wrong
            return [word]
    parameters: list[Any] = context.command.get_params(context)
    options = {
        name: p for p in parameters if _is_option(p) for name in (*p.opts, *p.secondary_opts)
    }
    given: dict[str, Given] = {}
    arguments: list[str] = []
    for item in _items(context, deque(words), options):
        if item.parameter is None:
            arguments += item.values
        elif item.name in context.help_option_names:
            return [item.name]
        else:
            earlier = given.setdefault(item.parameter.name, item)
            if earlier is not item and item.values and not item.parameter.multiple:
                values = " and ".join(repr(" ".join(each.values)) for each in (earlier, item))
                raise CommandError(f"{item.name} is given twice: {values}; expected it once")
    if not is_group(context):
        _check_arguments(context, [p for p in parameters if not _is_option(p)], arguments, given)
        for option in parameters:
            if _is_option(option) and option.required and option.name not in given:
                raise CommandError(f"{option.opts[0]} is missing; {_usage(context, parameters)}")
    return words


def is_group(context: typer.Context) -> bool:
    """Whether a command has commands of its own."""
    return hasattr(context.command, "commands")


def unknown_command(context: Any, word: str) -> CommandError:
    """The refusal of a word that names no command of a group."""
    from dubins_study.study.nearest import did_you_mean

    commands = list(context.command.commands)
    options = [name for p in context.command.get_params(context) for name in p.opts]
    near = did_you_mean(word, commands) or did_you_mean(word, options)
    words = f"{command_words(context)} ".partition(" ")[2]
    return CommandError(
        f"no such command: {words}{word}; {near}expected one of: {', '.join(commands)}"
    )


def command_words(context: Any) -> str:
    """The words that name a command, such as `dubins-study new solver`."""
    names = []
    while context.parent is not None:  # the program may have been started by another name
        names.append(context.info_name)
        context = context.parent
    return " ".join([PROGRAM, *reversed(names)])


def _is_option(parameter: Any) -> bool:
    return bool(parameter.param_type_name == "option")


def _items(context: typer.Context, left: deque[str], options: dict[str, Any]) -> Iterator[Given]:
    """The options and arguments among the words, in their order; of a group, up to a command."""
    while left:
        word = left.popleft()
        name = word.partition("=")[0]
        if word == "--":
            yield Given(None, "", tuple(left))
            return
        if name in options:
            yield _option(context, word, left, options)
        elif word[:1] != "-" or word == "-" or (context.ignore_unknown_options and is_number(word)):
            if is_group(context):
                return
            yield Given(None, "", (word,))
        elif word[1] != "-" and all(f"-{letter}" in options for letter in word[1:]):
            for letter in word[1:]:  # such as -qv: options of one letter take no value
                yield Given(options[f"-{letter}"], f"-{letter}", ())
        else:
            raise _unknown_option(context, name, options)


def _option(context: typer.Context, word: str, left: deque[str], options: dict[str, Any]) -> Given:
    """An option with its values, those after an equals sign and those that follow.

    Raises:
        CommandError: if there are too many, or too few before the next option.
    """
    name, equals, value = word.partition("=")
    option = options[name]
    expected = 0 if option.is_flag else option.nargs
    values = [value] if equals else []
    if len(values) > expected:
        raise CommandError(f"{name} is given {values[0]!r}; expected no value: {name} alone")
    while len(values) < expected and left and left[0].partition("=")[0] not in options:
        values.append(left.popleft())
    if len(values) < expected:
        count = "no value" if expected == 1 else f"{len(values)} of {expected} values"
        raise CommandError(
            f"{name} has {count}; expected {_shape(context, option)} ({option.help})"
        )
    return Given(option, name, tuple(values))


def _unknown_option(context: typer.Context, name: str, options: dict[str, Any]) -> CommandError:
    from dubins_study.study.nearest import did_you_mean

    long_names = [option for option in options if option.startswith("--")]
    near = did_you_mean(name, long_names) or f"expected one of: {', '.join(long_names)}; "
    return CommandError(f"no such option: {name}; {near}see {command_words(context)} --help")


def _check_arguments(
    context: typer.Context, parameters: list[Any], words: list[str], given: dict[str, Given]
) -> None:
    """Refuse too few or too many arguments."""
    usage = _usage(context, parameters)
    required = [parameter for parameter in parameters if parameter.required]
    if len(words) < len(required):
        missing = required[len(words)]
        taken = [g for g in given.values() if g.parameter.nargs > 1]
        hint = f" ({taken[0].name} took {' '.join(taken[0].values)!r})" if taken else ""
        raise CommandError(f"{_name(missing)} is missing: {missing.help}; {usage}{hint}")
    if len(words) > len(parameters) and all(parameter.nargs == 1 for parameter in parameters):
        raise CommandError(f"unexpected argument {words[len(parameters)]!r}; {usage}")


def _usage(context: typer.Context, parameters: list[Any]) -> str:
    """What was expected: the command with its arguments and required options, and an example."""
    from dubins_study.cli.terminal.examples import EXAMPLES

    words = command_words(context)
    parts = [words]
    for parameter in parameters:
        if not _is_option(parameter):
            name = _name(parameter) + ("..." if parameter.nargs == -1 else "")
            parts.append(name if parameter.required else f"[{name}]")
    parts += [_shape(context, p) for p in context.command.params if _is_option(p) and p.required]
    example = EXAMPLES.get(words.removeprefix(PROGRAM).strip(), ("",))[0]
    such_as = f", such as: {example}" if example and example != " ".join(parts) else ""
    return f"expected {' '.join(parts)}{such_as}"


def _name(argument: Any) -> str:
    return str(argument.metavar or argument.name.upper()).strip("{}[].")


def _shape(context: typer.Context, option: Any) -> str:
    """An option and what stands for its values, as in the command's help: `--out DIR`."""
    return str(option.get_help_record(context)[0])


def refusal_text(message: str) -> str:
    """A refusal as stderr shows it: control characters, perhaps from a file, become visible.

    A line break is kept only before two spaces, where the message starts the item of a list. In a
    terminal lines are broken between words; paths and commands stay whole, so that they can be
    copied.
    """
    from dubins_study.study.printable import plain

    lines = [plain(line) for line in re.split(r"\n(?=  )", f"{PROGRAM}: {message}")]
    if sys.stderr is not None and sys.stderr.isatty():
        width = max(_width(), _LEAST_WIDTH)
        lines = [broken for line in lines for broken in _broken(line, width)]
    return "\n".join(lines)


def _width() -> int:
    """Characters in a line of the terminal that stderr is; stdout may be a file."""
    try:
        return int(os.environ["COLUMNS"])
    except (KeyError, ValueError):
        return os.get_terminal_size(sys.stderr.fileno()).columns


def _broken(line: str, width: int) -> list[str]:
    """A line in pieces of a width, those after the first indented below it."""
    import textwrap

    text = line.lstrip(" ")
    indent = line[: len(line) - len(text)]
    return textwrap.wrap(
        text,
        width,
        initial_indent=indent,
        subsequent_indent=f"{indent}  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def is_number(word: str) -> bool:
    """Whether a word is a number as this command line takes it."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word  # which Python takes within a number
