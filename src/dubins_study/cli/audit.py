"""`dubins-study audit`: the paper's tables and other published lengths, recomputed."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any

import typer

from dubins_study.cli.terminal.arguments import CommandError, Json
from dubins_study.cli.terminal.output import table

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
    raise typer.Exit(1 if audits[source](as_json) else 0)


def _audit_kaya(as_json: bool) -> bool:
    """Print the audit of Kaya's routes; whether it is another than the committed one."""
    from dubins_study.experiments.definition.experiment import read
    from dubins_study.experiments.plan.scenario_columns import scenarios
    from dubins_study.report.paper.routes import audit_routes

    blocks = read("kaya").experiment.scenarios
    routes = [scenario for block in blocks for scenario in scenarios(block, block.label)]
    records = audit_routes(routes)
    exact = [
        record | {name: repr(record[name]) for name in ("length", "low", "high")}
        for record in records
    ]
    text = "\n".join([_table(_ROUTES, exact), "", *_route_lines(records)])
    print(json.dumps(records, indent=1, allow_nan=False) if as_json else text, flush=True)
    contradicted = [record for record in records if record["verdict"] != record["expected"]]
    for record in contradicted:
        place = "contradiction: {source}, {label}: {verdict}, not {expected}".format(**record)
        print(f"dubins-study: {place}", file=sys.stderr)
    return bool(contradicted)


def _route_lines(records: Sequence[Record]) -> Iterator[str]:
    """The shortest path of each route, and what is wrong with a published length."""
    for record in {record["label"]: record for record in records}.values():
        yield "{label}: {word}".format(**record)
    for record in records:
        if record["verdict"] != "shortest":
            line = "{source}, {label}: printed {printed}, {difference:+.3g} from a path that exists"
            yield line.format(**record)


def _audit_paper(as_json: bool) -> bool:
    """Print the audit of the paper's tables; whether it contradicts the committed one."""
    from dubins_study.report.paper.audit import audit as recompute
    from dubins_study.report.paper.audit import contradictions
    from dubins_study.report.paper.printed import committed

    record = recompute()
    # Flush before the committed audit is read: stdout may be redirected into that file.
    committed_form = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    print(committed_form if as_json else audit_text(record), flush=True)
    lines = contradictions(record, committed())
    if lines:
        print(
            "dubins-study: the code contradicts the committed audit:",
            *lines,
            sep="\n",
            file=sys.stderr,
        )
    return bool(lines)


# Titles of columns -> keys of the records below them.
_CELLS = {
    "table": "table",
    "scenario": "label",
    "path": "path",
    "cell": "quantity",
    "printed": "printed",
    "exact": "exact",
    "printed - exact": "difference",
    "verdict": "verdict",
}
_ROUTES = {
    "source": "source",
    "route": "label",
    "legs": "legs",
    "printed": "printed",
    "ours": "length",
    "proven: at least": "low",
    "at most": "high",
    "printed - ours": "difference",
    "verdict": "verdict",
}
_TIMES = {
    "scenario": "label",
    "path": "path",
    "seconds": "printed",
    "ticks": "ticks",
    "rounded to it": "is_ticks",
}


def audit_text(record: Record) -> str:
    """Every printed length and solve time, and the tables of the report."""
    from dubins_study.report.topics.audit import audit_tables

    summary = record["summary"]
    counts = ", ".join(f"{n} {verdict}" for verdict, n in summary["verdicts"].items() if n)
    lines = [
        f"{summary['cells']} printed lengths: {counts}",
        _table(_CELLS, record["cells"]),
        f"\n{summary['times_that_are_ticks']} of {len(record['times'])} printed solve times are "
        "whole ticks of a clock of 64 a second",
        _table(_TIMES, record["times"]),
    ]
    for each in audit_tables(record):
        titles = [column.title for column in each.columns]
        lines += [f"\n{each.caption}", table(titles, each.texts())]
    return "\n".join(lines)


def _table(columns: Mapping[str, str], records: Sequence[Record]) -> str:
    return table([*columns], [[record[key] for key in columns.values()] for record in records])
