"""How far the proof of an answer goes, from its controls, the scenario and a bound if there is one.

Three things are laid side by side: Pontryagin's conditions and the cut margin (`study.check.extremal`),
which prove that a path is the shortest to its own end point, and an interval around the reference
length (`study.check.enclosure`), which proves that this is the length looked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.extremal import Extremal, measured
from dubins_study.study.check.verdict import Judgement, Tolerances, Verdict
from dubins_study.study.closed_form.shortest import EPS
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

_DEFAULT = Tolerances()
# A solver's 1e-8 on lengths leaves angles off by about as much; the turn of 1e-3 that an
# interior-point method adds to a segment (THEORY section 5) leaves its square, 1e-6.
PMP_TOLERANCE = 1e-7
# nu3 sums products of the costates with positions: this is lost of them for every radius of length
PMP_ROUNDING = 16 * EPS
# rad: at the tie straight behind the margin is zero up to rounding
CUT_TOLERANCE = 1e-9
# relative: a bound above the shortest length by less is so by the solver's own tolerance
BOUND_TOLERANCE = 1e-9


class Proof(StrEnum):
    """How far the proof of an answer goes, furthest first.

    proved: the length is within tolerance of a proven interval, and the path is an extremal, for
        `best` also clear of its cut (of LR and RL the interval alone decides); or there is
        provably no path, and none was returned. Of a word's few paths the interval holds the
        shortest, so that its cut says nothing.
    bounded: the solver's own lower bound is within the tolerance, and contradicts nothing.
    extremal: an arriving path that satisfies Pontryagin's conditions.
    none: none of these.
    """

    PROVED = "proved"
    BOUNDED = "bounded"
    EXTREMAL = "extremal"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class Certificate:
    """What can be said for an answer. Lengths in the scenario's unit; None where nothing can.

    Args:
        proof: how far the proof goes.
        reference_low, reference_high: proven interval around the branch's shortest length; the
            upper end is None where the branch provably has no path, both are then.
        costate_x, costate_y: (nu1, nu2) of the path, in the world frame, with nu0 = 1.
        abnormal: whether nu0 = 0; the costates are then of norm 1.
        hamiltonian, sign_margin, transversality, pmp_residual: see `study.check.extremal.Extremal`.
        cut_margin: see `study.check.extremal.cut_margin` (rad).
        costate_error: distance of the solver's multipliers from -(nu1, nu2) / nu0.
        false_bound: whether the solver's lower bound lies above the shortest length.
    """

    proof: Proof
    reference_low: float | None
    reference_high: float | None
    costate_x: float | None
    costate_y: float | None
    abnormal: bool
    hamiltonian: float | None
    sign_margin: float | None
    transversality: float | None
    pmp_residual: float | None
    cut_margin: float | None
    costate_error: float | None
    false_bound: bool


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
        judged: what `study.check.verdict.judge` found of it.
        lower_bound: a bound that the solver gives (length unit).
        multipliers: duals of the end point's equations that the solver gives.
        tolerances: those of the judgement.
    """
    interval = enclose(scenario, branch)
    found, cut = None, None
    if path is not None and judged.length is not None:
        found, cut = measured(path, scenario.radius)
    bound = lower_bound if lower_bound is not None and not math.isnan(lower_bound) else None
    allowed = tolerances.gap * max(interval.low, scenario.radius)
    slack = BOUND_TOLERANCE * max(interval.low, scenario.radius)
    false_bound = bound is not None and bound > interval.high + slack
    return Certificate(
        proof=_proof(
            judged,
            branch,
            interval,
            found,
            cut,
            None if false_bound else bound,
            allowed,
            scenario.radius,
        ),
        reference_low=_finite(interval.low),
        reference_high=_finite(interval.high),
        costate_x=None if found is None else found.nu[0],
        costate_y=None if found is None else found.nu[1],
        abnormal=found is not None and found.abnormal,
        hamiltonian=None if found is None else found.hamiltonian,
        sign_margin=None if found is None else found.sign_margin,
        transversality=None if found is None else found.transversality,
        pmp_residual=None if found is None else found.residual,
        cut_margin=cut,
        costate_error=_costate_error(found, multipliers),
        false_bound=false_bound,
    )


def _proof(
    judged: Judgement,
    branch: str,
    interval: Enclosure,
    found: Extremal | None,
    cut: float | None,
    bound: float | None,
    allowed: float,
    radius: float,
) -> Proof:
    """The furthest proof; `allowed` is by how much an optimal path may be longer."""
    if judged.verdict is Verdict.NONE_EXISTS:
        return Proof.PROVED if interval.low == math.inf else Proof.NONE
    if judged.gap is None or judged.length is None:
        return Proof.NONE
    # a path of no length has no costates, and needs none
    residual = 0.0 if judged.length == 0 else math.inf if found is None else found.residual
    is_extremal = residual <= PMP_TOLERANCE + PMP_ROUNDING * judged.length / radius
    if judged.verdict is Verdict.OPTIMAL and interval.exists:
        # an answer far below the interval owes that to its miss, and proves nothing
        near = abs(judged.length - interval.low) <= allowed
        clear = branch != "best" or (cut is not None and cut >= -CUT_TOLERANCE)
        if near and (branch in ("LR", "RL") or (is_extremal and clear)):
            return Proof.PROVED
        if near and bound is not None and judged.length - bound <= allowed:
            return Proof.BOUNDED
    return Proof.EXTREMAL if is_extremal else Proof.NONE


def _costate_error(found: Extremal | None, multipliers: tuple[float, float] | None) -> float | None:
    if found is None or found.abnormal or multipliers is None:
        return None
    return _finite(math.hypot(multipliers[0] + found.nu[0], multipliers[1] + found.nu[1]))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
