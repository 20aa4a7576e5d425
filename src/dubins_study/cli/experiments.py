"""`dubins-study experiments`: the experiments that come with the package."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def experiments(
    as_json: Annotated[bool, typer.Option("--json", help="print a JSON list")] = False,
) -> None:
    """List the experiments that `run` knows by name."""
    from dubins_study.cli.terminal.table import table
    from dubins_study.experiments.definition.experiment import packaged, read

    titles = [(name, read(name).experiment.title) for name in packaged()]
    if as_json:
        print(json.dumps([{"name": name, "title": title} for name, title in titles], indent=2))
    else:
        print(table(("experiment", "title"), titles))
