"""Proven intervals around the shortest length, in interval arithmetic.

Every candidate word is evaluated in ball arithmetic (Arb, through python-flint) on the scenario's
own doubles, by formulas other than those of `closed_form.shortest`, and the least is taken. That
one of the four words is shortest is a theorem (docs/derivation.md, section 11); nothing is assumed
about which. The snapping of `closed_form.shortest.local` is the statement of the problem, so it is
kept: a target that rounding puts next to a turning circle is on it.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

from flint import arb, ctx

from dubins_study.study.scenario import Scenario
from dubins_study.study.vehicle_frame import Local, local

# bits; the first decides nearly every scenario, the last tells apart whatever doubles can hold
PRECISIONS = (160, 400, 1200)
_WIDE = 1e-15  # rad: a ball of this radius is the data's own rounding, which no bits make smaller


class Enclosure(NamedTuple):
    """A proven interval [low, high] around a branch's shortest length (length unit).

    Both are infinite where the branch provably has no path; only `high` where that stays open.
    """

    low: float
    high: float

    @property
    def exists(self) -> bool:
        return math.isfinite(self.high)


class _Target(NamedTuple):
    """The target in the vehicle's frame at unit radius, and what rounding cannot tell apart."""

    X: arb
    Y: arb
    on_left: bool  # on the left turning circle
    on_right: bool
    slack: float  # what rounding does to a squared distance from a centre

    @property
    def mirrored(self) -> _Target:
        return _Target(self.X, -self.Y, self.on_right, self.on_left, self.slack)


class _UndecidedError(Exception):
    """More bits are needed to tell on which side of zero a number lies."""


@lru_cache(maxsize=16384)  # the cells of a run ask each question often, in shuffled order
def enclose(scenario: Scenario, branch: str = "best") -> Enclosure:
    """Enclose the shortest length of a branch.

    Args:
        scenario: start pose, target, radius; read as the exact values of its doubles.
        branch: one of `study.words.BRANCHES`.
    """
    snapped = local(scenario)
    if snapped.X == 0 and snapped.Y == 0 and branch in ("best", "LS", "RS"):
        return Enclosure(0.0, 0.0)  # the target is the start
    for bits in PRECISIONS:
        try:
            with ctx.workprec(bits):
                return _outwards(_lengths(_target(scenario, snapped), branch), scenario.radius)
        except _UndecidedError:
            continue
    return Enclosure(0.0, math.inf)


def _outwards(lengths: list[arb], radius: float) -> Enclosure:
    """The interval around the least of some lengths, as doubles rounded outwards."""
    if not lengths:
        return Enclosure(math.inf, math.inf)
    scaled = [length * arb(radius) for length in lengths]
    low = min(float(length.lower()) for length in scaled)
    high = min(float(length.upper()) for length in scaled)
    # conversion to a double rounds to nearest: one step outwards covers it
    return Enclosure(max(0.0, math.nextafter(low, -math.inf)), math.nextafter(high, math.inf))


def _target(scenario: Scenario, snapped: Local) -> _Target:
    dx = arb(scenario.target_x) - arb(scenario.x)
    dy = arb(scenario.target_y) - arb(scenario.y)
    sin, cos = arb(scenario.heading).sin_cos()
    R = arb(scenario.radius)
    X, Y = (dx * cos + dy * sin) / R, (dy * cos - dx * sin) / R
    return _Target(
        arb(0) if snapped.X == 0 else X,
        arb(0) if snapped.Y == 0 else Y,
        snapped.w == 0,
        snapped.mirrored.w == 0,
        8 * snapped.rounding * (1 + abs(snapped.X) + abs(snapped.Y)),
    )


