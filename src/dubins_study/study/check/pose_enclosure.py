"""Proven intervals around the shortest length of a leg with a given final heading.

As `study.check.enclosure`, for all ends whose two coordinates and heading in the start's frame are
within delta of the exact values that the doubles give (`study.closed_form.pose.Leg`). The ends are
divided by the signs of eight functions, of whose zeros all edges of the six words consist. Most
signs are the same for all ends. For each combination of the others every word exists or does not,
and its arcs are whole turns or nothing; so the least of its lengths can be taken
(docs/derivation.md, section 15). That one of the six words is shortest is Dubins' theorem.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from typing import NamedTuple

from flint import arb, ctx

from dubins_study.study.body_coordinates import PER_DISTANCE, PER_EXTENT
from dubins_study.study.check.enclosure import BITS, Enclosure, below, ceiling_of, outwards
from dubins_study.study.closed_form.pose import PER_HEADINGS, WORDS6
from dubins_study.study.scenario import Pose


class _Ends(NamedTuple):
    """The ends in the start's frame, as balls: X, Y, heading, its sine and cosine."""

    X: arb
    Y: arb
    turn: arb
    s: arb
    c: arb

    @property
    def mirrored(self) -> _Ends:
        return _Ends(self.X, -self.Y, -self.turn, -self.s, self.c)


class _Signs(NamedTuple):
    """On which side of each edge an end lies: whether the function is not negative.

    The sides of the end's circles from the start's line, those of the start's circles from the
    end's line, |E - C|^2 - 4 for the circles of LSR and RSL, 16 - |E - C|^2 for those of LRL, RLR.
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
        """The signs of the mirror image: circles change their names, sides their signs."""
        return _Signs(
            *(not self.start_right, not self.start_left, not self.end_right, not self.end_left),
            *(self.reach_rsl, self.reach_lsr, self.reach_rlr, self.reach_lrl),
        )

    @property
    def possible(self) -> bool:
        """The left circle's function is below the right one's, by 2 (1 - cos)."""
        return self.start_right >= self.start_left and self.end_right >= self.end_left


@lru_cache(maxsize=16384)
def enclose_pose(start: Pose, end: Pose, radius: float, branch: str = "best") -> Enclosure:
    """Enclose the shortest lengths of a branch, `best` or one of `WORDS6`, over all ends."""
    with ctx.workprec(BITS):
        ends = _ends(start, end, radius)
        sure = [[length] for side in (ends, ends.mirrored) for length in _nearly_one_arc(side)]
        parts: list[arb] = []
        absent = False
        for signs in _cells(ends):
            if branch == "best":
                words = [lengths for word in WORDS6 if (lengths := _lengths(word, ends, signs))]
                least = ceiling_of([*words, *sure])
                parts += below(least, [length for word in words for length in word])
            else:
                lengths = _lengths(branch, ends, signs)
                parts += lengths
                absent |= not lengths
        return outwards(parts, absent, radius)


def _ends(start: Pose, end: Pose, radius: float) -> _Ends:
    R = arb(radius)
    sine, cosine = arb(start.heading).sin_cos()
    x, y = (arb(end.x) - arb(start.x)) / R, (arb(end.y) - arb(start.y)) / R
    extent = (abs(arb(start.x)) + abs(arb(start.y)) + abs(arb(end.x)) + abs(arb(end.y))) / R
    delta = PER_EXTENT * extent + PER_DISTANCE * (abs(x) + abs(y)) + PER_HEADINGS
    blur = delta.union(-delta)
    # whole turns are told from the doubles' angle: of a heading of 1e20 they take many more digits
    with ctx.workprec(BITS + max(0, math.frexp(end.heading - start.heading)[1])):
        turn = arb(end.heading) - arb(start.heading)
        turn -= 2 * arb.pi() * (turn / (2 * arb.pi())).mid().floor()
    turn += blur
    return _Ends(x * cosine + y * sine + blur, y * cosine - x * sine + blur, turn, *turn.sin_cos())


def _cells(ends: _Ends) -> Iterator[_Signs]:
    """The combinations of signs that some of the ends may have."""
    X, Y, _, s, c = ends
    across, versine = X * s - Y * c, 1 - c
    functions = (
        *(Y - versine, Y + versine, across - versine, across + versine),
        *(_square(X + s, Y - c - 1) - 4, _square(X - s, Y + c + 1) - 4),
        *(16 - _square(X - s, Y + c - 1), 16 - _square(X + s, Y - c + 1)),
    )
    sides = [(True,) if f >= 0 else (False,) if f < 0 else (True, False) for f in functions]
    return (signs for signs in (_Signs(*cell) for cell in product(*sides)) if signs.possible)


def _square(x: arb, y: arb) -> arb:
    return x * x + y * y


def _lengths(word: str, ends: _Ends, signs: _Signs) -> list[arb]:
    """The lengths of a word, of which one is the end's; none where it does not exist."""
    if word in ("RSR", "RSL", "RLR"):
        ends, signs = ends.mirrored, signs.mirrored
        word = {"RSR": "LSL", "RSL": "LSR", "RLR": "LRL"}[word]
    X, Y, turn, s, c = ends
    # how far S leads forward, seen from both ends, or the chord of the middle arc's centres
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
        return _with_turns(length, 2 * first - turn, first, left, first - turn, right)
    x, y = X - s, Y + c - 1
    d, first = _square(x, y).nonnegative_part().sqrt(), _direction(x, y)
    if word == "LSL":
        left = signs.start_left if x > 0 else None
        right = signs.end_left if forward > 0 else None
        return _with_turns(d + turn, turn, first, left, turn - first, right)
    if not signs.reach_lrl:
        return []
    half = arb.pi() - _quarter_arcsine(d)
    left = not signs.reach_rsl if x < 0 else None
    right = not signs.reach_lsr if forward < 0 else None
    arcs, rest = turn + 2 * half, turn - first + half
    return _with_turns(arcs + 2 * half, arcs, first + half, left, rest, right)


