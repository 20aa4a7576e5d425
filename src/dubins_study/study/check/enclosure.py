"""Enclose the shortest length of one leg.

The intervals are proven, in interval arithmetic. The data are known to delta
(`study.body_coordinates.Local`, `study.closed_form.pose.Leg`). So a question stands for all targets
whose X and Y, or all ends whose X, Y and heading in the start's frame, are within delta of the
exact values that its doubles give. Its shortest length is a set of numbers: a few delta wide, and
in parts where a turning circle, the edge of a word's reach or the axis passes through the targets.

Every candidate word is evaluated in ball arithmetic (Arb, through python-flint) on all targets, by
formulas other than those of `closed_form`, and the least is taken. It is a theorem that one of the
four words to a free heading is shortest (docs/derivation.md, section 11). That one of the six to a
given heading is shortest is Dubins' theorem. Nothing is assumed about which.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import chain, product
from typing import NamedTuple

from flint import arb, ctx

from dubins_study.study.body_coordinates import PER_DISTANCE, PER_EXTENT
from dubins_study.study.closed_form.pose import PER_HEADINGS, WORDS6
from dubins_study.study.scenario import Pose, Scenario

# 53 bits for the doubles, 53 for the digits lost in differences, the rest to be well below delta
_BITS = 160
Part = tuple[float, float]


class Enclosure(NamedTuple):
    """Proven interval around a branch's shortest lengths.

    Lengths are in the length unit.
    """

    low: float
    high: float  # both ends are infinite where provably no target has a path
    absent: bool  # some of the targets may have no path
    parts: tuple[Part, ...]  # sorted intervals [low, high], apart, that hold all of the lengths

    @property
    def exists(self) -> bool:
        return math.isfinite(self.high)

    def nearest(self, length: float, tolerance: float) -> float | None:
        """Largest of the lengths not above `length`.

        It is the least of them if all are above. A part that begins within the tolerance above
        `length` counts as not above it. None if there are no parts.
        """
        if not self.parts:
            return None
        low, high = self.parts[0]
        for part in self.parts:
            if part[0] <= length + tolerance:
                low, high = part
        return max(low, min(high, length))

    def highest(self, arriving: float | None) -> float:
        """Length above which a lower bound is false.

        Where some of the targets may have no path, no bound lies above all of their lengths. There
        a path that arrives, with the length `arriving`, contradicts a bound above it.
        """
        if not self.absent:
            return self.high
        if arriving is None:
            return math.inf
        return max(self.high, arriving)

    def holds(self, length: float, tolerance: float) -> bool:
        """Whether a part holds a length, within tolerance."""
        return any(low - tolerance <= length <= high + tolerance for low, high in self.parts)


@lru_cache(maxsize=16384)  # the cells of a run ask each question often, in shuffled order
def enclose(scenario: Scenario, branch: str = "best") -> Enclosure:
    """Enclose a branch's shortest lengths.

    All targets within delta count.
    """
    with ctx.workprec(_BITS):
        X, Y = _targets(scenario)
        if branch == "best":
            return _outwards(_best(X, abs(Y)), absent=False, radius=scenario.radius)
        # RS and LR are the mirror images of LS and RL
        word = _left_straight if branch in ("LS", "RS") else _right_left
        parts, absent = word(X, -Y) if branch in ("RS", "LR") else word(X, Y)
        return _outwards(parts, absent, scenario.radius)


class _Way(NamedTuple):
    """Way from a start to an end, in radii.

    It is (x, y), and (X, Y) in the start's frame. `extent` is the sum of the sizes of all four
    coordinates.
    """

    x: arb
    y: arb
    X: arb
    Y: arb
    extent: arb


def _way(start: Pose, x: float, y: float, radius: float) -> _Way:
    R = arb(radius)
    dx, dy = (arb(x) - arb(start.x)) / R, (arb(y) - arb(start.y)) / R
    sine, cosine = arb(start.heading).sin_cos()
    extent = sum((abs(arb(value)) for value in (start.x, start.y, x, y)), arb(0)) / R
    return _Way(dx, dy, dx * cosine + dy * sine, dy * cosine - dx * sine, extent)


def _targets(scenario: Scenario) -> tuple[arb, arb]:
    """X and Y of all targets, as balls.

    The radius of a ball is delta.
    """
    assert scenario.target is not None
    x, y = scenario.target
    way = _way(scenario.start, x, y, scenario.radius)
    delta = PER_EXTENT * way.extent + PER_DISTANCE * (abs(way.X) + abs(way.Y))
    blur = delta.union(-delta)
    return way.X + blur, way.Y + blur


def _outwards(parts: Iterable[arb], absent: bool, radius: float) -> Enclosure:
    """Parts as doubles rounded outwards.

    Overlapping parts are merged.
    """
    merged: list[Part] = []
    R = arb(radius)
    for low, high in sorted(_doubles(part * R) for part in parts):
        if merged and low <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(high, merged[-1][1])
        else:
            merged.append((low, high))
    if not merged:
        return Enclosure(low=math.inf, high=math.inf, absent=True, parts=())
    return Enclosure(low=merged[0][0], high=merged[-1][1], absent=absent, parts=tuple(merged))


def _doubles(ball: arb) -> Part:
    """Ends of a ball as doubles.

    Conversion rounds to nearest, which one step outwards covers.
    """
    low, high = float(ball.lower()), float(ball.upper())
    return max(0.0, math.nextafter(low, -math.inf)), math.nextafter(high, math.inf)


def _best(X: arb, y: arb) -> list[arb]:
    """Lengths of the shortest paths, whatever their words.

    y is |Y|, since the mirror image is as long.
    """
    parts: list[arb] = []
    w = _power(X, y)
    right_straight = _tangents(X, -y, _power(X, -y), ahead_of_axis=False)  # exists everywhere
    mirrored = [*right_straight, *chain(*right_left_solutions(X, -y, inside=False))]
    if not w > 0:  # some of the targets are outside the left disc or on its circle: LS exists
        options = _tangents(X, y, w, ahead_of_axis=True)
        turns = chain(*right_left_solutions(X, y, inside=False))
        parts += _below(_ceiling_of([options]), [*options, *turns, *mirrored])
    if not w <= 0:  # some are inside: the long RL exists
        solutions = right_left_solutions(X, y, inside=True)
        parts += _below(_ceiling_of(solutions[:1]), [*chain(*solutions), *mirrored])
    return parts


def _left_straight(X: arb, Y: arb) -> tuple[list[arb], bool]:
    """Lengths of LS.

    The flag says whether some of the targets have none.
    """
    w = _power(X, Y)
    if w > 0:
        return [], True
    parts = [] if Y < 0 else _tangents(X, Y, w, ahead_of_axis=True)
    parts += [] if Y >= 0 else _tangents(X, Y, w, ahead_of_axis=False)
    return parts, not w <= 0


def _right_left(X: arb, Y: arb) -> tuple[list[arb], bool]:
    """Lengths of RL, the shorter of both solutions.

    The flag says whether some of the targets have none.
    """
    p, q = _reach(X, Y)
    if p < 0 or q < 0:
        return [], True
    w = _power(X, Y)
    parts: list[arb] = []
    for inside in (False, True):
        # unless all targets are on the other side of the left circle
        if not (w <= 0 if inside else w > 0):
            solutions = right_left_solutions(X, Y, inside)
            parts += _below(_ceiling_of(solutions), [*chain(*solutions)])
    return parts, not (p >= 0 and q >= 0)


# Each solution of a word is a list of options. For every target, one of them holds the length.
# There are two options where the targets lie on both sides of a jump.


def _ceiling_of(solutions: Iterable[list[arb]]) -> arb:
    """Upper bound of the least of some solutions.

    All targets have these solutions.
    """
    return min(max(option.upper() for option in options) for options in solutions)


def _below(ceiling: arb, options: Iterable[arb]) -> list[arb]:
    """Options without their parts above the ceiling."""
    below = [option for option in options if not option > ceiling]
    return [
        option.lower().union(ceiling) if option.upper() > ceiling else option for option in below
    ]


def _power(X: arb, Y: arb) -> arb:
    """Power w = 1 - |T - C_L|^2."""
    x, y = X.mid(), Y.mid()
    return y * (2 - y) - x * x + _change_of_square(X.rad(), x) + _change_of_square(Y.rad(), 1 - y)


def _reach(X: arb, Y: arb) -> tuple[arb, arb]:
    """Two numbers, not negative where RL exists.

    They are |T - C_R|^2 - 1 and 9 - |T - C_R|^2.
    """
    x, y = X.mid(), Y.mid()
    p = y * (y + 2) + x * x + _change_of_square(X.rad(), x) + _change_of_square(Y.rad(), 1 + y)
    return p, 8 - p


def _change_of_square(rad: arb, value: arb) -> arb:
    """A ball that holds (value + d)^2 - value^2.

    It holds them for all |d| <= rad. Callers add it to a square of middles: with balls for X and Y,
    interval arithmetic would take the two Y of 2Y - Y^2 for independent, and spread twice as far.
    """
    most = rad * (2 * abs(value) + rad)
    return most.union(-most)


def _tangents(X: arb, Y: arb, w: arb, ahead_of_axis: bool) -> list[arb]:
    """LS of targets outside the left disc.

    The targets are on one side of the axis: Y >= 0 if `ahead_of_axis`, else Y < 0. T seen from C_L
    lies s along and 1 across the direction of arrival, so that the arc is T's polar angle there
    less atan(s). The length is the angle plus s - atan(s), which grows with s.
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
    """RL of targets on one side of a circle.

    They are inside the left disc if `inside`, else outside. The lengths with the second arc above
    pi come first, then those with it below. In the triangle of C_R, the second circle's centre and
    T, with sides 2, 1 and d = |T - C_R|, the angle at the second centre exceeds the one at C_R by
    an angle that goes like p^(3/2). The lengths are T's bearing from C_R plus this angle where the
    second arc is below pi, and plus a full turn less this angle where it is above. Whole turns are
    added that make the first arc positive (docs/derivation.md, section 11). The first arc vanishes
    on the left circle. The two solutions have opposite signs inside it, and the sign of X outside
    (eq. 5).
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
    # outside the left disc: whether first arcs next to zero are positive, as X is
    ahead = None
    if X >= 0:
        ahead = True
    elif X < 0:
        ahead = False
    # signs for the solutions with the long and the short second arc: opposite inside, equal outside
    long, short = (True, False) if inside else (ahead, ahead)
    turn = 2 * arb.pi()
    return (
        [bearing - excess + (k + 1) * turn for k in _turns(bearing + at_first, long)],
        [bearing + excess + k * turn for k in _turns(bearing - at_first, short)],
    )


def _turns(angle: arb, positive: bool | None) -> list[int]:
    """Turns that bring an angle to [0, 2 pi).

    Returns numbers of whole turns, several where the ball allows them. `positive` is the sign of an
    angle next to zero, None if it is unknown.
    """
    parts = angle / (2 * arb.pi())
    nearest = round(float(parts.mid()))
    rest = parts - nearest
    if rest > 0:
        return [-nearest]
    if rest < 0:
        return [1 - nearest]
    low, high = math.floor(float(rest.lower())), math.floor(float(rest.upper()))
    if (low, high) != (-1, 0):
        return [-nearest - whole for whole in range(low, high + 1)]
    if positive is None:
        return [-nearest, 1 - nearest]
    return [-nearest if positive else 1 - nearest]


# Legs with a given final heading


class _Ends(NamedTuple):
    """Ends in the start's frame, as balls.

    The place is (X, Y). The heading is `turn` (rad), with its sine s and cosine c.
    """

    X: arb
    Y: arb
    turn: arb
    s: arb
    c: arb

    @property
    def mirrored(self) -> _Ends:
        return _Ends(self.X, -self.Y, -self.turn, -self.s, self.c)


class _Signs(NamedTuple):
    """Sides of the edges on which an end lies.

    A flag says whether the edge's function is not negative. The functions are:

    * the sides of the end's circles from the start's line, and of the start's from the end's line;
    * |E - C|^2 - 4 for the circles of LSR and RSL;
    * 16 - |E - C|^2 for the circles of LRL and RLR.
    """

    start_left: bool
    start_right: bool
    end_left: bool
    end_right: bool
    reach_lsr: bool
    reach_rsl: bool
    reach_lrl: bool
    reach_rlr: bool

    @property
    def mirrored(self) -> _Signs:
        """Signs of the mirror image.

        Circles change their names, sides their signs.
        """
        return _Signs(
            start_left=not self.start_right,
            start_right=not self.start_left,
            end_left=not self.end_right,
            end_right=not self.end_left,
            reach_lsr=self.reach_rsl,
            reach_rsl=self.reach_lsr,
            reach_lrl=self.reach_rlr,
            reach_rlr=self.reach_lrl,
        )

    @property
    def possible(self) -> bool:
        """Whether an end can have these signs.

        The left circle's function is less than the right one's, by 2 (1 - cos turn). So if the left
        one is not negative, neither is the right one.
        """
        return self.start_right >= self.start_left and self.end_right >= self.end_left


@lru_cache(maxsize=16384)
def enclose_pose(start: Pose, end: Pose, radius: float, branch: str = "best") -> Enclosure:
    """Enclose the shortest lengths to a given heading.

    A branch is `best` or one of `WORDS6`; all ends within delta count. The ends are divided by the
    signs of eight functions. All edges of the six words consist of zeros of these functions. Most
    signs are the same for all ends. Each combination of the others decides whether a word exists,
    and whether an arc that vanishes is nothing or a whole turn. So the least of the words' lengths
    can be taken (docs/derivation.md, section 15).
    """
    with ctx.workprec(_BITS):
        ends = _ends(start, end, radius)
        near_arcs = chain(_nearly_one_arc(ends), _nearly_one_arc(ends.mirrored))
        sure = [[length] for length in near_arcs]
        parts: list[arb] = []
        absent = False
        for signs in _cells(ends):
            if branch == "best":
                words = [lengths for word in WORDS6 if (lengths := _lengths(word, ends, signs))]
                least = _ceiling_of([*words, *sure])
                parts += _below(least, chain(*words))
            else:
                lengths = _lengths(branch, ends, signs)
                parts += lengths
                absent |= not lengths
        return _outwards(parts, absent, radius)


def _ends(start: Pose, end: Pose, radius: float) -> _Ends:
    """All ends within delta of the exact one."""
    way = _way(start, end.x, end.y, radius)
    delta = PER_EXTENT * way.extent + PER_DISTANCE * (abs(way.x) + abs(way.y)) + PER_HEADINGS
    blur = delta.union(-delta)
    # whole turns come from the angle of the doubles; a heading of 1e20 needs many more digits
    with ctx.workprec(_BITS + max(0, math.frexp(end.heading - start.heading)[1])):
        turn = arb(end.heading) - arb(start.heading)
        turn -= 2 * arb.pi() * (turn / (2 * arb.pi())).mid().floor()
    turn += blur
    return _Ends(way.X + blur, way.Y + blur, turn, *turn.sin_cos())


def _cells(ends: _Ends) -> Iterator[_Signs]:
    """Combinations of signs that ends may have."""
    X, Y, _, s, c = ends
    across = X * s - Y * c
    versine = 1 - c
    functions = (
        Y - versine,
        Y + versine,
        across - versine,
        across + versine,
        _square(X + s, Y - c - 1) - 4,
        _square(X - s, Y + c + 1) - 4,
        16 - _square(X - s, Y + c - 1),
        16 - _square(X + s, Y - c + 1),
    )
    cells = (_Signs(*cell) for cell in product(*map(_possible_signs, functions)))
    return (signs for signs in cells if signs.possible)


def _possible_signs(value: arb) -> tuple[bool, ...]:
    """Whether a ball's values are not negative.

    There are two answers where it holds values of both signs.
    """
    if value >= 0:
        return (True,)
    return (False,) if value < 0 else (True, False)


def _square(x: arb, y: arb) -> arb:
    return x * x + y * y


def _lengths(word: str, ends: _Ends, signs: _Signs) -> list[arb]:
    """Lengths of a word, to ends with these signs.

    For every end, one of them is the length. The list is empty where the word does not exist.
    """
    # `left` and `right` below: whether the first and the last arc are positive where they are next
    # to zero; None where the signs do not tell
    if word in ("RSR", "RSL", "RLR"):
        ends = ends.mirrored
        signs = signs.mirrored
        word = {"RSR": "LSL", "RSL": "LSR", "RLR": "LRL"}[word]
    X, Y, turn, s, c = ends
    # forward extent of S, seen from both ends, or of the chord of the middle arc's centres
    forward = X * c + Y * s - s
    if word == "LSR":
        if not signs.reach_lsr:
            return []
        x, y = X + s, Y - c - 1
        p = (x * x + (y - 2) * (y + 2)).nonnegative_part().sqrt()
        first = _direction(x, y) + arb.pi() / 2 - (p / 2).atan()
        length = _excess(p) + arb.pi() + 2 * _direction(x, y) - turn
        left = signs.start_right if x > 0 else None
        right = not signs.end_left if forward > 0 else None
        return _with_turns(
            length,
            arcs=2 * first - turn,
            first=first,
            left=left,
            last=first - turn,
            right=right,
        )
    x, y = X - s, Y + c - 1
    d = _square(x, y).nonnegative_part().sqrt()
    first = _direction(x, y)
    if word == "LSL":
        left = signs.start_left if x > 0 else None
        right = signs.end_left if forward > 0 else None
        return _with_turns(
            d + turn, arcs=turn, first=first, left=left, last=turn - first, right=right
        )
    if not signs.reach_lrl:
        return []
    half = arb.pi() - _quarter_arcsine(d)
    left = not signs.reach_rsl if x < 0 else None
    right = not signs.reach_lsr if forward < 0 else None
    arcs = turn + 2 * half
    last = turn - first + half
    return _with_turns(
        arcs + 2 * half, arcs=arcs, first=first + half, left=left, last=last, right=right
    )


def _nearly_one_arc(ends: _Ends) -> Iterator[arb]:
    """Lengths of paths next to a single arc.

    The arc is above pi. The paths are S L S and R S L S R, are as long as the arc, and exist for
    all ends. Some combinations of signs, which no end has, would leave a full turn more as the
    least length (docs/derivation.md, section 15). The outer arcs e make the middle one more than
    half a turn where the arc is just half a turn.
    """
    X, Y, turn, s, c = ends
    full = 2 * arb.pi()
    turn -= full * math.floor(float((turn / full).mid()))
    for e in (arb(0), arb(math.sqrt(float(X.rad())))):
        sine = 2 * e.sin()
        versine = 2 - 2 * e.cos()
        x = X - s - sine * (1 + c) + versine * s
        y = Y + c - 1 - sine * s + versine * (1 - c)
        arc = turn + 2 * e
        if arc > arb.pi() and arc < full:
            yield 2 * e + arc + _square(x, y).nonnegative_part().sqrt() / abs((arc / 2).cos())


def _direction(x: arb, y: arb) -> arb:
    """Angle of (x, y), up to whole turns.

    It is any angle where (x, y) may be the origin.
    """
    if not (x < 0 or x > 0 or y < 0 or y > 0):
        return arb(0, 4)  # 0 +- 4 holds every angle
    return arb.atan2(y, x) if x.mid() >= 0 else arb.pi() + arb.atan2(-y, -x)


def _excess(p: arb) -> arb:
    """p - 2 atan(p / 2).

    It grows with p, and its spread is little where p is little.
    """
    low, high = p.lower(), p.upper()
    return (low - 2 * (low / 2).atan()).union(high - 2 * (high / 2).atan())


def _quarter_arcsine(d: arb) -> arb:
    """asin(d / 4), which grows with d.

    Only distances that are at most 4 count.
    """
    low, high = d.lower(), d.upper()
    highest = (high / 4).asin() if high < 4 else arb.pi() / 2
    return (low / 4).asin().union(highest)


def _with_turns(
    length: arb, arcs: arb, first: arb, left: bool | None, last: arb, right: bool | None
) -> list[arb]:
    """Lengths with outer arcs in [0, 2 pi).

    Whole turns are added to `length` for that. The outer arcs are `first` and `last`, and `arcs` is
    their sum. `left` and `right` are the signs of the first and the last arc, where it is next to
    zero, as `_turns` takes them.
    """
    turn = 2 * arb.pi()
    turns = {m + n for m, n in product(_turns(first, left), _turns(last, right))}
    possible = [m for m in sorted(turns) if not (arcs + m * turn < 0 or arcs + m * turn > 2 * turn)]
    return [length + m * turn for m in possible]
