"""The distinct questions of an experiment, whoever answers them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

from dubins_study.asking.attempt import QuestionError, check_branch
from dubins_study.experiments.definition.experiment import Experiment, ExperimentError
from dubins_study.experiments.definition.scenario_block import Block
from dubins_study.experiments.plan.scenarios import scenario_id, scenarios
from dubins_study.study.scenario import Scenario


class Asked(NamedTuple):
    """A scenario, a branch and a time limit.

    The limit is the longest that any block gives the question.
    """

    scenario: Scenario
    branch: str
    time_limit_s: float


def asked_scenarios(block: Block, key: str, branches: Sequence[str]) -> list[Scenario]:
    """The scenarios of a block, checked for branches.

    If a scenario cannot have a branch, an ExperimentError names the block's `key` and the
    scenario's number.
    """
    block_scenarios = list(scenarios(block, key))
    for place, scenario in enumerate(block_scenarios):
        for branch in branches:
            try:
                check_branch(scenario, branch)
            except QuestionError as error:
                raise ExperimentError(f"{key}, scenario {place}: {error}") from None
    return block_scenarios


def questions(experiment: Experiment) -> dict[str, Asked]:
    """The questions by id, in the file's order.

    The id is that of the scenario and the branch, such as `0123456789abcdef-best`: it follows from
    what is asked, not from its place in the file.
    """
    by_id: dict[str, Asked] = {}
    for number, block in enumerate(experiment.scenarios):
        branches = block.branches or experiment.branches
        limit = block.time_limit_s or experiment.time_limit_s
        block_scenarios = asked_scenarios(block, f"scenarios.{number}", branches)
        for scenario, branch in product(block_scenarios, branches):
            id_ = f"{scenario_id(scenario)}-{branch}"
            # several blocks may have the same question: the longest limit counts
            earlier = by_id.get(id_, Asked(scenario, branch, limit))
            by_id[id_] = earlier._replace(time_limit_s=max(limit, earlier.time_limit_s))
    return by_id
