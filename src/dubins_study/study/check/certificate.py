"""How far the proof of an answer goes, from its controls, the scenario and a bound if there is one.

Pontryagin's conditions and the cut margin (`extremal`) prove that a path is the shortest to its own
end point. An interval around the reference length (`enclosure`) proves that no shorter path answers
the question.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.extremal import Extremal, measure
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Proof, Verdict

_DEFAULT = Tolerances()
# A solver's 1e-8 on lengths leaves angles off by about as much; the turn of 1e-3 that an
# interior-point method adds to a segment leaves its square, 1e-6 (docs/derivation.md, section 9).
PMP_TOLERANCE = 1e-7
# nu3 sums products of the costates with positions, which loses this much for every radius of length
PMP_ROUNDING = 16 * EPS
# rad: at the tie straight behind the margin is zero up to rounding
CUT_TOLERANCE = 1e-9
# relative: a bound above the shortest length by less is so by the solver's own tolerance
BOUND_TOLERANCE = 1e-9


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
    bound = None if lower_bound is None or math.isnan(lower_bound) else lower_bound
    arriving = None if judged.gap is None else judged.length
    false_bound = is_false_bound(bound, interval, scale, arriving)
    # a path of no length has no costates, and needs none
    residual = None if costates is None else costates.residual
    evidence = _Evidence(interval, 0.0 if judged.length == 0 else residual, cut)
    proof = _proof(judged, branch, evidence, None if false_bound else bound, tolerances.gap, radius)
    measured = {} if costates is None else costates.columns()
    return Certificate(
        proof=proof,
        reference_low=_finite(interval.low),
        reference_high=_finite(interval.high),
        cut_margin=cut,
        costate_error=None if costates is None else _costate_error(costates, multipliers),
        false_bound=false_bound,
        **measured,
    )


def is_false_bound(
    bound: float | None, interval: Enclosure, scale: float, arriving: float | None
) -> bool:
    """Whether a lower bound lies above all of the shortest lengths that the data leave open.

    Where some of the targets may have no path, no bound lies above all of their lengths. There a
    path that arrives, with the length `arriving`, contradicts a bound above it and above them.
    """
    if bound is None or (interval.absent and arriving is None):
        return False
    highest = max(interval.high, arriving or 0.0) if interval.absent else interval.high
    return bound > highest + BOUND_TOLERANCE * scale


class _Evidence(NamedTuple):
    """The interval around the reference length, and how nearly a path is an extremal."""

    interval: Enclosure
    residual: float | None
    cut_margin: float | None


def _proof(
    judged: Judgement,
    branch: str,
    evidence: _Evidence,
    bound: float | None,
    gap: float,
    radius: float,
) -> Proof:
    """The furthest proof; an optimal path may be off the interval by `gap` times its low end."""
    interval, residual, cut = evidence
    if judged.verdict is Verdict.NONE_EXISTS:
        return Proof.PROVED if interval.low == math.inf else Proof.NONE
    if judged.gap is None or judged.length is None:
        return Proof.NONE
    tolerance = PMP_TOLERANCE + PMP_ROUNDING * judged.length / radius
    is_extremal = residual is not None and residual <= tolerance
    if judged.verdict is Verdict.OPTIMAL and interval.exists:
        allowed = gap * max(interval.low, radius)
        # an answer far below the interval owes that to its miss, and proves nothing
        near = interval.holds(judged.length, allowed)
        clear = branch != "best" or (cut is not None and cut >= -CUT_TOLERANCE)
        if near and (branch in ("LR", "RL") or (is_extremal and clear)):
            return Proof.PROVED
        # a bound above the answer's own length contradicts it, and proves nothing
        if near and bound is not None and abs(judged.length - bound) <= allowed:
            return Proof.BOUNDED
    return Proof.EXTREMAL if is_extremal else Proof.NONE


def _costate_error(costates: Extremal, multipliers: tuple[float, float] | None) -> float | None:
    if costates.abnormal or multipliers is None:
        return None
    x, y = costates.nu
    return _finite(math.hypot(multipliers[0] + x, multipliers[1] + y))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
