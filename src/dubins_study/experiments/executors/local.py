"""Solve chains of cells with a worker pool on this machine; judge the replies in this process."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager

from dubins_study.experiments.executors.executor import ChainState, Executor, Probe, WorkUnit
from dubins_study.experiments.executors.judging import row_of
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.messages import WorkerReply
from dubins_study.experiments.isolation.pool import Job, Limits, RunError, WorkerPool, worker_group
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.solvers.protocol import Question
from dubins_study.study.rows.row_table import Row


@contextmanager
def local_executor(jobs: int) -> Iterator[Executor]:
    """An executor with `jobs` worker processes here, which run while cells are solved."""

    def solve(
        unit: WorkUnit, stop: Interruption, probed: Probe | None
    ) -> Generator[list[Row], None, None]:
        pool_probed = None if probed is None else lambda seconds: probed(seconds, 0)
        with WorkerPool(jobs, limits(unit.settings), probed=pool_probed) as pool:
            try:
                yield from solve_chains(pool, unit, stop)
            except RunError as error:
                raise RunError(f"{error}; the rows written so far are kept") from None

    yield Executor(jobs, {}, solve)


def limits(settings: RunSettings) -> Limits:
    """The limits of each solve in a run, as a pool expects them."""
    return Limits(settings.time_limit_s, settings.memory_limit_bytes)


def solve_chains(
    pool: WorkerPool, unit: WorkUnit, stop: Interruption
) -> Generator[list[Row], None, None]:
    """Yield the judged rows of all cells as they come, and an empty list if none come for a while.

    After an interruption only the current solves are finished.

    Args:
        pool: solves the cells.
        unit: the cells.
        stop: read after every row.

    Raises:
        RunError: if worker processes end before their first job, or if the code of a solver differs
            from the code of its cells.
    """
    # Our own solvers first, then plug-in by plug-in, so that workers are rarely replaced.
    ordered = sorted(unit.chains, key=lambda chain: worker_group(chain[0].solver))
    jobs = (_job(ChainState(chain, 0, unit.before.get(chain[0].key))) for chain in ordered)
    for results in pool.solve(jobs, stop):
        rows = []
        for job, answer in results:
            state: ChainState = job.tag
            check_code(state.cell, answer, unit.settings.executor)
            row, path = row_of(state.cell, job.question.initial_guess, unit.settings, answer)
            rows.append(row)
            following = state.after(path)
            if following is not None:
                pool.put_first([_job(following)])
        yield rows


def _job(state: ChainState) -> Job:
    cell = state.cell
    question = Question(cell.scenario, cell.branch, state.initial_guess(), cell.repeat)
    return Job(cell.solver, cell.profile, question, state)


def check_code(cell: Cell, answer: WorkerReply, executor: str) -> None:
    """Refuse a reply whose code has another digest than its cell.

    Raises:
        RunError: naming the solver and both digests.
    """
    # A solver that loads on the asking machine but not on the Dask worker is different code too.
    known = answer.code_digest or executor != "local"
    if not answer.started or answer.code_digest == cell.code_digest:
        return
    if not (cell.code_digest and known):
        return
    digest = (
        f"is {answer.code_digest} now"
        if answer.code_digest
        else f"does not load: {answer.reply.solution.message}"
    )
    raise RunError(
        f"the code of {cell.solver} is not what was asked: its digest was {cell.code_digest} and "
        f"{digest}; its files, its settings or its libraries' versions differ"
    )
