"""One question, asked in a worker process of its own."""

from __future__ import annotations

from typing import Any

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.sandbox import pinned_threads
from dubins_study.experiments.isolation.supervisor import Supervisor
from dubins_study.experiments.isolation.watch import Bounds
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.experiments.run_settings import BYTES_PER_GIB, RunSettings
from dubins_study.solvers.attempt import (
    DEFAULT_LIMIT,
    Answer,
    Reply,
    check_request,
    judged,
    nothing,
    told,
)
from dubins_study.solvers.profiles import tolerances
from dubins_study.solvers.protocol import Outcome, Question
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

MEMORY = 4.0  # GiB


def solve_isolated(
    scenario: Scenario,
    solver: str,
    branch: str = "best",
    *,
    profile: str = "default",
    limit: float = DEFAULT_LIMIT,
    memory: float = MEMORY,
) -> Answer:
    """Solve one scenario as a run does: whatever the solver does to its process is an answer.

    Args and Raises as `solvers.solve`, where the caller's own process is asked; `memory` is in
    GiB. Interrupted once, it waits for the answer; twice, it does not.
    """
    check_request(branch, limit)
    tolerances(profile)
    describe_solver(solver, profile)
    cell = Cell("", solver, profile, branch, "cold", 0, "", scenario)
    settings = RunSettings("", limit, round(memory * BYTES_PER_GIB))
    bounds = Bounds(settings.time_limit_s, settings.memory_limit_bytes)
    asked = Supervisor(settings, bounds, 1, made=_answer, warm_up=False)
    with Interruption() as stop, pinned_threads(), asked as workers:
        found: list[Any] = [one for made in workers.solve([(cell,)], {}, stop) for one in made]
        stop.check()
    answer: Answer = found[0]
    return answer


def _answer(
    cell: Cell,
    initial_guess: Path | None,
    run: RunSettings,
    reply: Reply,
    started: str,
    versions: str,
) -> tuple[Answer, None]:
    question, profile = (
        Question(cell.scenario, cell.branch, initial_guess),
        tolerances(cell.profile),
    )
    try:
        return judged(cell.solver, question, reply, profile), None
    except Exception as error:  # a path that the check cannot drive, as in a run
        failed = nothing(Outcome.RAISED, told(error))
        return judged(cell.solver, question, failed, profile), None
