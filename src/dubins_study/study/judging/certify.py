"""Certify how far the proof of an answer goes.

The certificate needs the answer's controls, the scenario, and a bound if there is one.

Pontryagin's conditions and the cut margin (`check.extremal`) prove that a path is the shortest to
its own end point. An interval around the reference length (`check.enclosure`) proves that no
shorter path answers the question.
"""

from __future__ import annotations

import math
from typing import Any

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.extremal import Extremal
from dubins_study.study.kinds.kind import Costates
from dubins_study.study.kinds.table import kind_of
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, Tolerances
from dubins_study.study.words import Proof, Verdict

# A solver's tolerance of 1e-8 on lengths causes errors of about that size in angles. A turn of 1e-3
# that an interior-point method adds to a segment causes its square, 1e-6 (docs/derivation.md,
# section 9).
PMP_TOLERANCE = 1e-7
# nu3 sums products of the costates with positions, which loses this much for every radius of length
PMP_ROUNDING = 16 * EPS
# rad: at the tie straight behind the margin is zero up to rounding
CUT_TOLERANCE = 1e-9
# relative: a bound may be above the shortest length by this much, by the solver's own tolerance
_BOUND_TOLERANCE = 1e-9
# words of which the interval alone proves the shortest path
_BY_INTERVAL = ("LR", "RL")


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
    arriving = None
    if judged.gap is not None:
        arriving = judged.length
    bound = math.nan
    if lower_bound is not None:
        bound = lower_bound
    if kind.searched and arriving is None and math.isnan(bound):
        return Certificate(proof=Proof.NONE)  # no answer and no bound that would be worth a search
    costates, cut = Costates()
    if path is not None:
        costates, cut = kind.costates(scenario, path, judged, tolerances.until)
    interval = kind.reference(scenario, branch, tolerances).enclosure
    scale = max(interval.low, radius)
    allowed = tolerances.gap * scale
    false_bound = bound > interval.highest(arriving) + _BOUND_TOLERANCE * scale
    proof = Proof.NONE
    if judged.verdict is Verdict.NONE_EXISTS and interval.low == math.inf:
        proof = Proof.PROVED
    elif arriving is not None:
        residual = math.inf
        if costates is not None:
            residual = costates.pmp_residual
        rounding = PMP_ROUNDING * (arriving / radius)
        extremal = arriving == 0 or residual <= PMP_TOLERANCE + rounding
        near = interval.exists and interval.holds(arriving, tolerance=allowed)
        clear = branch != "best" or (cut is not None and cut >= -CUT_TOLERANCE)
        alone = kind.by_interval or branch in _BY_INTERVAL
        if near and judged.verdict is Verdict.OPTIMAL and (alone or (extremal and clear)):
            proof = Proof.PROVED
        elif near and not false_bound and abs(arriving - bound) <= allowed:
            proof = Proof.BOUNDED
        elif extremal:
            proof = Proof.EXTREMAL
    return Certificate(
        proof=proof,
        reference_low=_finite(interval.low),
        reference_high=_finite(interval.high),
        cut_margin=cut,
        false_bound=false_bound,
        **_columns(costates, multipliers),
    )


def _columns(costates: Extremal | None, multipliers: tuple[float, float] | None) -> dict[str, Any]:
    """Columns of a row about the costates.

    `costate_error` is the distance of the solver's multipliers from -(nu1, nu2). There are no
    columns if the costates are unknown.
    """
    if costates is None:
        return {}
    error = None
    if multipliers is not None and not costates.abnormal:
        x, y = costates.nu
        error = _finite(math.hypot(multipliers[0] + x, multipliers[1] + y))
    return {"costate_error": error, **costates._asdict()}


def _finite(value: float) -> float | None:
    if not math.isfinite(value):
        return None
    return value
