"""The distinct questions of an experiment, whoever answers them."""

from __future__ import annotations

from typing import NamedTuple

from dubins_study.asking.attempt import QuestionError, check_branch
from dubins_study.experiments.definition.experiment import Experiment, ExperimentError
from dubins_study.experiments.plan.scenarios import scenario_id, scenarios
from dubins_study.study.scenario import Scenario


class Asked(NamedTuple):
    """A scenario, the branch that is asked for, and the longest time limit that it is given."""

    scenario: Scenario
    branch: str
    time_limit_s: float


def questions(experiment: Experiment) -> dict[str, Asked]:
    """The questions by their ids, in the order of the experiment's file.

    The id is that of the scenario and the branch, such as `0123456789abcdef-best`: it follows from
    what is asked, not from its place in the file.
    """
    asked: dict[str, Asked] = {}
    for number, block in enumerate(experiment.scenarios):
        key = f"scenarios.{number}"
        limit = block.time_limit_s or experiment.time_limit_s
        for place, scenario in enumerate(scenarios(block, key)):
            for branch in block.branches or experiment.branches:
                try:
                    check_branch(scenario, branch)
                except QuestionError as error:
                    raise ExperimentError(f"{key}, scenario {place}: {error}") from None
                id_ = f"{scenario_id(scenario)}-{branch}"
                earlier = asked.get(id_)
                longest = limit if earlier is None else max(limit, earlier.time_limit_s)
                asked[id_] = Asked(scenario, branch, longest)
    return asked
