"""Convex problems frozen from routes.

The label names the problem. There is no path.
"""

from __future__ import annotations

from typing import Any

from dubins_study.study.kinds.kind import Pathless
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import FROZEN, Claim


def _judge(
    scenario: Scenario, point: Any, claim: Claim, tolerance: float
) -> tuple[Judgement, Certificate]:
    """Judge a point of the labelled problem."""
    from dubins_study.study.convex.proof import judge_convex  # loads SciPy and python-flint

    return judge_convex(scenario.label, point, claim, tolerance)


FROZEN_PROBLEM = Pathless(
    name=FROZEN,
    title="a frozen convex problem",
    fields={"order": False, "closed": False},
    branches=(FROZEN,),
    examples={
        "qp-50-survey-3-3": Scenario(target_x=14, target_y=2.5, via=[(2, 0), (14, 0)]),
        "qp-50-survey-4-1": Scenario(target_x=2, target_y=2.5, via=[(2, 0), (14, 0), (14, 2.5)]),
    },
    judge=_judge,
)