def _lengths(target: _Target, branch: str) -> list[arb]:
    """Lengths, in radii, of all the paths that may answer a branch."""
    if branch == "best" and (target.on_left or target.on_right):
        # the arc itself: no other path is shorter, nor is the jump beside it in question
        branch = "LS" if target.on_left else "RS"
    if branch == "best":
        # next to its edge of reach a word of two arcs is longer than others: no slack is due
        sharp = target._replace(slack=0.0)
        return [length for word in _WORDS for length in _lengths(sharp, word)]
    find, mirror = _WORDS[branch]
    return find(target.mirrored if mirror else target)


def _left_straight(target: _Target) -> list[arb]:
    """LS: the tangent from T to the left circle; its point of contact as a polar angle there."""
    X, Y, on_circle, _, _ = target
    if on_circle:
        return [_wrapped(arb.atan2(X, 1 - Y))]
    if Y == 0 and X > 0:
        return [X]
    power = X * X + (Y - 1) ** 2 - 1  # |T - C|^2 - 1, the straight's square
    if _negative(power):
        return []
    straight = power.sqrt()
    # T seen from C_L lies `straight` along and 1 across the direction of arrival
    angle = arb.atan2(X, 1 - Y) - straight.atan()
    return [_wrapped(angle) + straight]


def _right_left(target: _Target) -> list[arb]:
    """RL, both solutions: triangles over C_R, T and the second circle's centre, sides 2, 1, d."""
    X, Y, on_left, _, slack = target
    square = X * X + (Y + 1) ** 2
    edge = _edge(square, slack)
    if edge is not None and square != edge:
        square = arb(edge, slack)  # rounding does not tell on which side: both are enclosed
    elif _negative(square - 1) or _negative(9 - square):
        return []
    at_second = _acos((5 - square) / 4)
    d = square.sqrt()
    at_first = _acos((square + 3) / (4 * d))
    bearing = arb.atan2(X, 1 + Y)  # of T from C_R, from straight up, clockwise as R turns
    seconds = _full_turn(ctx.prec) - at_second, at_second
    firsts = bearing + at_first, bearing - at_first
    if not on_left:
        return [_wrapped(a) + b for a, b in zip(firsts, seconds, strict=True)]
    # on the left circle one first arc is none, which its ball cannot tell from a full turn
    other = max((0, 1), key=lambda i: 1 - math.cos(float(firsts[i].mid())))
    [arc] = _left_straight(target)
    if edge is not None:
        arc = arc.union(seconds[1 - other])
    return [arc, _wrapped(firsts[other]) + seconds[other]]


def _edge(square: arb, slack: float) -> int | None:
    """1 or 9 if rounding does not tell a squared distance from it, which bound a word's reach."""
    nearest = 1 if square < 5 else 9
    return nearest if abs(float((square - nearest).mid())) <= slack else None


_WORDS = {
    "LS": (_left_straight, False),
    "RS": (_left_straight, True),
    "RL": (_right_left, False),
    "LR": (_right_left, True),
}


def _acos(value: arb) -> arb:
    """arccos of a number in [-1, 1], whose ball may stick out of it by its radius."""
    root = (1 - value * value).nonnegative_part().sqrt()
    # the root's ball may hold zero, and atan2 jumps there if its second argument is negative
    return arb.pi() - arb.atan2(root, -value) if value < 0 else arb.atan2(root, value)


@lru_cache(maxsize=len(PRECISIONS))
def _full_turn(bits: int) -> arb:
    """2 pi to a number of bits, which is the precision that is being worked with."""
    return 2 * arb.pi()


def _wrapped(angle: arb) -> arb:
    """An angle in (-2 pi, 2 pi) brought to [0, 2 pi); both if its ball is wide and holds 0."""
    if float(angle.rad()) > _WIDE and angle.contains(0):
        return angle.union(angle + _full_turn(ctx.prec))
    return angle + _full_turn(ctx.prec) if _negative(angle) else angle


def _negative(value: arb) -> bool:
    """Whether a number lies below zero, decided by its ball.

    Raises:
        _UndecidedError: if the ball holds zero and more.
    """
    if value < 0:
        return True
    if value >= 0:
        return False
    raise _UndecidedError
