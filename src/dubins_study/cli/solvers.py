"""`dubins-study solvers`: every solver, and why it cannot run here if it cannot."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dubins_study.solvers.registry import Entry


def solvers(
    as_json: Annotated[bool, typer.Option("--json", help="print a JSON list")] = False,
) -> None:
    """List every solver: available, or why not."""
    from dubins_study.solvers.registry import entries

    if as_json:  # `reason` is null for a solver that is available
        listed = [entry._asdict() | {"available": entry.reason is None} for entry in entries()]
        print(json.dumps(listed, indent=2))
    else:
        print(solvers_text(entries()))


def solvers_text(entries: list[Entry]) -> str:
    """A table for the terminal."""
    from dubins_study.cli.terminal.table import table
    from dubins_study.study.printable import plain

    rows = [
        (
            entry.name,
            entry.formulation,
            entry.engine,
            entry.guarantee,
            ", ".join(entry.branches),
            "yes" if entry.reason is None else f"no: {plain(entry.reason)}",
            entry.summary,
        )
        for entry in entries
    ]
    head = ("solver", "formulation", "engine", "guarantee", "branches", "available", "summary")
    return table(head, rows)
