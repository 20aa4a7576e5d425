"""Proven intervals around the shortest length, in interval arithmetic.

The data are known to delta (`study.body_coordinates.Local`). So a question stands for all targets
whose X and Y are within delta of the exact values that its doubles give, and its shortest length is
a set of numbers: a few delta wide, and in parts where a turning circle, the edge of a word's reach
or the axis passes through the targets. Every candidate word is evaluated in ball arithmetic (Arb,
through python-flint) on the whole square of targets, by formulas other than those of
`closed_form.shortest`, and the least is taken. That one of the four words is shortest is a theorem
(docs/derivation.md, section 11); nothing is assumed about which.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from itertools import chain
from typing import NamedTuple

from flint import arb, ctx

from dubins_study.study.body_coordinates import PER_DISTANCE, PER_EXTENT
from dubins_study.study.scenario import Scenario

# 53 of the doubles, as many for what their differences lose, and some to spare beside delta
BITS = 160
Part = tuple[float, float]


class Enclosure(NamedTuple):
    """A proven interval around a branch's shortest lengths (length unit)."""

    low: float
    high: float  # both ends are infinite where provably no target has a path
    absent: bool  # some of the targets may have no path
    parts: tuple[Part, ...]  # sorted intervals [low, high], apart, that hold all of the lengths

    @property
    def exists(self) -> bool:
        return math.isfinite(self.high)

    def nearest(self, length: float, tolerance: float = 0.0) -> float | None:
        """The largest of the lengths that is not above `length`; the least if all are above.

        A part that begins within the tolerance above `length` counts as not above it.
        """
        if not self.parts:
            return None
        below = [part for part in self.parts if part[0] <= length + tolerance]
        low, high = below[-1] if below else self.parts[0]
        return max(low, min(high, length))

    def highest(self, arriving: float | None) -> float:
        """The length above which a lower bound is false.

        Where some of the targets may have no path, no bound lies above all of their lengths. There
        a path that arrives, with the length `arriving`, contradicts a bound above it.
        """
        if not self.absent:
            return self.high
        return math.inf if arriving is None else max(self.high, arriving)

    def holds(self, length: float, tolerance: float) -> bool:
        """Whether a length is within the tolerance of a part."""
        return any(low - tolerance <= length <= high + tolerance for low, high in self.parts)


@lru_cache(maxsize=16384)  # the cells of a run ask each question often, in shuffled order
def enclose(scenario: Scenario, branch: str = "best") -> Enclosure:
    """Enclose the shortest lengths of a branch over all targets within delta."""
    with ctx.workprec(BITS):
        X, Y = _square(scenario)
        if branch == "best":
            return outwards(_best(X, abs(Y)), False, scenario.radius)
        word = _left_straight if branch in ("LS", "RS") else _right_left
        return outwards(*word(X, -Y if branch in ("RS", "LR") else Y), scenario.radius)


def _square(scenario: Scenario) -> tuple[arb, arb]:
    """X and Y of the scenario's targets, as balls of radius delta."""
    x, y, target_x, target_y = map(
        arb, (scenario.x, scenario.y, scenario.target_x, scenario.target_y)
    )
    dx, dy, R = target_x - x, target_y - y, arb(scenario.radius)
    sin, cos = arb(scenario.heading).sin_cos()
    X, Y = (dx * cos + dy * sin) / R, (dy * cos - dx * sin) / R
    extent = (abs(x) + abs(y) + abs(target_x) + abs(target_y)) / R
    delta = PER_EXTENT * extent + PER_DISTANCE * (abs(X) + abs(Y))
    blur = delta.union(-delta)
    return X + blur, Y + blur


def outwards(parts: Iterable[arb], absent: bool, radius: float) -> Enclosure:
    """The parts as doubles rounded outwards, those that overlap made one."""
    merged: list[Part] = []
    R = arb(radius)
    for low, high in sorted(_ends(part * R) for part in parts):
        if merged and low <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(high, merged[-1][1])
        else:
            merged.append((low, high))
    if not merged:
        return Enclosure(math.inf, math.inf, True, ())
    return Enclosure(merged[0][0], merged[-1][1], absent, tuple(merged))


def _ends(ball: arb) -> Part:
    """The ends of a ball as doubles; conversion rounds to nearest, which one step covers."""
    low, high = float(ball.lower()), float(ball.upper())
    return max(0.0, math.nextafter(low, -math.inf)), math.nextafter(high, math.inf)


def _best(X: arb, y: arb) -> list[arb]:
    """Lengths of the shortest paths of all, for y = |Y|, since the mirror image is as long."""
    parts: list[arb] = []
    w = _power(X, y)
    right_straight = _tangents(X, -y, _power(X, -y), ahead_of_axis=False)  # exists everywhere
    mirrored = [*right_straight, *chain(*right_left_solutions(X, -y, inside=False))]
    if not w > 0:  # some of the targets are outside the left disc or on its circle: LS exists
        options = _tangents(X, y, w, ahead_of_axis=True)
        turns = chain(*right_left_solutions(X, y, inside=False))
        parts += below(ceiling_of([options]), [*options, *turns, *mirrored])
    if not w <= 0:  # some are inside: the long RL exists
        solutions = right_left_solutions(X, y, inside=True)
        parts += below(ceiling_of(solutions[:1]), [*chain(*solutions), *mirrored])
    return parts


