"""`dubins-study solvers`: every solver, or one.

It tells why a solver cannot run here.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

import typer

from dubins_study.cli.terminal.output import listing, table
from dubins_study.study.words import FREE_FINAL_HEADING

if TYPE_CHECKING:
    from dubins_study.solvers.registry import Entry

_HELP = "one solver, with its settings; default: a list of all"


def solvers(
    solver: Annotated[str | None, typer.Argument(metavar="SPEC", help=_HELP)] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print a JSON list")] = False,
) -> None:
    """List every solver: available, or why not."""
    from dubins_study.solvers.registry import entries, entry

    listed = entries() if solver is None else [entry(solver)]
    if as_json:  # `reason` is null for a solver that is available
        objects = [each._asdict() | {"available": each.reason is None} for each in listed]
        print(json.dumps(objects, indent=2))
    elif solver is None:
        head = ("solver", "formulation", "engine", "guarantee", "also takes", "available")
        rows = [
            (e.name, e.formulation, e.engine, e.guarantee, _beyond_one_leg(e), _available(e))
            for e in listed
        ]
        print(f"{table(head, rows)}\n\nsettings of one: dubins-study solvers ipopt")
    else:
        print(solver_text(listed[0]))


def solver_text(entry: Entry) -> str:
    """One solver as lines of names and values.

    They tell the solver's method, the questions that it answers, and its settings.
    """
    return listing(
        {
            "solver": entry.name,
            "summary": entry.summary,
            "formulation": entry.formulation,
            "engine": entry.engine,
            "guarantee": entry.guarantee,
            "takes": ", ".join(entry.takes),
            "branches": ", ".join(entry.branches),
            "settings": ", ".join(f"{k}={v}" for k, v in entry.settings.items()) or "none",
            "available": _available(entry),
        }
    )


def _beyond_one_leg(entry: Entry) -> str:
    """Questions that a solver takes besides one leg.

    One leg with a free final heading is left out.
    """
    return ", ".join(need for need in entry.takes if need != FREE_FINAL_HEADING)


def _available(entry: Entry) -> str:
    if entry.reason is None:
        return "yes"
    return f"no: {entry.reason}"
