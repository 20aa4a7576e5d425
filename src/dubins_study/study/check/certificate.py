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
from dubins_study.study.check.verdict import Judgement
from dubins_study.study.path import Path
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


class Certificate(NamedTuple):
    """The proof of an answer and its evidence. Lengths in the scenario's unit; None where absent.

    Args:
        proof: how far the proof goes.
        reference_low, reference_high: proven interval around the branch's shortest lengths, of all
            targets within delta; both are None where the branch provably has no path.
        costate_x, costate_y: (nu1, nu2) of the path, in the world frame, with nu0 = 1.
        abnormal: whether nu0 = 0; the costates are then of norm 1.
        hamiltonian, sign_margin, transversality, pmp_residual: see `study.check.extremal.Extremal`.
        cut_margin: see `study.check.extremal.cut_margin` (rad).
        costate_error: distance of the solver's multipliers from -(nu1, nu2) / nu0.
        false_bound: whether the solver's lower bound lies above all of the shortest lengths.
    """

    proof: Proof
    reference_low: float | None
    reference_high: float | None
    costate_x: float | None = None
    costate_y: float | None = None
    abnormal: bool = False
    hamiltonian: float | None = None
    sign_margin: float | None = None
    transversality: float | None = None
    pmp_residual: float | None = None
    cut_margin: float | None = None
    costate_error: float | None = None
    false_bound: bool = False


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
    false_bound = is_false_bound(bound, interval, scale)
    # a path of no length has no costates, and needs none
    residual = None if costates is None else costates.residual
    evidence = _Evidence(interval, 0.0 if judged.length == 0 else residual, cut)
    proof = _proof(judged, branch, evidence, None if false_bound else bound, tolerances.gap, radius)
    low, high = _finite(interval.low), _finite(interval.high)
    if costates is None:
        return Certificate(proof, low, high, cut_margin=cut, false_bound=false_bound)
    return Certificate(
        proof,
        low,
        high,
        *costates.nu,
        costates.abnormal,
        costates.hamiltonian,
        costates.sign_margin,
        costates.transversality,
        costates.residual,
        cut,
        _costate_error(costates, multipliers),
        false_bound,
    )


def is_false_bound(bound: float | None, interval: Enclosure, scale: float) -> bool:
    """Whether a lower bound lies above all of the shortest lengths that the data leave open.

    Where some of the targets may have no path, none does.
    """
    if bound is None or interval.absent:
        return False
    return bound > interval.high + BOUND_TOLERANCE * scale


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
        if near and bound is not None and judged.length - bound <= allowed:
            return Proof.BOUNDED
    return Proof.EXTREMAL if is_extremal else Proof.NONE


def _costate_error(costates: Extremal, multipliers: tuple[float, float] | None) -> float | None:
    if costates.abnormal or multipliers is None:
        return None
    x, y = costates.nu
    return _finite(math.hypot(multipliers[0] + x, multipliers[1] + y))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
