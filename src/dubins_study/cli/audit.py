"""`dubins-study audit`: the paper's tables and other published lengths, recomputed."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
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
    text = _table(_ROUTES, records) + "\n\n" + "\n".join(_route_lines(records))
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
    for line in lines:
        print(f"dubins-study: contradiction: {line}", file=sys.stderr)
    return bool(lines)


# column titles and the format of a record's values below them
_CELLS = (
    *(("table", "{table}"), ("scenario", "{label}"), ("path", "{path}"), ("cell", "{quantity}")),
    *(("printed", "{printed}"), ("exact", "{exact}")),
    *(("printed - exact", "{difference:+.6f}"), ("verdict", "{verdict}")),
)
_PATHS = (
    *(("table", "{table}"), ("scenario", "{label}"), ("path", "{path}"), ("word", "{word}")),
    *(("miss", "{miss:.4f}"), ("allowed", "{rounding_allows:.4f}")),
    *(("sum of parts", "{sum_of_parts}"), ("total", "{total}"), ("adds up", "{adds_up}")),
)
_ALGORITHM = (
    *(("scenario", "{label}"), ("circle", "{circle}, {half}"), ("R*", "{radius:.6f}")),
    *(("optimum", "{word_beyond}"), ("length", "{length_beyond:.4f}")),
    *(("returns", "{algorithm_word}"), ("length", "{algorithm_length:.4f}")),
    ("too long", "{algorithm_excess:.1%}; {example_excess:.1%} at R = {example_radius}"),
)
_OMITTED = (
    ("scenario", "{label}"),
    *((key, f"{{{key}}}") for key in ("path", "word", "z1", "z2", "z3", "f")),
)
_ROUTES = (
    *(("source", "{source}"), ("route", "{label}"), ("legs", "{legs}"), ("printed", "{printed}")),
    *(("ours", "{length!r}"), ("proven: at least", "{low!r}"), ("at most", "{high!r}")),
    *(("printed - ours", "{difference:+.2g}"), ("verdict", "{verdict}")),
)
_TIMES = (
    *(("scenario", "{label}"), ("path", "{path}"), ("seconds", "{printed}")),
    *(("ticks", "{ticks}"), ("rounded to it", "{is_ticks}")),
)


def audit_text(record: Record) -> str:
    """Every part as a table or a list, below a line with its summary."""
    from dubins_study.report.paper.printed import CORRECT

    summary = record["summary"]
    counts = ", ".join(f"{n} {verdict}" for verdict, n in summary["verdicts"].items() if n)
    reasons = (
        f"  {cell['table']} {cell['label']}, {cell['path']}, {cell['quantity']} = "
        f"{cell['printed']}: {cell['verdict']}; {cell['reason']}"
        for cell in record["cells"]
        if cell["verdict"] != CORRECT
    )
    crossings = [each | {"radius": float(each["radius"])} for each in record["algorithm"]]
    statements = (
        f"  {s['where']}: {s['says']}: {'right' if s['holds'] else 'wrong or incomplete'}; "
        f"{s['finding']}"
        for s in record["statements"]
    )
    parts = (
        (f"{summary['cells']} printed lengths: {counts}", _table(_CELLS, record["cells"])),
        (
            "The cells that are not correct roundings (the solver bias would print "
            f"{summary['correct_cells_that_the_bias_would_spoil']} of the correct ones otherwise)",
            "\n".join(reasons),
        ),
        (
            f"The printed paths, driven: {summary['paths_beyond_rounding']} miss by more than "
            f"rounding allows, {summary['totals_that_do_not_add_up']} do not add up",
            _table(_PATHS, record["paths"]),
        ),
        (
            "Algorithm 1 where a turning circle of radius R* has reached the target: just beyond, "
            "and at a round radius",
            _table(_ALGORITHM, crossings),
        ),
        (
            f"{summary['omitted_paths']} paths that the tables leave out",
            _table(_OMITTED, record["omitted"]),
        ),
        (
            f"{summary['times_that_are_ticks']} of {len(record['times'])} printed solve times are "
            "whole ticks of a clock of 64 a second",
            _table(_TIMES, record["times"]),
        ),
        ("Statements", "\n".join(statements)),
    )
    return "\n\n".join(f"{title}\n{body}" for title, body in parts)


def _table(columns: Sequence[tuple[str, str]], records: Sequence[Record]) -> str:
    words = {True: "yes", False: "no"}
    rows = []
    for record in records:
        shown = {k: words[v] if isinstance(v, bool) else v for k, v in record.items()}
        rows.append([text.format(**shown) for _, text in columns])
    return table([title for title, _ in columns], rows)
