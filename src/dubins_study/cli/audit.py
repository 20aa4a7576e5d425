"""`dubins-study audit`: the paper's tables, recomputed."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from dubins_study.cli.terminal.table import table

Record = dict[str, Any]


def audit(
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Recompute the paper's printed tables.

    Exit code 1 if the code contradicts the committed audit.
    """
    from dubins_study.report.paper.audit import audit as recompute
    from dubins_study.report.paper.audit import contradictions
    from dubins_study.report.paper.audit_file import committed

    record = recompute()
    # Flush before the committed audit is read: stdout may be redirected into that file.
    committed_form = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    print(committed_form if as_json else audit_text(record), flush=True)
    lines = contradictions(record, committed())
    for line in lines:
        print(f"dubins-study: contradiction: {line}", file=sys.stderr)
    raise typer.Exit(1 if lines else 0)


def audit_text(record: Record) -> str:
    """Every part as a table or a list, below a line with its summary."""
    summary = record["summary"]
    counts = [f"{n} {verdict}" for verdict, n in summary["verdicts"].items() if n]
    parts = (
        (f"{summary['cells']} printed lengths: {', '.join(counts)}", _cells(record["cells"])),
        (
            "The cells that are not correct roundings (the solver bias would print "
            f"{summary['correct_cells_that_the_bias_would_spoil']} of the correct ones otherwise)",
            _reasons(record["cells"]),
        ),
        (
            f"The printed paths, driven: {summary['paths_beyond_rounding']} miss by more than "
            f"rounding allows, {summary['totals_that_do_not_add_up']} do not add up",
            _paths(record["paths"]),
        ),
        (
            "Algorithm 1 where a turning circle of radius R* has reached the target: just beyond, "
            "and at a round radius",
            _algorithm(record["algorithm"]),
        ),
        (
            f"{summary['omitted_paths']} paths that the tables leave out",
            _omitted(record["omitted"]),
        ),
        (
            f"{summary['times_that_are_ticks']} of {len(record['times'])} printed solve times are "
            "whole ticks of a clock of 64 a second",
            _times(record["times"]),
        ),
        ("Statements", _statements(record["statements"])),
    )
    return "\n\n".join(f"{title}\n{body}" for title, body in parts)


def _cells(cells: Sequence[Record]) -> str:
    head = ("table", "scenario", "path", "cell", "printed", "exact", "printed - exact", "verdict")
    keys = ("table", "label", "path", "quantity", "printed", "exact")
    rows = [
        (*(cell[key] for key in keys), f"{cell['difference']:+.6f}", cell["verdict"])
        for cell in cells
    ]
    return table(head, rows)


def _reasons(cells: Sequence[Record]) -> str:
    from dubins_study.report.paper.audit_file import CORRECT

    return "\n".join(
        f"  {cell['table']} {cell['label']}, {cell['path']}, {cell['quantity']} = "
        f"{cell['printed']}: {cell['verdict']}; {cell['reason']}"
        for cell in cells
        if cell["verdict"] != CORRECT
    )


def _paths(paths: Sequence[Record]) -> str:
    head = ("table", "scenario", "path", "word", "miss", "allowed", "sum of parts", "total", "")
    keys = ("table", "label", "path", "word")
    rows = [
        (
            *(path[key] for key in keys),
            *(f"{path[key]:.4f}" for key in ("miss", "rounding_allows")),
            path["sum_of_parts"],
            path["total"],
            "" if path["adds_up"] else "does not add up",
        )
        for path in paths
    ]
    return table(head, rows)


def _algorithm(crossings: Sequence[Record]) -> str:
    head = ("scenario", "circle", "R*", "optimum", "length", "returns", "length", "too long")
    rows = [
        (
            c["label"],
            f"{c['circle']}, {c['half']}",
            f"{float(c['radius']):.6f}",
            c["word_beyond"],
            f"{c['length_beyond']:.4f}",
            c["algorithm_word"],
            f"{c['algorithm_length']:.4f}",
            f"{c['algorithm_excess']:.1%}; {c['example_excess']:.1%} at R = {c['example_radius']}",
        )
        for c in crossings
    ]
    return table(head, rows)


def _omitted(paths: Sequence[Record]) -> str:
    keys = ("label", "path", "word", "z1", "z2", "z3", "f")
    return table(("scenario", *keys[1:]), [[path[key] for key in keys] for path in paths])


def _times(times: Sequence[Record]) -> str:
    rows = [
        (t["label"], t["path"], t["printed"], str(t["ticks"]), "yes" if t["is_ticks"] else "no")
        for t in times
    ]
    return table(("scenario", "path", "seconds", "ticks", "rounded to it"), rows)


def _statements(statements: Sequence[Record]) -> str:
    return "\n".join(
        f"  {s['where']}: {s['says']}: {'right' if s['holds'] else 'wrong or incomplete'}; "
        f"{s['finding']}"
        for s in statements
    )
