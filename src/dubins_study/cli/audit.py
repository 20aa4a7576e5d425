"""`dubins-study audit`: published lengths, recomputed.

They are the tables of the paper, and other published lengths.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.cli.terminal.arguments import CommandError, Json
from dubins_study.cli.terminal.output import table

if TYPE_CHECKING:
    from dubins_study.report.elements.content import Table

Record = dict[str, Any]
_SOURCE = "paper: its tables; kaya: four published routes"


def audit(
    source: Annotated[str, typer.Argument(metavar="SOURCE", help=_SOURCE)] = "paper",
    as_json: Json = False,
) -> None:
    """Recompute the paper's tables, or the lengths of routes.

    Exit code 1 if the code contradicts the committed audit.
    """
    audits = {"paper": _audit_paper, "kaya": _audit_kaya}
    if source not in audits:
        from dubins_study.study.values import short  # numpy, which no help waits for

        raise CommandError(f"no audit of {short(source)}; choose one of: {', '.join(audits)}")
    lines = audits[source](as_json)
    if lines:
        lines = ["dubins-study: the code contradicts the committed audit:", *lines]
        print(*lines, sep="\n", file=sys.stderr)
    raise typer.Exit(int(bool(lines)))


def _audit_kaya(as_json: bool) -> list[str]:
    """Print the audit of Kaya's routes.

    Returns a sentence for each difference from the committed audit.
    """
    from dubins_study.experiments.definition.experiment import read
    from dubins_study.experiments.plan.scenarios import scenarios
    from dubins_study.report.paper.routes import audit_routes

    blocks = read("kaya").experiment.scenarios
    routes = chain.from_iterable(scenarios(block, block.label) for block in blocks)
    records = audit_routes(list(routes))
    if as_json:
        print(json.dumps(records, indent=1, allow_nan=False))
    else:
        print(routes_text(records))
    return [
        "{source}, {label}: {verdict}, not {expected}".format(**record)
        for record in records
        if record["verdict"] != record["expected"]
    ]


def routes_text(records: list[Record]) -> str:
    """The audit of routes as text.

    The text has the table of the report, the word of each shortest route, and the wrong printed
    lengths. `records` are the results of `audit_routes`.
    """
    import pandas as pd

    from dubins_study.report.topics.audit_tables import routes_table

    words = {record["label"]: record["word"] for record in records}
    wrong = "{source}, {label}: printed {printed}, {difference:+.3g} from a path that exists"
    lines = [
        _text(routes_table(pd.DataFrame(records))),
        "",
        *(f"{label}: {word}" for label, word in words.items()),
        *(wrong.format(**record) for record in records if record["verdict"] != "shortest"),
    ]
    return "\n".join(lines)


def _audit_paper(as_json: bool) -> list[str]:
    """Print the audit of the paper's tables.

    Returns a sentence for each contradiction with the committed audit.
    """
    from dubins_study.report.paper.audit import audit as recompute
    from dubins_study.report.paper.audit import contradictions
    from dubins_study.report.paper.printed import committed

    record = recompute()
    # Flush before the committed audit is read: stdout may be redirected into that file.
    if as_json:
        print(json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False), flush=True)
    else:
        print(audit_text(record), flush=True)
    return contradictions(record, committed())


def audit_text(record: Record) -> str:
    """The audit of the paper as text.

    The text tells how many printed lengths are right, and has the tables of the report.
    """
    from dubins_study.report.topics.audit_tables import audit_tables

    verdicts = Counter(cell["verdict"] for cell in record["cells"])
    counts = ", ".join(f"{number} {verdict}" for verdict, number in verdicts.most_common())
    first = f"{len(record['cells'])} printed lengths: {counts}"
    return "\n\n".join([first, *map(_text, audit_tables(record))])


def _text(content: Table) -> str:
    head = [column.title for column in content.columns]
    return f"{content.caption}\n{table(head, content.texts())}"
