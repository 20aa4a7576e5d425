"""`dubins-study experiments`: the experiments that `run` knows.

Of one experiment it tells what is asked.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Any

import typer

from dubins_study.cli.terminal.output import listing, plain, table

_HELP = "one of them, or a .toml file: what it asks; default: a list of all"
_OF_YOUR_OWN = """\
one of them:          dubins-study experiments paper
one of your own:      dubins-study new experiment my.toml
scenarios of a file:  dubins-study run --scenarios my.csv --solver ipopt"""


def experiments(
    experiment: Annotated[str | None, typer.Argument(metavar="EXPERIMENT", help=_HELP)] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print a JSON list")] = False,
) -> None:
    """List the experiments that `run` knows by name."""
    from dubins_study.experiments.definition.experiment import packaged, read
    from dubins_study.experiments.plan.cells import overview
    from dubins_study.experiments.plan.run_plan import read_checked

    if experiment is None:
        overviews = [overview(read(name)) for name in packaged()]
    else:
        overviews = [overview(read_checked(experiment, trust_plugins=False))]
    if as_json:
        print(json.dumps(overviews, indent=2))
    elif experiment is None:
        head = ("experiment", "cells", "solvers", "title")
        rows = [
            (each["name"], each["cells"], len(each["solvers"]), each["title"]) for each in overviews
        ]
        print(f"{table(head, rows)}\n\n{_OF_YOUR_OWN}")
    else:
        print(experiment_text(overviews[0]))


def experiment_text(summary: Mapping[str, Any]) -> str:
    """One experiment as text, with a line per solver.

    `summary` is the result of `experiments.plan.cells.overview`.
    """
    limits = f"{summary['time_limit_s']:g} s and {summary['memory_limit_gib']:g} GiB a solve"
    fields = {
        "experiment": summary["name"],
        "title": summary["title"],
        "question": summary["question"],
        "scenarios": summary["scenarios"],
        "branches": ", ".join(summary["branches"]),
        "repeats": summary["repeats"],
        "cells": summary["cells"],
        "limits": limits,
        "profile": summary["profile"],
        "solvers": len(summary["solvers"]),
    }
    return "\n".join([listing(fields), *(f"  {plain(spec)}" for spec in summary["solvers"])])
