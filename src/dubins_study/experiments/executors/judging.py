"""Replies become rows: judged here, in a process that no solver has touched."""

from __future__ import annotations

from dubins_study.experiments.isolation.messages import WorkerReply
from dubins_study.experiments.isolation.sandbox import THREADS
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.provenance import host, now
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.solvers.attempt import judged_row
from dubins_study.solvers.profiles import tolerances
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.reply import exception_text
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, raised_row
from dubins_study.study.rows.schema import KEY, SCENARIO, names

_KEY, _SCENARIO = names(KEY), names(SCENARIO)


def row_of(
    cell: Cell, initial_guess: Path | None, settings: RunSettings, answer: WorkerReply
) -> tuple[Row, Path | None]:
    """The row for a worker's reply to a cell, and the path if it reaches the target."""
    known = dict(zip(_KEY, cell.key, strict=True))
    known |= run_columns(settings, answer.started or now(), answer.versions)
    question = Question(cell.scenario, cell.branch, initial_guess, cell.repeat)
    try:
        allowed = tolerances(cell.profile)
        row = judged_row(cell.solver, question, answer.reply, allowed, cell.method)
    except Exception as error:  # the check cannot drive the path: recorded as a row too
        known |= {name: getattr(cell.scenario, name) for name in _SCENARIO}
        known |= cell.method.columns(question)
        return raised_row(known, exception_text(error)), None
    row.update(known)
    return row, answer.reply.solution.path if row["gap"] is not None else None


def run_columns(settings: RunSettings, started: str, versions: str) -> Row:
    """The columns that say in which run, when and where a row was solved."""
    return {
        "versions": versions,
        "machine": host(),
        "threads": THREADS,
        "jobs": settings.jobs,
        "executor": settings.executor,
        "run_id": settings.run_id,
        "started": started,
    }
