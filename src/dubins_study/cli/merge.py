"""`dubins-study merge`: unite results folders of one experiment."""

from __future__ import annotations

import json
from pathlib import Path as FilePath
from typing import Annotated

import typer

from dubins_study.cli.terminal.arguments import Json
from dubins_study.cli.terminal.output import plain


def merge(
    folders: Annotated[
        list[FilePath], typer.Argument(metavar="DIR", help="results folders, two or more")
    ],
    out: Annotated[FilePath, typer.Option(metavar="DIR", help="new, or empty")],
    as_json: Json = False,
) -> None:
    """Unite results folders of one experiment.

    Refused if they contradict each other.
    """
    from dubins_study.experiments.store.merge import merge as unite

    union = unite(folders, out)
    if as_json:
        print(json.dumps(union._asdict() | {"folder": str(union.folder)}, indent=2))
        return
    print(f"{plain(str(union.folder))}: {union.rows} rows")
    repeats = union.agreeing_repeats
    if repeats:
        print(f"{repeats} cells were solved in several folders, alike: the earliest kept")
    if union.stale:
        print(f"{union.stale} rows are of another code than the first folder's, thus stale")
