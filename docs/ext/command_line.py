"""The help of every command, as the terminal shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import typer

from dubins_study.cli.app import app

_WIDTH = 92


def commands() -> dict[str, str]:
    """`solve`, `new solver`, ... -> the text of its `--help`."""
    return dict(_helps(typer.main.get_command(app), None, "dubins-study"))


def _helps(command: Any, parent: Any, path: str) -> Iterator[tuple[str, str]]:
    """The helps of a command, or of all commands of a group."""
    sizes = {"terminal_width": _WIDTH, "max_content_width": _WIDTH}
    context = command.context_class(command, parent=parent, info_name=path.split()[-1], **sizes)
    if not hasattr(command, "list_commands"):
        yield path.partition(" ")[2], command.get_help(context)
        return
    for name in command.list_commands(context):
        part = command.get_command(context, name)
        if part is not None and not part.hidden:
            yield from _helps(part, context, f"{path} {name}")


def command_help(name: str) -> str:
    """The help of one command as a block of text."""
    return f"```text\n{commands()[name]}\n```"


SOURCES: dict[str, Callable[..., str]] = {"command": command_help}
