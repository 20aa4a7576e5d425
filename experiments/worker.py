"""What one process does: solve chains of cells and hand back their rows."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import NamedTuple

from experiments.grid import Cell, Chain, given_start
from experiments.interruption import ignore_interrupts
from experiments.provenance import host, now, versions
from experiments.rows import Row, fitting, raised_row
from solvers.answer import attempt
from solvers.profiles import tolerances
from solvers.protocol import AnySolver, Question
from solvers.registry import load
from study.path import Path
from study.scenario import Scenario
from study.schema import KEY, SCENARIO, names

# an easy question, asked once of every solver before its first recorded answer
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")

THREADS = 1


class Run(NamedTuple):
    """What every row of a run shares."""

    run_id: str
    limit: float
    jobs: int
    engine: str = "local"


_VARIABLES = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL"))


def pin_threads() -> None:
    """Keep every numerical library of this process, loaded or not, to one thread for good."""
    from threadpoolctl import threadpool_limits

    os.environ.update(dict.fromkeys(_VARIABLES, str(THREADS)))
    threadpool_limits(THREADS)


def start_worker() -> None:
    """Make a process of its own ready to solve chains."""
    ignore_interrupts()
    pin_threads()


@contextmanager
def pinned_threads() -> Iterator[None]:
    """The same for a while: the caller's own settings come back."""
    from threadpoolctl import threadpool_limits

    before = {name: os.environ.get(name) for name in _VARIABLES}
    os.environ.update(dict.fromkeys(_VARIABLES, str(THREADS)))
    try:
        with threadpool_limits(THREADS):
            yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def solve_chain(chain: Chain, run: Run, start: Path | None = None) -> Iterator[Row]:
    """Attempt the cells of a chain one after another; their rows as they come.

    Args:
        chain: a single cell, or a sweep whose warm cells each start from the path before.
        run: what the rows share.
        start: path before the first cell, if an earlier run has got so far.
    """
    for cell in chain:
        given = start if cell.start == "warm" else given_start(cell)
        row, path = solve_cell(cell, run, given)
        # after a failure the last path that was found serves on
        start = path or start
        yield row


def solve_whole_chain(chain: Chain, run: Run, start: Path | None) -> list[Row]:
    """The same in another process, which can only hand back the finished chain."""
    return list(solve_chain(chain, run, start))


def solve_cell(cell: Cell, run: Run, start: Path | None) -> tuple[Row, Path | None]:
    """Attempt one cell; its row, and its path if it arrived."""
    known = dict(zip(names(KEY), cell.key, strict=True))
    known |= {name: getattr(cell.scenario, name) for name in names(SCENARIO)}
    known |= shared(cell, run, now())
    try:
        solver = _ready(cell.solver, cell.profile)
        known["started"] = now()
        question = Question(cell.scenario, cell.branch, start)
        answer = attempt(solver, question, run.limit, tolerances(cell.profile), cell.solver)
        row = fitting(answer.row() | known)
    except Exception as error:  # a plug-in that breaks more than its own calls is a row too
        return fitting(raised_row(known, f"{type(error).__name__}: {error}")), None
    return row, answer.path if row["gap"] is not None else None


def shared(cell: Cell, run: Run, started: str) -> Row:
    """The columns that tell where a row came from."""
    return {
        "versions": _versions(cell.solver),
        "host": host(),
        "threads": THREADS,
        "jobs": run.jobs,
        "engine": run.engine,
        "run_id": run.run_id,
        "started": started,
    }


@lru_cache(maxsize=256)
def _ready(spec: str, profile: str) -> AnySolver:
    """A solver that has its imports, templates and caches behind it."""
    solver = load(spec, profile)
    attempt(solver, Question(_WARM_UP, solver.branches[0]))
    return solver


@lru_cache(maxsize=256)
def _versions(spec: str) -> str:
    return json.dumps(versions(tuple(load(spec).packages)))
