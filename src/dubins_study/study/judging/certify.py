"""How far the proof of an answer goes, from its controls, the scenario and a bound if there is one.

Pontryagin's conditions and the cut margin (`check.extremal`) prove that a path is the shortest to
its own end point. An interval around the reference length (`check.enclosure`) proves that no
shorter path answers the question.
"""

from __future__ import annotations

import math
from typing import Any

from dubins_study.study.check.certificate import (
    BOUND_TOLERANCE,
    BY_INTERVAL,
    PROOFS,
    proof_levels,
)
from dubins_study.study.check.extremal import Extremal
from dubins_study.study.kinds.kind import Costates
from dubins_study.study.kinds.table import kind_of
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, Tolerances
from dubins_study.study.words import Proof, Verdict


def certify(
    scenario: Scenario,
    path: Path | None,
    judged: Judgement,
    branch: str = "best",
    *,
    lower_bound: float | None = None,
    multipliers: tuple[float, float] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Certificate:
    """Certify an answer that has been judged.

    Args:
        scenario, branch: the question.
        path: its answer, or None.
        judged: its judgement by `study.judging.judge.judge`.
        lower_bound: a bound that the solver gives (length unit).
        multipliers: duals of the end point's equations that the solver gives.
        tolerances: those of the judgement.
    """
    kind = kind_of(scenario, branch)
    radius = scenario.radius
    arriving = None if judged.gap is None else judged.length
    bound = math.nan if lower_bound is None else lower_bound
    if kind.searched and arriving is None and math.isnan(bound):
        return Certificate(proof=Proof.NONE)  # nothing is said that would be worth a search
    costates, cut = Costates()
    if path is not None:
        costates, cut = kind.costates(scenario, path, judged, tolerances.until)
    if kind.enclosure is None:
        interval = kind.reference(scenario, branch, tolerances).enclosure
    else:
        interval = kind.enclosure(scenario, branch)
    scale = max(interval.low, radius)
    allowed = tolerances.gap * scale
    length = math.nan if judged.length is None else judged.length
    false_bound = bound > interval.highest(arriving) + BOUND_TOLERANCE * scale
    levels = proof_levels(
        BY_INTERVAL if kind.by_interval else branch,
        judged.verdict is Verdict.OPTIMAL,
        judged.verdict is Verdict.NONE_EXISTS,
        arriving is not None,
        length,
        radius,
        math.nan if costates is None else costates.pmp_residual,
        math.nan if cut is None else cut,
        interval.low,
        interval.exists and interval.holds(length, allowed),
        math.nan if false_bound else bound,
        allowed,
    )
    return Certificate(
        proof=PROOFS[(*levels, True).index(True)],
        reference_low=_finite(interval.low),
        reference_high=_finite(interval.high),
        cut_margin=cut,
        false_bound=false_bound,
        **_columns(costates, multipliers),
    )


def _columns(costates: Extremal | None, multipliers: tuple[float, float] | None) -> dict[str, Any]:
    """What the costates are in a row's columns, and how far multipliers are from them."""
    if costates is None:
        return {}
    error = None
    if multipliers is not None and not costates.abnormal:
        x, y = costates.nu
        error = _finite(math.hypot(multipliers[0] + x, multipliers[1] + y))
    return {"costate_error": error, **costates._asdict()}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