def _left_straight(X: arb, Y: arb) -> tuple[list[arb], bool]:
    """Lengths of LS, and whether some of the targets have none."""
    w = _power(X, Y)
    if w > 0:
        return [], True
    parts = [] if Y < 0 else _tangents(X, Y, w, ahead_of_axis=True)
    parts += [] if Y >= 0 else _tangents(X, Y, w, ahead_of_axis=False)
    return parts, not w <= 0


def _right_left(X: arb, Y: arb) -> tuple[list[arb], bool]:
    """Lengths of RL, the shorter of both solutions, and whether some of the targets have none."""
    p, q = _reach(X, Y)
    if p < 0 or q < 0:
        return [], True
    w = _power(X, Y)
    parts: list[arb] = []
    for inside in (False, True):
        if not (w <= 0 if inside else w > 0):
            solutions = right_left_solutions(X, Y, inside)
            parts += below(ceiling_of(solutions), [*chain(*solutions)])
    return parts, not (p >= 0 and q >= 0)


# Each solution of a word is a list of options: of every target, one of them holds the length. There
# are two where the targets lie on both sides of a jump.


def ceiling_of(solutions: Iterable[list[arb]]) -> arb:
    """A bound on the least of some solutions that all targets have."""
    return min(max(option.upper() for option in options) for options in solutions)


def below(ceiling: arb, options: Iterable[arb]) -> list[arb]:
    """The options without what lies above the ceiling."""
    kept = [option for option in options if not option > ceiling]
    return [
        option.lower().union(ceiling) if option.upper() > ceiling else option for option in kept
    ]


def _power(X: arb, Y: arb) -> arb:
    """w = 1 - |T - C_L|^2."""
    x, y = X.mid(), Y.mid()
    return y * (2 - y) - x * x + _spread(X.rad(), x) + _spread(Y.rad(), 1 - y)


def _reach(X: arb, Y: arb) -> tuple[arb, arb]:
    """|T - C_R|^2 - 1 and 9 - |T - C_R|^2, between whose zeros RL exists."""
    x, y = X.mid(), Y.mid()
    p = y * (y + 2) + x * x + _spread(X.rad(), x) + _spread(Y.rad(), 1 + y)
    return p, 8 - p


def _spread(rad: arb, value: arb) -> arb:
    """How much the square of a value changes when the value does by up to `rad`.

    Balls that meet in a product count as independent: 2Y - Y^2 would spread twice as far.
    """
    most = rad * (2 * abs(value) + rad)
    return most.union(-most)


def _tangents(X: arb, Y: arb, w: arb, ahead_of_axis: bool) -> list[arb]:
    """LS of the targets outside the left disc, on one side of the axis: Y >= 0, or Y < 0.

    T seen from C_L lies s along and 1 across the direction of arrival, so that the arc is T's polar
    angle there less atan(s): the length is the angle plus s - atan(s), which grows with s.
    """
    s = (-w).nonnegative_part().sqrt()
    low, high = s.lower(), s.upper()
    rest = (low - low.atan()).union(high - high.atan())
    if Y.mid() > 1:
        return [arb.pi() - arb.atan2(X, Y - 1) + rest]
    angle = arb.atan2(X, 1 - Y) + rest
    full = angle + 2 * arb.pi()
    if not ahead_of_axis or X < 0:
        return [full]
    return [angle] if X >= 0 else [angle, full]


def right_left_solutions(X: arb, Y: arb, inside: bool) -> tuple[list[arb], list[arb]]:
    """RL of the targets inside or outside the left disc: second arc above pi, and below.

    In the triangle of C_R, the second circle's centre and T, with sides 2, 1 and d = |T - C_R|, the
    angle at the second centre exceeds the one at C_R by an angle that goes like p^(3/2). The
    lengths are T's bearing from C_R plus it, or a full turn less it, and whole turns that make the
    first arc positive (docs/derivation.md, section 11). The first arc vanishes on the left circle:
    the two have opposite signs inside it, and the sign of X outside (eq. 5).
    """
    p, q = _reach(X, Y)
    if p < 0 or q < 0:
        return [], []
    root = (p * q).nonnegative_part().sqrt()  # four times the triangle's area
    at_first = arb.atan2(root, p + 4)
    # for y >= 0, whose ball may hold 0
    y, x = p.nonnegative_part() * root, 8 + p * (4 - p)
    excess = arb.atan2(y, x) if x.mid() > 0 else arb.pi() - arb.atan2(y, -x)
    # from straight up, clockwise as R turns
    bearing = arb.atan2(X, 1 + Y) if Y.mid() > -1 else arb.pi() - arb.atan2(X, -1 - Y)
    outside = (not X < 0, not X >= 0)  # which signs the first arcs may have: +, -
    long, short = ((True, False), (False, True)) if inside else (outside, outside)
    turn = 2 * arb.pi()
    return (
        [bearing - excess + (k + 1) * turn for k in _turns(bearing + at_first, *long)],
        [bearing + excess + k * turn for k in _turns(bearing - at_first, *short)],
    )


def _turns(angle: arb, positive: bool, negative: bool) -> list[int]:
    """How many turns bring an angle in (-2 pi, 4 pi) to [0, 2 pi).

    Near a multiple of 2 pi it has the signs that are given: an option for each.
    """
    whole = -1 if angle.mid() > 3 else 0
    rest = angle + whole * 2 * arb.pi()
    if rest < 0:
        return [whole + 1]
    if rest > 0:
        return [whole]
    return [*([whole] if positive else ()), *([whole + 1] if negative else ())]
