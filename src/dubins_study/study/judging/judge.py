"""The check: a path judged from its controls alone, against its question's reference."""

from __future__ import annotations

from dubins_study.study.check.verdict import is_false, seen_of
from dubins_study.study.kinds.kind import Arrived
from dubins_study.study.kinds.table import kind_of
from dubins_study.study.path import Path, drivable
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, HEADED, Tolerances, allowed_miss
from dubins_study.study.words import Claim, Verdict


def judge(
    scenario: Scenario,
    path: Path | None,
    claim: Claim = Claim.NONE,
    branch: str = "best",
    tolerances: Tolerances = DEFAULT,
) -> Judgement:
    """Judge a path, or its absence, for a question.

    Nothing that the solver reports enters but its controls and, for `false_claim` and the
    verdict `none exists`, its claim.
    """
    kind = kind_of(scenario, branch)
    known = kind.known(scenario, branch)
    if path is None or not drivable(path):
        verdict = Verdict.NONE if path is None else Verdict.MISSES
        # the best path always exists, and nothing has to be searched for
        denied = path is None and claim is Claim.INFEASIBLE and branch != "best"
        if denied and kind.reference(scenario, branch, tolerances).enclosure.absent:
            verdict = Verdict.NONE_EXISTS
        return Judgement(verdict=verdict, false_claim=is_false(claim, verdict), **known)
    seen = seen_of(scenario, path, branch, tolerances, kind.visits)
    length = path.length
    word = kind.words_of(path, seen.visits.at, scenario.radius)
    verdict = Verdict.MISSES
    if seen.arrives and seen.excess <= tolerances.curvature and path.start == scenario.start:
        verdict, columns = kind.verdict(scenario, Arrived(path, branch, seen, word), tolerances)
        known = known | columns
    return Judgement(
        verdict=verdict,
        false_claim=is_false(claim, verdict),
        word=word,
        length=length,
        travel_time=length / scenario.speed,
        miss=seen.miss,
        visits=list(seen.visits.at) or None,
        curvature_excess=seen.excess,
        **known,
    )


def miss_reason(
    scenario: Scenario, path: Path, branch: str, tolerances: Tolerances = DEFAULT
) -> str:
    """What keeps a path whose verdict is `misses` from answering its question."""
    if not drivable(path):
        return "the path has a number that is not finite, or a length below 0"
    if path.start != scenario.start:
        return "the path starts elsewhere"
    radius = scenario.radius
    find_visits = kind_of(scenario, branch).visits
    seen = seen_of(scenario, path, branch, tolerances, find_visits)
    if seen.excess > tolerances.curvature:
        return f"the curvature is {seen.excess:.3g} / R beyond what the branch allows"
    if seen.miss > allowed_miss(tolerances.miss, radius, scenario.extent, path.length):
        if seen.visits.miss == seen.miss:
            return f"the path passes {seen.miss / radius:.3g} R from a via point, in their order"
        return f"the path ends {seen.miss / radius:.3g} R from the target"
    if seen.turned > HEADED and not seen.arrives:
        return f"the path ends {seen.turned:.3g} rad from the final heading"
    return "the path is too long to be driven to within a radius, or the branch has none"
