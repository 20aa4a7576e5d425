"""Put cells or questions to workers on this machine.

The replies are judged in this process.
"""

from __future__ import annotations

import itertools
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from dubins_study.asking.attempt import Answer, judged
from dubins_study.asking.reply import Reply
from dubins_study.experiments.executors.executor import Executor, Probed, WorkUnit
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import Job, RunError, WorkerPool, worker_group
from dubins_study.experiments.isolation.process_state import THREADS
from dubins_study.experiments.plan.cells import Cell, given_guess
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.experiments.provenance import host, now
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import ours
from dubins_study.study.kinds.table import prepare
from dubins_study.study.path import Path
from dubins_study.study.rows.parts import Row
from dubins_study.study.rows.schema import KEY, names
from dubins_study.study.tolerances import tolerances

_KEY = names(KEY)
_ROUND = 500  # chains; a round replaces each worker once, some seconds in all


@contextmanager
def local_executor(jobs: int) -> Iterator[Executor]:
    """An executor with `jobs` worker processes here.

    The processes run only while cells are solved.
    """

    def solve(
        unit: WorkUnit, stop: Interruption, probed: Probed
    ) -> Generator[list[Row], None, None]:
        memory = unit.settings.memory_limit_gib
        with WorkerPool(jobs, memory, probed=lambda seconds: probed(seconds, 0)) as pool:
            yield from solve_chains(pool, unit, stop)

    yield Executor(jobs, {}, solve)


class _Step(NamedTuple):
    """A cell whose job is under way.

    The other fields are needed to go on with its chain.
    """

    cell: Cell
    following: Iterator[Cell]  # the cells of its chain behind it
    earlier_path: Path | None  # the last that arrived before this cell


def solve_chains(
    pool: WorkerPool, unit: WorkUnit, stop: Interruption
) -> Generator[list[Row], None, None]:
    """Yield the judged rows of cells as they come.

    The list is empty if none come for a while. Once a cell has its reply, the next cell of its
    chain is put first.
    """
    for chain in unit.chains:
        # compiles loops; in a worker the time limit would end that
        prepare(chain[0].scenario, chain[0].branch)
    for results in pool.solve(_first_jobs(unit), stop):
        rows = []
        for job, reply in results:
            step: _Step = job.tag
            check_code(step.cell, reply, unit.settings.executor)
            row = row_of(step.cell, job.question, unit.settings, reply)
            rows.append(row)
            path = step.earlier_path
            if row["gap"] is not None:  # the path of this cell arrived
                path = reply.solution.path
            pool.put_first(_next_job(step.following, path))
        yield rows


def _first_jobs(unit: WorkUnit) -> Iterator[Job]:
    """The jobs of the first cells of all chains."""
    # Within a round, cells of one group of workers follow each other: workers are rarely replaced.
    # In each round all solvers have their turn: a slow time of the machine concerns them all.
    for start in range(0, len(unit.chains), _ROUND):
        of_round = unit.chains[start : start + _ROUND]
        for chain in sorted(of_round, key=lambda chain: worker_group(chain[0].solver)):
            yield from _next_job(iter(chain), None)


def _next_job(cells: Iterator[Cell], path: Path | None) -> Iterator[Job]:
    """Yield the job of a chain's next cell.

    The cell is taken from `cells`; at the end of the chain there is none. `path` is the last path
    that arrived before it, from which a warm cell starts.
    """
    for cell in itertools.islice(cells, 1):
        guess = given_guess(cell)
        if cell.initial_guess == "warm":
            guess = path
        step = _Step(cell, cells, path)
        yield Job(cell.solver, cell.profile, cell.question(guess), cell.time_limit_s, step)


def check_code(cell: Cell, reply: Reply, executor: str) -> None:
    """Refuse a reply of other code than the cell's.

    Code is compared by its digest. A solve that did not start is not compared.
    """
    digest = reply.code_digest
    if not (reply.started and cell.code_digest) or digest == cell.code_digest:
        return
    # A solver that loads on the asking machine but not on the Dask worker is different code too.
    if not digest and executor == "local":
        return
    change = f"is {digest} now"
    if not digest:
        change = f"does not load: {reply.solution.message}"
    raise RunError(
        f"the code of {cell.solver} is not what was asked: its digest was {cell.code_digest} and "
        f"{change}; its files, its settings or its libraries' versions differ"
    )


def row_of(cell: Cell, question: Question, settings: RunSettings, reply: Reply) -> Row:
    """The row for a worker's reply to a cell."""
    row = judged(cell.solver, question, reply, tolerances(cell.profile), cell.method).row()
    row |= zip(_KEY, cell.key, strict=True)
    row |= {
        "versions": reply.versions,
        "machine": host(),
        "threads": THREADS,
        "jobs": settings.jobs,
        "limit_s": cell.time_limit_s,
        "floor_s": reply.floor_s,
        "memory_mib": reply.memory_mib,
        "executor": settings.executor,
        "run_id": settings.run_id,
        "started": reply.started or now(),
    }
    return row


def ask_isolated(
    solver: str, profile: str, questions: Iterable[Question], limit: float
) -> Iterator[Answer]:
    """Yield the judged answers to questions, in order.

    One worker is asked, and each answer is judged as in a run. `limit` is in seconds.
    """
    jobs = (Job(solver, profile, question, limit) for question in questions)
    allowed = tolerances(profile, limit)
    method = describe_solver(solver, profile).method
    # A warm-up loads the libraries, which are no part of the limit; a plug-in may hang in one.
    with WorkerPool(1, warm_up=ours(solver)) as pool:
        for results in pool.solve(jobs, Interruption()):
            for job, reply in results:  # in their order, as there is one worker
                yield judged(solver, job.question, reply, allowed, method)