def _nearly_one_arc(ends: _Ends) -> Iterator[arb]:
    """Lengths of paths S L S and R S L S R that all ends have: next to one arc above pi, as long.

    Signs do not tell there that no word but the arc and a full turn is longer. The outer arcs e
    make the middle one more than half a turn where the arc is just that.
    """
    X, Y, turn, s, c = ends
    full = 2 * arb.pi()
    turn -= full * math.floor(float((turn / full).mid()))
    for e in (arb(0), arb(math.sqrt(float(X.rad())))):
        sine, versine = 2 * e.sin(), 2 - 2 * e.cos()
        x = X - s - sine * (1 + c) + versine * s
        y = Y + c - 1 - sine * s + versine * (1 - c)
        arc = turn + 2 * e
        if arc > arb.pi() and arc < full:
            yield 2 * e + arc + _square(x, y).nonnegative_part().sqrt() / abs((arc / 2).cos())


def _direction(x: arb, y: arb) -> arb:
    """An angle of (x, y), whatever its turns; any angle where that may be the origin."""
    if not (x < 0 or x > 0 or y < 0 or y > 0):
        return arb(0, 4)
    return arb.atan2(y, x) if x.mid() >= 0 else arb.pi() + arb.atan2(-y, -x)


def _excess(p: arb) -> arb:
    """p - 2 atan(p / 2), which grows with p: little where p is little."""
    low, high = p.lower(), p.upper()
    return (low - 2 * (low / 2).atan()).union(high - 2 * (high / 2).atan())


def _quarter_arcsine(d: arb) -> arb:
    """asin(d / 4), which grows with d, of the distances that are at most 4."""
    low, high = d.lower(), d.upper()
    return (low / 4).asin().union((high / 4).asin() if high < 4 else arb.pi() / 2)


def _with_turns(
    length: arb, arcs: arb, first: arb, left: bool | None, last: arb, right: bool | None
) -> list[arb]:
    """The length and the turns that bring both outer arcs, of sum `arcs`, to [0, 2 pi)."""
    turn = 2 * arb.pi()
    turns = {m + n for m in _turns(first, left) for n in _turns(last, right)}
    possible = [m for m in sorted(turns) if not (arcs + m * turn < 0 or arcs + m * turn > 2 * turn)]
    return [length + m * turn for m in possible]


def _turns(angle: arb, positive: bool | None) -> list[int]:
    """How many turns bring an angle to [0, 2 pi); next to zero it has the sign that is given."""
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
