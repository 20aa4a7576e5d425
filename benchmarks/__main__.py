"""Run benchmarks and print one table.

They are the benchmarks named on the command line, or all.

`python -m benchmarks kernel frame` runs `bench_kernel.py` and `bench_frame.py`; with `--peers
FOLDER`, `route` and `pose` build peers from sources. Exit code 1 if a target is missed or a
benchmark fails, 2 if there is no benchmark of a name or no such folder.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks import harness
from benchmarks.harness import Measurement

HERE = Path(__file__).parent


def known() -> list[str]:
    """Names of the benchmarks there are."""
    return sorted(file.stem.removeprefix("bench_") for file in HERE.glob("bench_*.py"))


def run(name: str) -> Iterator[Measurement]:
    """Rows of one benchmark.

    One that fails is a row that says how.
    """
    try:
        yield from import_module(f"benchmarks.bench_{name}").measure()
    except Exception as error:  # the other benchmarks are still worth running
        yield Measurement(name, note=f"failed: {type(error).__name__}: {error}", failed=True)


def table(rows: list[Measurement]) -> Table:
    """The measurements as they are printed."""
    shown = Table("what", title="speed, ratios of times from one run")
    for heading in ("ours", "peer", "unit", "ratio", "target", "ok", "note"):
        justify = "left" if heading in ("unit", "note") else "right"
        shown.add_column(heading, justify=justify)
    for row in rows:
        sign = "≤" if row.at_most else "≥"
        target = "" if row.target is None else f"{sign} {row.target:g}"
        shown.add_row(
            row.what,
            _number(row.ours),
            _number(row.peer),
            row.unit,
            _number(row.ratio),
            target,
            {None: "–", True: "yes", False: "NO"}[row.ok],
            row.note,
        )
    return shown


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def main(arguments: list[str]) -> int:
    """Exit code."""
    parser = argparse.ArgumentParser(prog="benchmarks", description="Measure speed beside peers.")
    parser.add_argument("name", nargs="*", help=f"of {', '.join(known())}; all if none is given")
    parser.add_argument("--peers", type=Path, metavar="FOLDER", help="sources of peers")
    asked = parser.parse_args(arguments)
    if unknown := [name for name in asked.name if name not in known()]:
        parser.error(f"no benchmark {unknown[0]!r}; there are: {', '.join(known())}")
    if asked.peers is not None and not asked.peers.is_dir():
        parser.error(f"--peers {asked.peers}: no such folder")
    harness.peer_sources = asked.peers
    rows: list[Measurement] = []
    for name in asked.name or known():
        rows += run(name)
    # wide enough for every column where the output is a file
    width = None if sys.stdout.isatty() else 170
    Console(width=width).print(table(rows))
    return 1 if any(row.ok is False for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
