"""How far the proof of an answer goes, from its controls, the scenario and a bound if there is one.

Pontryagin's conditions and the cut margin (`extremal`) prove that a path is the shortest to its own
end point. An interval around the reference length (`enclosure`) proves that no shorter path answers
the question.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.extremal import Extremal, measure
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Proof, Verdict

_DEFAULT = Tolerances()
_PROOFS = tuple(Proof)
# A solver's 1e-8 on lengths leaves angles off by about as much; the turn of 1e-3 that an
# interior-point method adds to a segment leaves its square, 1e-6 (docs/derivation.md, section 9).
PMP_TOLERANCE = 1e-7
# nu3 sums products of the costates with positions, which loses this much for every radius of length
PMP_ROUNDING = 16 * EPS
# rad: at the tie straight behind the margin is zero up to rounding
CUT_TOLERANCE = 1e-9
# relative: a bound above the shortest length by less is so by the solver's own tolerance
BOUND_TOLERANCE = 1e-9


class Evidence(NamedTuple):
    """What a proof rests on: numbers of one answer, or arrays of a frame's; NaN where unknown."""

    optimal: Any  # the verdict
    none_exists: Any  # the verdict
    arrives: Any
    length: Any
    residual: Any  # of Pontryagin's conditions
    cut: Any  # margin, rad
    low: Any  # of the proven interval around the shortest length
    # The interval is finite, and the length within `allowed` of it: an answer far below it owes
    # that to its miss, and proves nothing.
    near: Any
    bound: Any  # the solver's own, unless it is false: then it contradicts the answer
    allowed: Any
    radius: Any


def proof_levels(found: Evidence, branch: str) -> tuple[Any, Any, Any]:
    """Whether answers are proved, bounded and extremals, in this order of precedence.

    Plain operators only, which serve one answer and arrays alike.
    """
    tolerance = PMP_TOLERANCE + PMP_ROUNDING * found.length / found.radius
    # a path of no length has no costates, and needs none
    is_extremal = found.arrives & ((found.length == 0) | (found.residual <= tolerance))
    clear = (found.cut >= -CUT_TOLERANCE) | (branch != "best")
    near = found.arrives & found.optimal & found.near
    proved = near & ((is_extremal & clear) | (branch in ("LR", "RL")))
    no_path = found.none_exists & (found.low == math.inf)
    return proved | no_path, near & (abs(found.length - found.bound) <= found.allowed), is_extremal


def certify(
    scenario: Scenario,
    path: Path | None,
    judged: Judgement,
    branch: str = "best",
    *,
    lower_bound: float | None = None,
    multipliers: tuple[float, float] | None = None,
    tolerances: Tolerances = _DEFAULT,
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
    radius = scenario.radius
    interval = enclose(scenario, branch)
    costates, cut = None, None
    if path is not None and judged.length is not None:
        costates, cut = measure(path, radius)
    scale = max(interval.low, radius)
    allowed = tolerances.gap * scale
    length = math.nan if judged.length is None else judged.length
    arriving = None if judged.gap is None else judged.length
    bound = math.nan if lower_bound is None else lower_bound
    false_bound = bound > interval.highest(arriving) + BOUND_TOLERANCE * scale
    found = Evidence(
        optimal=judged.verdict is Verdict.OPTIMAL,
        none_exists=judged.verdict is Verdict.NONE_EXISTS,
        arrives=arriving is not None,
        length=length,
        residual=math.nan if costates is None else costates.pmp_residual,
        cut=math.nan if cut is None else cut,
        low=interval.low,
        near=interval.exists and interval.holds(length, allowed),
        bound=math.nan if false_bound else bound,
        allowed=allowed,
        radius=radius,
    )
    levels = *proof_levels(found, branch), True
    return Certificate(
        proof=_PROOFS[levels.index(True)],
        reference_low=_finite(interval.low),
        reference_high=_finite(interval.high),
        cut_margin=cut,
        costate_error=None if costates is None else _costate_error(costates, multipliers),
        false_bound=false_bound,
        **({} if costates is None else costates._asdict()),
    )


def _costate_error(costates: Extremal, multipliers: tuple[float, float] | None) -> float | None:
    if costates.abnormal or multipliers is None:
        return None
    x, y = costates.nu
    return _finite(math.hypot(multipliers[0] + x, multipliers[1] + y))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
