"""Pontryagin's system along two pieces of given controls.

Everything is in body coordinates at unit radius. The costates nu1 and nu2 are constant (2.4),
(2.5). For a start at (0, 0, 0) equation (2.6) integrates to nu3(t) = nu3(0) + nu1 y(t) - nu2 x(t).
All of this is exact on every piece.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray

# Controls of the model's three lengths; mirrored together with the subproblem.
TURNS = (1.0, -1.0, 0.0)

# Relative error of the end point of a long straight, from the rounding of its heading.
ROUNDED = 16 * math.ulp(1.0)

# Costates with (nu0, nu1, nu2) shorter than this count as zero, as H = 0 makes nu3 zero too.
_NO_COSTATES = 1e-3

# nu0 below this (of costates nu0, nu1, nu2 of length 1) counts as zero: an abnormal extremal
_ABNORMAL = 1e-9

UNKNOWNS = 6  # nu0, nu1, nu2, nu3(0), then the durations of the two pieces


class Piece(NamedTuple):
    """The state at a piece's end, and its derivatives.

    `by_first` and `by_second` are the derivatives of (x, y) by the durations of both pieces.
    """

    x: float
    y: float
    heading: float
    by_first: tuple[float, float]
    by_second: tuple[float, float]


@dataclass(frozen=True)
class Structure:
    """The controls of two pieces, and the target.

    The controls are bang-singular (CS) or bang-bang (CC). The first of the turns is +1 or -1, the
    second 0 or the first's opposite.
    """

    turns: tuple[float, float]
    X: float
    Y: float

    @cached_property
    def scale(self) -> float:
        """Unit (radii) of the end point's residual.

        It is also the unit of a straight, so that the unknowns have similar sizes.
        """
        return max(1.0, math.hypot(self.X, self.Y))

    @property
    def singular(self) -> bool:
        return self.turns[1] == 0

    @property
    def unit(self) -> float:
        """Unit (radii) of the second duration among the unknowns."""
        if self.singular:
            return self.scale
        return 1.0

    def unknowns(self, costates: FloatArray, durations: FloatArray) -> FloatArray:
        """The unknowns that `residual` takes.

        `costates` has shape (4,). `durations` (2,) are in radii; the second one becomes a multiple
        of `unit`.
        """
        return np.concatenate((costates, durations / (1.0, self.unit)))

    def consistent(self, nu: tuple[float, float, float]) -> FloatArray:
        """Costates that make H(0) zero (2.15).

        (nu0, nu1, nu2) is scaled to length 1, and nu3(0) follows. Returns all four, shape (4,).
        """
        size = math.hypot(*nu)
        nu0, nu1, nu2 = (value / size for value in nu)
        return np.array((nu0, nu1, nu2, -self.turns[0] * (nu0 + nu1)))

    def pieces(self, first: float, second: float) -> tuple[Piece, Piece]:
        """The states after the first and the second piece.

        Durations are in radii, of any sign.
        """
        u, w = self.turns
        turn = u * first
        s = math.sin(turn)
        c = math.cos(turn)
        x = u * s
        y = u * 2 * math.sin(turn / 2) ** 2  # 1 - cos without cancellation
        switch = Piece(x, y, turn, (c, s), (0.0, 0.0))
        half = w * second / 2
        chord = second
        if w != 0:
            chord = 2 * w * math.sin(half)
        end = turn + 2 * half
        dx = chord * math.cos(turn + half)
        dy = chord * math.sin(turn + half)
        # a longer first piece turns everything after it
        by_first = (c - u * dy, s + u * dx)
        by_second = (math.cos(end), math.sin(end))
        return switch, Piece(x + dx, y + dy, end, by_first, by_second)

    def residual(self, v: FloatArray) -> FloatArray:
        """The conditions, zero at an extremal.

        Shape (6,) -> (6,), in this order:

        - The end point (2), over `scale`.
        - nu3 = 0 at the switch.
        - For CC the transversality nu3(tf) = 0. For CS d(nu3)/dt = 0 at the switch (2.6), which
          keeps nu3 = 0 up to tf.
        - H(0) = 0 (2.12), and so H = 0 throughout.
        - (nu0, nu1, nu2) of length 1, which admits abnormal extremals (nu0 = 0).
        """
        nu0, nu1, nu2, nu3, first, second = v.tolist()
        switch, end = self.pieces(first, second * self.unit)
        if self.singular:
            stays = nu1 * math.sin(switch.heading) - nu2 * math.cos(switch.heading)
        else:
            stays = nu3 + nu1 * end.y - nu2 * end.x
        return np.array(
            (
                (end.x - self.X) / self.scale,
                (end.y - self.Y) / self.scale,
                nu3 + nu1 * switch.y - nu2 * switch.x,
                stays,
                nu0 + nu1 + self.turns[0] * nu3,
                nu0 * nu0 + nu1 * nu1 + nu2 * nu2 - 1,
            )
        )

    def jacobian(self, v: FloatArray) -> FloatArray:
        """Derivative of `residual`, shape (6,) -> (6, 6)."""
        nu0, nu1, nu2, _, first, second = v.tolist()
        unit = self.unit
        switch, end = self.pieces(first, second * unit)
        ax, ay = end.by_first
        bx, by = end.by_second
        sx, sy = switch.by_first
        J = np.zeros((UNKNOWNS, UNKNOWNS))
        J[0, 4:] = ax / self.scale, bx * unit / self.scale
        J[1, 4:] = ay / self.scale, by * unit / self.scale
        J[2, 1:5] = switch.y, -switch.x, 1, nu1 * sy - nu2 * sx
        if self.singular:
            J[3, 1:3] = sy, -sx
            J[3, 4] = self.turns[0] * (nu1 * sx + nu2 * sy)
        else:
            J[3, 1:] = end.y, -end.x, 1, nu1 * ay - nu2 * ax, nu1 * by - nu2 * bx
        J[4, :4] = 1, 1, 0, self.turns[0]
        J[5, :3] = 2 * nu0, 2 * nu1, 2 * nu2
        return J

    def costates(self, durations: FloatArray) -> FloatArray:
        """The costates (4,) of given durations (2,).

        The costates solve the three conditions of `residual` that are linear in costates. Their
        sign makes nu0 >= 0.
        """
        linear = self.jacobian(self.unknowns(np.zeros(4), durations))[2:5, :4]
        # the direction that all three conditions map to zero
        nu: FloatArray = np.linalg.svd(linear)[2][-1]
        nu /= max(math.hypot(*nu[:3]), _NO_COSTATES)
        if abs(nu[0]) > _ABNORMAL:
            return nu * math.copysign(1.0, nu[0])
        # nu0 is zero up to rounding, and either sign may be right
        return min(nu, -nu, key=lambda each: self.wrong_sign(each, durations))

    def miss(self, durations: FloatArray) -> float:
        """Distance (radii) from the end point to the target."""
        _, end = self.pieces(*durations.tolist())
        return math.hypot(end.x - self.X, end.y - self.Y)

    def wrong_sign(self, costates: FloatArray, durations: FloatArray) -> float:
        """The violation of the minimum condition (2.13).

        It is zero if the condition holds on the arcs. Otherwise it is the largest u nu3, which must
        not exceed zero (2.14). By (2.15) u nu3 equals -(nu0 + rho cos(theta - phi)). Here theta is
        the heading, and (nu1, nu2) has length rho and direction phi. This is largest at the ends of
        an arc or at theta = phi + pi.
        """
        nu0, nu1, nu2, _ = costates.tolist()
        away = math.atan2(-nu2, -nu1)  # phi + pi
        worst = 0.0
        heading = 0.0
        for turn, duration in zip(self.turns, durations.tolist(), strict=True):
            low, high = sorted((heading, heading + turn * duration))
            if turn != 0 and duration > 0:
                if low + (away - low) % TWO_PI <= high:
                    largest = math.hypot(nu1, nu2)
                else:
                    largest = max(-nu1 * math.cos(t) - nu2 * math.sin(t) for t in (low, high))
                worst = max(worst, largest - nu0)
            heading += turn * duration
        return worst


class Candidate:
    """Durations (2,) that may be an extremal's.

    The durations are in radii, none negative. The attributes `miss` (radii), `costates` (4,) and
    `wrong`, the violation of (2.14), are computed from them; `against` says that (2.14) is violated
    by more than `tol`. Costates are NaN if the end point is not finite.
    """

    def __init__(self, structure: Structure, durations: FloatArray, tol: float) -> None:
        self.durations = durations
        self.miss = structure.miss(durations)
        self.costates = np.full(4, np.nan)
        self.wrong = math.inf
        if math.isfinite(self.miss):
            self.costates = structure.costates(durations)
            self.wrong = structure.wrong_sign(self.costates, durations)
        self.against = self.wrong > tol  # the minimum condition (2.14), to `tol` of u nu3
        self.kind = "bang-bang"
        if structure.singular:
            self.kind = "bang-singular"

    @property
    def multipliers(self) -> FloatArray | None:
        """The gradient of the length by the target.

        It is -(nu1, nu2)/nu0, or None if the extremal is abnormal.
        """
        nu0, nu1, nu2, _ = self.costates
        if nu0 > _ABNORMAL:
            return np.array((-nu1 / nu0, -nu2 / nu0))
        return None

    def describe(self) -> str:
        """The kind of an extremal, for messages."""
        text = f"{self.kind}, normal"
        if self.multipliers is None:
            text = f"{self.kind}, abnormal"
        if self.against:
            return f"{text}, against the sign of nu3: stationary, but no extremal"
        return text

    def fault(self, allowed: float, prescribed: bool) -> str | None:
        """The condition that is not met, or None.

        None means that the durations are those of an extremal. The path may miss by `allowed`
        radii. If the branch prescribes the controls, (2.14) need not hold.
        """
        if not math.isfinite(self.miss):
            return "the iteration left the finite numbers"
        if self.miss > allowed:
            return f"misses the target by {self.miss:.3g} radii"
        if self.against and not prescribed:
            return f"turns against the sign of nu3 (2.14), which is off by {self.wrong:.3g}"
        return None


def candidates(structure: Structure, v: FloatArray, tol: float) -> Iterator[Candidate]:
    """The candidates that a solution v may stand for.

    v has shape (6,) and solves `Structure.residual`. Yields three candidates: without the first
    piece, without the second, and with both. A piece of no length may come out as a negative one or
    nearly a full turn; so the candidates without it come first. Full turns are removed from arcs.
    """
    durations = v[4:] * (1.0, structure.unit)
    for driven in (
        _without(structure, durations, 0),
        _without(structure, durations, 1),
        _forwards(structure, durations),
    ):
        yield Candidate(structure, driven, tol)


def _forwards(structure: Structure, durations: FloatArray) -> FloatArray:
    """The durations without full turns and negative straights."""
    first, second = durations.tolist()
    last = second % TWO_PI
    if structure.singular:
        last = max(second, 0.0)
    return np.array((first % TWO_PI, last))


def _without(structure: Structure, durations: FloatArray, missing: int) -> FloatArray:
    """The durations with one piece removed.

    The removed length, beyond full turns, is added to the other piece. Near a piece of no length
    the end point depends on the sum alone to first order.
    """
    moved = float(durations[missing])
    if not (structure.singular and missing == 1):
        if math.isinf(moved):
            moved = math.nan  # `math.remainder` raises for an infinity
        moved = math.remainder(moved, TWO_PI)
    changed = durations.copy()
    changed[1 - missing] += moved
    changed[missing] = 0.0
    return _forwards(structure, changed)
