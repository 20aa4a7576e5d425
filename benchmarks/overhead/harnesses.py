"""The three harnesses, run over some cells.

Each runs in a folder of its own.

`python -m benchmarks.overhead.harnesses NAME CELLS FOLDER` runs one and prints the seconds of the
run and, of these, the solver's own, in which no harness has a part. Imports come before.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path as FilePath
from time import perf_counter
from typing import NamedTuple

from benchmarks.overhead import trivial

HERE = FilePath(__file__).parent
_SOLVER = f"{HERE / 'trivial.py'}:Trivial"
_EXPERIMENT = """
title = "What a cell costs"
question = "How long does the harness take beyond the solver?"
branches = ["best"]
solvers = ["analytic"]

[[scenarios]]
heading = {heading}
target_x = {{ linear = [{first}, {last}, {cells}] }}
target_y = {y}
radius = 1
"""


class Spent(NamedTuple):
    """Seconds of a run, and of its solver.

    The solver's seconds are those that the harness says.
    """

    whole: float
    solver: float


def _experiment(cells: int, folder: FilePath) -> FilePath:
    file = folder / "overhead.toml"
    text = _EXPERIMENT.format(
        heading=trivial.HEADING,
        first=trivial.FIRST,
        last=trivial.LAST,
        y=trivial.TARGET_Y,
        cells=cells,
    )
    file.write_text(text, encoding="utf-8")
    return file


def ours(cells: int, folder: FilePath) -> Spent:
    """`experiments.run`: worker process, check, certificate, rows, Parquet."""
    from dubins_study import run
    from dubins_study.experiments.store.folder import read_rows

    file = _experiment(cells, folder)
    began = perf_counter()
    run(file, folder / "results", solvers=[_SOLVER])
    whole = perf_counter() - began
    rows = read_rows(folder / "results", ["proof", "wall_s"]).to_pydict()
    if rows["proof"] != ["proved"] * cells:
        raise RuntimeError(f"our own harness did not find {cells} proven answers")
    return Spent(whole, sum(rows["wall_s"]))


def in_process(cells: int, folder: FilePath) -> Spent:
    """The same cells without a worker process.

    What remains is check, certificate, rows and one part.
    """
    from dubins_study.asking.reply import ask
    from dubins_study.experiments.executors.local import row_of
    from dubins_study.experiments.plan.run_plan import Request, RunSettings, plan_run
    from dubins_study.experiments.store.part_writer import write_part
    from dubins_study.solvers.registry import load
    from dubins_study.study.rows.parts import rows_table

    file = _experiment(cells, folder)
    began = perf_counter()
    groups = plan_run(Request(file, solvers=[_SOLVER])).chains
    solver = load(_SOLVER)
    shared = RunSettings("in-process", 60.0)
    answers = [ask(solver, group[0].question()) for group in groups]
    rows = [
        row_of(group[0], group[0].question(), shared, a)
        for group, a in zip(groups, answers, strict=True)
    ]
    (folder / "parts").mkdir()
    write_part(folder, "in-process", rows_table(rows))
    whole = perf_counter() - began
    return Spent(whole, sum(row["wall_s"] for row in rows))


def benchopt(cells: int, folder: FilePath) -> Spent:
    """benchopt's own runner.

    It has one job and no cache, runs each solver once, and draws no plots.
    """
    os.environ["OVERHEAD_CELLS"] = str(cells)
    import pandas as pd
    from benchopt import run_benchmark

    began = perf_counter()
    file = run_benchmark(
        HERE / "benchopt",
        n_jobs=1,
        n_repetitions=1,
        no_cache=True,
        plot_result=False,
        show_progress=False,
        output_file=str(folder / "results.parquet"),
    )
    whole = perf_counter() - began
    rows = pd.read_parquet(file)
    if len(rows) != cells:
        raise RuntimeError(f"benchopt made {len(rows)} rows of {cells}")
    return Spent(whole, float(rows["time"].sum()))


def qpbenchmark(cells: int, folder: FilePath) -> Spent:
    """qpbenchmark's own runner on quadratic programs.

    Their solution is where the path ends.
    """
    from qpbenchmark.results import Results
    from qpbenchmark.run import run

    from benchmarks.overhead.projections import Projections

    problems = Projections(cells)
    began = perf_counter()
    results = Results(folder / "results.parquet", problems)
    run(problems, results)
    whole = perf_counter() - began
    if not (len(results.df) == cells and results.df["found"].all()):
        raise RuntimeError(f"qpbenchmark found {results.df['found'].sum()} of {cells} solutions")
    return Spent(whole, float(results.df["runtime"].sum()))


HARNESSES: dict[str, Callable[[int, FilePath], Spent]] = {
    "ours": ours,
    "in process": in_process,
    "benchopt": benchopt,
    "qpbenchmark": qpbenchmark,
}


def main(name: str, cells: int, folder: FilePath) -> None:
    nowhere = StringIO()
    with redirect_stdout(nowhere), redirect_stderr(nowhere):
        spent = HARNESSES[name](cells, folder)
    print(*spent)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), FilePath(sys.argv[3]))
