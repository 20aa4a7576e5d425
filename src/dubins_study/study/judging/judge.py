"""Judge a path from its controls alone.

It is compared with its question's reference.
"""

from __future__ import annotations

from dubins_study.study.check.verdict import is_false, seen_of
from dubins_study.study.kinds.kind import Arrived
from dubins_study.study.kinds.table import kind_of
from dubins_study.study.path import Path, drivable
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, HEADED, Tolerances, allowed_miss
from dubins_study.study.words import DENIALS, Claim, Order, Verdict


def judge(
    scenario: Scenario,
    path: Path | None,
    claim: Claim = Claim.NONE,
    branch: str = "best",
    tolerances: Tolerances = DEFAULT,
) -> Judgement:
    """Judge a path, or its absence, for a question.

    The only reports of the solver that enter are its controls and, for `false_claim` and the
    verdict `none exists`, its claim.
    """
    kind = kind_of(scenario, branch)
    columns = kind.known(scenario, branch)
    if path is None or not drivable(path):
        verdict = Verdict.MISSES
        if path is None:
            verdict = Verdict.NONE
            # a denial of the best path is false, since one always exists: no reference is needed
            denied = claim in DENIALS and branch != "best"
            if denied and kind.reference(scenario, branch, tolerances).enclosure.absent:
                verdict = Verdict.NONE_EXISTS
        return Judgement(verdict=verdict, false_claim=is_false(claim, verdict), **columns)
    seen = seen_of(scenario, path, branch, tolerances)
    length = path.length
    # the ends of all legs but the last, which ends with the path
    ends = seen.visits.at[: scenario.legs - 1]
    word = kind.words_of(path, ends, scenario.radius)
    start_heading = None
    if scenario.heading is None:
        start_heading = path.start.heading
    visit_order = None
    if scenario.order is Order.FREE:
        visit_order = list(map(float, seen.visits.order))
    verdict = Verdict.MISSES
    if seen.arrives and seen.excess <= tolerances.curvature and scenario.starts(path.start):
        verdict, verdict_columns = kind.verdict(
            scenario, Arrived(path, branch, seen, word), tolerances
        )
        columns = columns | verdict_columns
    return Judgement(
        verdict=verdict,
        false_claim=is_false(claim, verdict),
        word=word,
        length=length,
        travel_time=length / scenario.speed,
        miss=seen.miss,
        visits=list(seen.visits.at) or None,
        visit_order=visit_order,
        start_heading=start_heading,
        curvature_excess=seen.excess,
        **columns,
    )


def miss_reason(
    scenario: Scenario, path: Path, branch: str, tolerances: Tolerances = DEFAULT
) -> str:
    """Reason for the verdict `misses` on a path."""
    if not drivable(path):
        return "the path has a number that is not finite, or a length below 0"
    if not scenario.starts(path.start):
        return "the path starts elsewhere"
    radius = scenario.radius
    seen = seen_of(scenario, path, branch, tolerances)
    if seen.excess > tolerances.curvature:
        return f"the curvature is {seen.excess:.3g} / R beyond what the branch allows"
    if seen.miss > allowed_miss(
        tolerances.miss, radius, extent=scenario.extent, length=path.length
    ):
        if seen.visits.miss == seen.miss:
            in_order = ""
            if scenario.order is Order.GIVEN:
                in_order = ", in their order"
            return f"the path passes {seen.miss / radius:.3g} R from a via point{in_order}"
        return f"the path ends {seen.miss / radius:.3g} R from the target"
    if seen.turned > HEADED:
        where = "the final heading"
        if seen.visits.turned == seen.turned:
            where = "the heading of a via point when it passes there"
        return f"the path is {seen.turned:.3g} rad from {where}"
    return "the path is too long to be driven to within a radius, or the branch has none"
