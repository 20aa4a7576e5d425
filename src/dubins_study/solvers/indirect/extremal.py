"""Decide whether a solution of the shooting equations is an extremal: miss, costates, nu3."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dubins_study.solvers.indirect.structure import Structure
from dubins_study.solvers.paper_nlp.model import FULL_TURN
from dubins_study.study.path import FloatArray

# nu0 below this (of costates nu0, nu1, nu2 of length 1) counts as zero: an abnormal extremal
_ABNORMAL = 1e-9


@dataclass(frozen=True)
class Conditions:
    """Tolerances on the conditions.

    Args:
        tol: largest residual of the costates' conditions, with (nu0, nu1, nu2) of length 1, and
            largest u nu3 on an arc.
        miss: largest distance from the end point to the target, radii.
        prescribed: whether the branch prescribes the controls: only the durations are then free,
            and (2.14) need not hold.
    """

    tol: float
    miss: float
    prescribed: bool


@dataclass(frozen=True, eq=False)
class Candidate:
    """Durations (2,) in radii, none negative, and costates (4,): nu0 >= 0, nu1, nu2, nu3(0)."""

    structure: Structure
    durations: FloatArray
    costates: FloatArray

    @property
    def normal(self) -> bool:
        return bool(self.costates[0] > _ABNORMAL)

    @property
    def multipliers(self) -> tuple[float, float] | None:
        """-(nu1, nu2)/nu0, the gradient of the length by the target; None if abnormal."""
        nu0, nu1, nu2, _ = self.costates.tolist()
        return (-nu1 / nu0, -nu2 / nu0) if self.normal else None

    def kind(self, conditions: Conditions) -> str:
        """The kind of an extremal, for messages."""
        structure = "bang-singular" if self.structure.singular else "bang-bang"
        wrong = self.structure.wrong_sign(self.costates, self.durations) > conditions.tol
        signs = ", against the sign of nu3: stationary, but no extremal" if wrong else ""
        return f"{structure}, {'normal' if self.normal else 'abnormal'}{signs}"

    def fault(self, conditions: Conditions) -> str | None:
        """The condition that is not met, or None if this is an extremal."""
        residual = self.structure.residual(self.structure.unknowns(self.costates, self.durations))
        costates = float(np.abs(residual[2:]).max())
        miss = self.structure.miss(self.durations)
        if not (math.isfinite(miss) and math.isfinite(costates)):
            return "the iteration left the finite numbers"
        if miss > conditions.miss:
            return f"misses the target by {miss:.3g} radii"
        if costates > conditions.tol:
            return f"the conditions on costates are met to {costates:.1e} only"
        wrong = self.structure.wrong_sign(self.costates, self.durations)
        if not conditions.prescribed and wrong > conditions.tol:
            return f"turns against the sign of nu3 (2.14), which is off by {wrong:.3g}"
        return None


def examine(
    structure: Structure, v: FloatArray, conditions: Conditions
) -> tuple[Candidate, str | None]:
    """The candidate that a solution v, shape (6,), of `Structure.residual` gives, and its fault.

    Full turns are removed from arcs: the conditions have that period, and the path is shorter
    without them. A piece of no length may come out as a negative one or nearly a full turn, so the
    path without either piece is tried first.
    """
    durations = v[4:] * (1.0, structure.unit)
    for missing in (0, 1):
        driven = _without(structure, durations, missing)
        if structure.miss(driven) <= conditions.miss:
            candidate = Candidate(structure, driven, _signed(structure, driven))
            if candidate.fault(conditions) is None:
                return candidate, None
    driven = _forwards(structure, durations)
    candidate = Candidate(structure, driven, _signed(structure, driven, v[:4]))
    return candidate, candidate.fault(conditions)


def _forwards(structure: Structure, durations: FloatArray) -> FloatArray:
    first, second = durations.tolist()
    last = max(second, 0.0) if structure.singular else second % FULL_TURN
    return np.array((first % FULL_TURN, last))


def _without(structure: Structure, durations: FloatArray, missing: int) -> FloatArray:
    """The durations with one piece removed; its length beyond full turns is added to the other.

    Near a piece of no length the end point depends on the sum of the two durations, and on their
    difference only to second order: a solution has that difference to half of its digits.
    """
    moved = float(durations[missing])
    if not (structure.singular and missing == 1):
        moved = math.remainder(moved, FULL_TURN) if math.isfinite(moved) else math.nan
    changed = durations.copy()
    changed[1 - missing] += moved
    changed[missing] = 0.0
    return _forwards(structure, changed)


def _signed(
    structure: Structure, durations: FloatArray, costates: FloatArray | None = None
) -> FloatArray:
    """The costates, by default those of the durations, with the sign that makes nu0 >= 0."""
    if costates is None:
        costates = structure.costates(durations)
    if abs(costates[0]) > _ABNORMAL:
        return costates * math.copysign(1.0, costates[0])
    # nu0 is zero up to rounding, and either sign may be right
    return min(costates, -costates, key=lambda c: structure.wrong_sign(c, durations))
