"""How far the proof of an answer goes, from its controls, the scenario and a bound if there is one.

Pontryagin's conditions and the cut margin (`extremal`) prove that a path is the shortest to its own
end point. An interval around the reference length (`enclosure`) proves that no shorter path answers
the question.
"""

from __future__ import annotations

import math
from typing import Any

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.extremal import Extremal, measure
from dubins_study.study.check.reference import reference_of
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import DEFAULT, Tolerances
from dubins_study.study.words import Proof, Verdict

PROOFS = tuple(Proof)
# A solver's 1e-8 on lengths leaves angles off by about as much; the turn of 1e-3 that an
# interior-point method adds to a segment leaves its square, 1e-6 (docs/derivation.md, section 9).
PMP_TOLERANCE = 1e-7
# nu3 sums products of the costates with positions, which loses this much for every radius of length
PMP_ROUNDING = 16 * EPS
# branch whose proof needs no costates: for `proof_levels`, of routes and given final headings too
BY_INTERVAL = "LR"
# rad: at the tie straight behind the margin is zero up to rounding
CUT_TOLERANCE = 1e-9
# relative: a bound above the shortest length by less is so by the solver's own tolerance
BOUND_TOLERANCE = 1e-9


def proof_levels(
    branch: str,
    optimal: Any,
    none_exists: Any,
    arrives: Any,
    length: Any,
    radius: Any,
    residual: Any,
    cut: Any,
    low: Any,
    near: Any,
    bound: Any,
    allowed: Any,
) -> tuple[Any, Any, Any]:
    """Whether answers are proved, bounded and extremals, in this order of precedence.

    Plain operators only, which serve one answer and arrays alike.

    Args:
        branch: of the question; `BY_INTERVAL` where the interval alone proves the shortest path.
        optimal, none_exists: whether the verdict is this.
        arrives: whether the path does.
        length, radius: of the path and of its turns; NaN where there is no path.
        residual: of Pontryagin's conditions; NaN where unknown.
        cut: margin (rad); NaN where unknown.
        low: of the proven interval around the shortest length.
        near: whether that interval is finite and the length within `allowed` of it. An answer far
            below it owes that to its miss, and proves nothing.
        bound: the solver's own; NaN if it is false, since then it contradicts the answer.
        allowed: tolerance of lengths.
    """
    tolerance = PMP_TOLERANCE + PMP_ROUNDING * length / radius
    # a path of no length has no costates, and needs none
    is_extremal = arrives & ((length == 0) | (residual <= tolerance))
    clear = (cut >= -CUT_TOLERANCE) | (branch != "best")
    near = arrives & near
    proved = near & optimal & ((is_extremal & clear) | (branch in ("LR", "RL")))
    no_path = none_exists & (low == math.inf)
    return proved | no_path, near & (abs(length - bound) <= allowed), is_extremal


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
        judged: its judgement by `study.check.verdict.judge`.
        lower_bound: a bound that the solver gives (length unit).
        multipliers: duals of the end point's equations that the solver gives.
        tolerances: those of the judgement.
    """
    radius, free_leg = scenario.radius, scenario.one_free_leg
    arriving = None if judged.gap is None else judged.length
    bound = math.nan if lower_bound is None else lower_bound
    if scenario.via and arriving is None and math.isnan(bound):
        return Certificate(proof=Proof.NONE)  # nothing is said that would be worth a search
    costates: Extremal | None = None
    cut: float | None = None
    if path is not None and (judged.length if free_leg else arriving) is not None:
        free = scenario.final_heading is None
        if scenario.via:
            # SciPy's linear programs, which one leg needs none of
            from dubins_study.study.check.route_extremal import route_extremal

            visits = judged.visits or ()
            costates = route_extremal(path, visits, radius, free, tolerances.until)
        else:
            costates, cut = measure(path, radius, free)
    if free_leg:
        interval = enclose(scenario, branch)
    else:
        interval = reference_of(scenario, branch, tolerances).enclosure
    scale = max(interval.low, radius)
    allowed = tolerances.gap * scale
    length = math.nan if judged.length is None else judged.length
    false_bound = bound > interval.highest(arriving) + BOUND_TOLERANCE * scale
    levels = proof_levels(
        branch if free_leg else BY_INTERVAL,
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
