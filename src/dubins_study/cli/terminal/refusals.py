"""Refusals of a command line: one sentence each, of one shape, whoever found the mistake.

Each sentence says what is wrong, what was expected and, if one is near, the name that was meant.
Typer reads the words; what it finds wrong is said here in our words.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable
from typing import Any

import typer

from dubins_study.errors import DubinsStudyError

PROGRAM = "dubins-study"
_LEAST_WIDTH = 20  # characters of a line that any terminal has


class CommandError(DubinsStudyError, ValueError):
    """The command line cannot be read, or its result cannot be printed or saved."""


def refusal(error: Any, context: typer.Context) -> CommandError:
    """What Typer found wrong with the words after a command's name.

    Args:
        error: any of Typer's errors of usage.
        context: of the command.
    """
    parameter, option = getattr(error, "param", None), getattr(error, "option_name", None)
    options = _options(context)
    if option is not None and option in options:  # too few values, or one too many
        flag = options[option].is_flag
        expected = f"{option} alone" if flag else _described(context, options[option])
        return CommandError(f"{_sentence(error.message)}; expected {expected}")
    if option is not None:
        return no_such_option(option, context)
    if parameter is None:
        return CommandError(f"{_sentence(error.message)}; {_usage(context)}")
    if error.message:
        return CommandError(f"{parameter.opts[0]} is {error.message}")
    if parameter.param_type_name == "option":
        return CommandError(f"{parameter.opts[0]} is missing; {_usage(context)}")
    return CommandError(f"{_name(parameter)} is missing: {parameter.help}; {_usage(context)}")


def check_values(context: typer.Context, rest: list[str]) -> None:
    """Refuse what Typer takes: words without a place, and options in the place of a value.

    Args:
        context: of a command whose words Typer has read.
        rest: the words that it could not place.
    Raises:
        CommandError: naming the option or the word, and what was expected.
    """
    options = _options(context)
    arguments: list[str] = []
    for parameter in context.command.get_params(context):
        values = _texts(context.params.get(str(parameter.name)))
        if parameter.param_type_name == "argument":
            arguments += values
        elif any(value in options for value in values):
            raise CommandError(
                f"{parameter.opts[0]} is {' '.join(values)!r}; "
                f"expected {_described(context, parameter)}"
            )
    for word in (*arguments, *rest):
        # commands with targets such as -6 3 take every unknown option for an argument
        if word[:1] == "-" and word != "-" and not is_number(word):
            raise no_such_option(word.partition("=")[0], context)
    if rest:
        raise CommandError(f"unexpected argument {rest[0]!r}; {_usage(context)}")


def no_such_option(name: str, context: typer.Context) -> CommandError:
    """The refusal of an option that a command does not have."""
    from dubins_study.study.values import did_you_mean

    names = [option for option in _options(context) if option.startswith("--")]
    near = did_you_mean(name, names) or f"expected one of: {', '.join(names)}; "
    return CommandError(f"no such option: {name}; {near}see {_command_words(context)} --help")


def no_such_command(word: str, context: Any) -> CommandError:
    """The refusal of a word that names no command of a group."""
    from dubins_study.study.values import did_you_mean

    commands = list(context.command.commands)
    near = did_you_mean(word, commands) or did_you_mean(word, _options(context))
    words = f"{_command_words(context)} ".partition(" ")[2]
    return CommandError(
        f"no such command: {words}{word}; {near}expected one of: {', '.join(commands)}"
    )


def _options(context: Any) -> dict[str, Any]:
    """The name of each option -> Typer's declaration of it."""
    parameters = context.command.get_params(context)
    options = [p for p in parameters if p.param_type_name == "option"]
    return {name: option for option in options for name in (*option.opts, *option.secondary_opts)}


def _texts(value: Any) -> list[str]:
    """A parameter's value, or its values, as texts."""
    if value is None or isinstance(value, bool):
        return []
    several = isinstance(value, Iterable) and not isinstance(value, str)
    return [str(each) for each in value] if several else [str(value)]


def _sentence(message: str) -> str:
    """A message of Typer's as the beginning of ours."""
    return message[:1].lower() + message[1:].rstrip(".")


def _command_words(context: Any) -> str:
    """The words that name a command, such as `dubins-study new solver`."""
    names = []
    while context.parent is not None:  # the program may have been started by another name
        names.append(context.info_name)
        context = context.parent
    return " ".join([PROGRAM, *reversed(names)])


def _usage(context: Any) -> str:
    """What was expected: the command with its arguments and required options, and an example."""
    from dubins_study.cli.terminal.examples import EXAMPLES

    words = _command_words(context)
    parameters = context.command.params
    parts = [words]
    for argument in (p for p in parameters if p.param_type_name == "argument"):
        name = _name(argument) + ("..." if argument.nargs == -1 else "")
        parts.append(name if argument.required else f"[{name}]")
    required = [p for p in parameters if p.param_type_name == "option" and p.required]
    parts += [_shape(context, option) for option in required]
    example = EXAMPLES.get(words.removeprefix(PROGRAM).strip(), ("",))[0]
    such_as = f", such as: {example}" if example and example != " ".join(parts) else ""
    return f"expected {' '.join(parts)}{such_as}"


def _name(argument: Any) -> str:
    return str(argument.metavar or argument.name.upper()).strip("{}[].")


def _shape(context: typer.Context, option: Any) -> str:
    """An option and what stands for its values, as in the command's help: `--out DIR`."""
    return str(option.get_help_record(context)[0])


def _described(context: typer.Context, option: Any) -> str:
    return f"{_shape(context, option)} ({option.help})"


def refusal_text(message: str) -> str:
    """A refusal as stderr shows it: control characters, perhaps from a file, become visible.

    A line break is kept only before two spaces, where the message starts the item of a list. In a
    terminal lines are broken between words; paths and commands stay whole, so that they can be
    copied.
    """
    from dubins_study.study.values import plain

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
