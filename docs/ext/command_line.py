"""Help of every command, as in the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import typer

from dubins_study.cli.app import app

_WIDTH = 92


def commands() -> dict[str, str]:
    """Text of `--help` of each command.

    Keys are `solve`, `new solver`, ...
    """
    return dict(_helps(typer.main.get_command(app), None, "dubins-study"))


def _helps(command: Any, parent: Any, path: str) -> Iterator[tuple[str, str]]:
    """Helps of a command or of a group's commands."""
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
    """Help of one command as a text block."""
    return f"```text\n{commands()[name]}\n```"


SOURCES: dict[str, Callable[..., str]] = {"command": command_help}
