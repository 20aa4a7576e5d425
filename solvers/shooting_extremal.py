"""Whether a solution of the shooting equations is an extremal: miss, costates, sign of nu3."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from solvers.model import FULL_TURN
from solvers.shooting_structure import Structure
from study.path import FloatArray

# nu0 below this (of costates nu0, nu1, nu2 of length 1) counts as zero: an abnormal extremal
_ABNORMAL = 1e-9

# which of the two pieces are driven
_KEPT = tuple(map(np.array, ((0.0, 1.0), (1.0, 0.0), (1.0, 1.0))))


@dataclass(frozen=True)
class Conditions:
    """How closely the conditions must be met.

    Args:
        tol: largest residual of the costates' conditions, with (nu0, nu1, nu2) of length 1, and
            largest u nu3 on an arc.
        miss: largest distance from the end point to the target, radii.
        prescribed: whether the controls are given, so that only the durations need be stationary
            and (2.14) does not hold.
    """

    tol: float
    miss: float
    prescribed: bool


@dataclass(frozen=True, eq=False)
class Candidate:
    """Durations, none below zero, shape (2,), radii; and nu0 >= 0, nu1, nu2, nu3(0), shape (4,)."""

    structure: Structure
    durations: FloatArray
    costates: FloatArray

    @property
    def normal(self) -> bool:
        return bool(self.costates[0] > _ABNORMAL)

    @property
    def multipliers(self) -> tuple[float, float] | None:
        """-(nu1, nu2)/nu0, how the length changes with the target; None if abnormal."""
        nu0, nu1, nu2, _ = self.costates.tolist()
        return (-nu1 / nu0, -nu2 / nu0) if self.normal else None

    @property
    def kind(self) -> str:
        """What sort of extremal this is, if it is one."""
        structure = "bang-singular" if self.structure.singular else "bang-bang"
        return f"{structure}, {'normal' if self.normal else 'abnormal'}"

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
    """What a solution v, shape (6,), of `Structure.residual` amounts to, and what is wrong with it.

    Whole turns are dropped from arcs: the conditions have that period, and the path without them
    is shorter. Rounding may make a piece of no length a whole turn or put it below zero, so the
    point without that piece is tried first. Where (nu0, nu) solves the conditions so does its
    negative, and nu0 >= 0 chooses.
    """
    durations = v[4:] * (1.0, structure.unit)
    if structure.singular:
        durations = np.array((durations[0] % FULL_TURN, max(durations[1], 0.0)))
    else:
        durations %= FULL_TURN
    for kept in _KEPT:
        driven = durations * kept
        candidate = Candidate(structure, driven, _signed(structure, v[:4], driven))
        fault = candidate.fault(conditions)
        if fault is None:
            break
    return candidate, fault


def _signed(structure: Structure, costates: FloatArray, durations: FloatArray) -> FloatArray:
    if abs(costates[0]) > _ABNORMAL:
        return costates * math.copysign(1.0, costates[0])
    # nu0 is zero up to rounding, and either sign may be meant
    return min(costates, -costates, key=lambda c: structure.wrong_sign(c, durations))
