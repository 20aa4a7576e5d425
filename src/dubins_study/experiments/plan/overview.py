"""What an experiment asks, counted without listing its cells."""

from __future__ import annotations

from typing import NamedTuple

from dubins_study.experiments.definition.experiment import ExperimentFile
from dubins_study.experiments.plan.block_plan import block_plans
from dubins_study.experiments.plan.scenario_columns import block_size


class Overview(NamedTuple):
    """An experiment in numbers.

    Args:
        name, title, question: as its file has them.
        scenarios: how many there are, counted once for every block that asks about them.
        cells: questions times solvers and repeats; each becomes a row.
        solvers: the canonical specs, each once.
        branches: the branches that are asked for.
        repeats: how often each question is asked.
        time_limit_s: seconds that one solve may take.
        memory_limit_gib: GiB that one solve may hold.
        profile: name of the settings and tolerances.
    """

    name: str
    title: str
    question: str
    scenarios: int
    cells: int
    solvers: tuple[str, ...]
    branches: tuple[str, ...]
    repeats: int
    time_limit_s: float
    memory_limit_gib: float
    profile: str


def overview(file: ExperimentFile) -> Overview:
    """An experiment in numbers.

    Raises:
        ExperimentError, SolverError: if it is too large, or names a solver that does not exist.
    """
    experiment, plans = file.experiment, block_plans(file.experiment)
    cells = 0
    for plan in plans:
        solver_guesses = sum(map(plan.guess_count, plan.solvers))
        cells += block_size(plan.block) * len(plan.branches) * plan.repeats * solver_guesses
    specs = (solver.spec for p in plans for solver in p.solvers)
    return Overview(
        name=file.name,
        title=experiment.title,
        question=experiment.question,
        scenarios=sum(block_size(block) for block in experiment.scenarios),
        cells=cells,
        solvers=tuple(dict.fromkeys(specs)),
        branches=tuple(dict.fromkeys(branch for p in plans for branch in p.branches)),
        repeats=experiment.repeats,
        time_limit_s=experiment.time_limit_s,
        memory_limit_gib=experiment.memory_limit_gib,
        profile=experiment.profile,
    )
