"""The class of the command line: what holds for every command without a word of its own.

`-h` and `--help` show help that ends with examples; `--quiet` and `--verbose` are options of every
command; a misspelt command or option is refused with the nearest one.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

from dubins_study.cli.terminal.examples import EXAMPLES
from dubins_study.cli.terminal.refusals import check_values, no_such_command, refusal
from dubins_study.cli.terminal.verbosity import Verbosity, set_verbosity

_CONTEXT: dict[str, Any] = {"help_option_names": ["-h", "--help"]}

Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="no progress on stderr: only warnings and refusals")
]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="every step on stderr")]


class _Command(TyperCommand):
    """A command whose refusals are ours."""

    allow_extra_args = True  # `check_values` refuses them

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        rest = _parsed(super().parse_args, ctx, args)
        if not ctx.resilient_parsing:  # no shell is completing a word
            check_values(ctx, rest)
        return rest


class _Group(TyperGroup):
    """A group whose refusals are ours."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        # without a word, Typer shows the help
        return _parsed(super().parse_args, ctx, args) if args else super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if not ctx.resilient_parsing and args[0] not in self.commands:
            raise no_such_command(args[0], ctx)
        return super().resolve_command(ctx, args)


def _parsed(parse: Callable[[Any, list[str]], list[str]], ctx: Any, args: list[str]) -> list[str]:
    """The words that Typer has no place for.

    Raises:
        CommandError: naming the option or argument, its value and what was expected.
    """
    try:
        return parse(ctx, args)
    except TyperException as error:
        raise refusal(error, ctx) from None


class CommandLine(typer.Typer):
    """A group of commands; each has the shared options, and its help ends with its examples.

    Args:
        words: the words before a command's own name: empty, or `new`.
        text: the help of the group.
    """

    def __init__(self, words: str = "", text: str = "", **options: Any) -> None:
        self._words = words
        super().__init__(
            cls=_Group,
            help=text,
            no_args_is_help=True,
            pretty_exceptions_enable=False,
            rich_markup_mode=None,
            context_settings=_CONTEXT,
            epilog=examples_text(words),
            **options,
        )

    def command(self, name: str | None = None, **options: Any) -> Callable[[Any], Any]:
        def add(function: Callable[..., None]) -> Callable[..., None]:
            own_name = name or function.__name__.replace("_", "-")
            epilog = examples_text(f"{self._words} {own_name}".strip())
            settings: dict[str, Any] = {"cls": _Command, "epilog": epilog, **options}
            super(CommandLine, self).command(own_name, **settings)(_with_verbosity(function))
            return function

        return add


def _with_verbosity(function: Callable[..., None]) -> Callable[..., None]:
    """The command with the options --quiet and --verbose, which a command itself need not read."""

    @functools.wraps(function)
    def command(*arguments: Any, quiet: bool, verbose: bool, **options: Any) -> None:
        if quiet or verbose:  # otherwise what stands before the command's name holds
            set_verbosity(Verbosity(verbose - quiet))
        function(*arguments, **options)

    signature = inspect.signature(function, eval_str=True)
    shared = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=kind)
        for name, kind in (("quiet", Quiet), ("verbose", Verbose))
    ]
    parameters = [*signature.parameters.values(), *shared]
    command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    return command


def examples_text(words: str) -> str | None:
    """The examples of a command as the end of its help; None if it has none."""
    lines = [f"  {line}" for line in EXAMPLES.get(words, ())]
    # \b keeps the lines of a paragraph as they are
    return "\n".join(["\b", "Examples:", *lines]) if lines else None
