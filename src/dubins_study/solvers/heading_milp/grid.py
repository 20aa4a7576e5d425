"""The grids of `heading-milp` in body coordinates at unit radius.

They are where turns may end, and the headings of straight legs near the end of every turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import FloatArray

FULL_TURN = 2 * math.pi
# The first arc of a shortest CC path is at most pi/3 and the second one above pi, so that its net
# turn is at least 2 pi/3 (docs/derivation.md, section 4).
FIRST_ARC = math.pi / 3
_PAIRS = 650  # all pairs of 72 headings
_HALVINGS = 25  # of a step; after that many, rounding puts the target on the circle


class Turns(NamedTuple):
    """A turn that may end after each of k steps; lengths in radii."""

    sign: int  # 1 if it is to the family's side, -1 if away from it
    turn: FloatArray  # shape (k,), rad, unsigned: the headings at which it may end
    length: FloatArray  # shape (k,), the length that it adds to the path
    shift: FloatArray  # shape (2, k), the displacement that it adds, for a family to the left
    leg: FloatArray  # shape (k, m), rad, unsigned: headings of the legs at its end


@dataclass(frozen=True, eq=False)
class Family:
    """The paths of one word: n choices of the ends of its turns."""

    name: str
    side: int  # 1 if the last turn is to the left, else -1
    turns: tuple[Turns, ...]  # in driving order
    pick: tuple[NDArray[np.intp], ...]  # for every turn, shape (n,): its end in each choice

    @cached_property
    def length(self) -> FloatArray:
        """Length of each choice's turns, shape (n,), radii."""
        pairs = zip(self.turns, self.pick, strict=True)
        length: FloatArray = np.sum([turns.length[ends] for turns, ends in pairs], axis=0)
        return length

    @cached_property
    def shift(self) -> FloatArray:
        """End point of each choice's turns, shape (2, n), radii."""
        pairs = zip(self.turns, self.pick, strict=True)
        shift: FloatArray = np.sum([turns.shift[:, ends] for turns, ends in pairs], axis=0)
        shift[1] *= self.side
        return shift

    @cached_property
    def heading(self) -> FloatArray:
        """Headings of each choice's legs, turn by turn, shape (n, m), rad."""
        pairs = zip(self.turns, self.pick, strict=True)
        return self.side * np.hstack([turns.sign * turns.leg[ends] for turns, ends in pairs])


def one_turn(side: int, headings: int, legs: int, X: float, Y: float) -> Family:
    """LS (`side` 1) or RS to a target at (X, Y) radii: one turn of up to a full circle."""
    step, left = FULL_TURN / headings, side * Y
    beyond = math.hypot(X, 1 - left) - 1
    # next to the circle the turn ends less than two steps before it passes the target
    passing = math.atan2(X, 1 - left) if abs(beyond) < 2 * step**2 else None
    return _one_turn(side, headings, legs, 0 < left < step * (X + step), passing)


@lru_cache(maxsize=64)
def _one_turn(side: int, headings: int, legs: int, ahead: bool, passing: float | None) -> Family:
    """Equal steps up to a full turn, and shorter ones where a target needs them.

    A target e radii outside a turning circle is reached by a turn that ends h = sqrt(2 e) before
    the angle `passing` (rad), at which it would pass the target. A turn that ends x before that
    angle, h/2 < x <= h, also reaches it, with a leg (h^2 - x^2) / 2x before its end, which is less
    than 2x. So steps that are halved again and again are added before `passing`. For a target
    nearly `ahead` the turn is shorter than a step, and halved steps are added after the start.

    Besides the legs within the last step there is one a step earlier: if the shortest path turns
    only a little into a step, a turn of the whole step needs a leg a little before it.
    """
    step = FULL_TURN / headings
    short = np.append(step * 0.5 ** np.arange(_HALVINGS), 0.0)
    ends = [np.linspace(0.0, FULL_TURN, headings + 1)]
    spans = [np.full(headings + 1, step)]
    if ahead:
        ends, spans = [*ends, short], [*spans, short]
    if passing is not None:
        ends, spans = [*ends, np.mod(passing - short, FULL_TURN)], [*spans, short]
    turn = np.concatenate(ends)
    parts = np.append(-2.0, np.linspace(-1.0, 0.0, legs + 1))
    leg = _legs(turn, np.concatenate(spans), parts)
    turns = Turns(1, turn, turn, _arc(turn), leg)
    return Family("LS" if side > 0 else "RS", side, (turns,), (np.arange(turn.size),))


@lru_cache(maxsize=64)
def two_turns(side: int, headings: int) -> tuple[Family, ...]:
    """RL (`side` 1) or LR: a turn of up to a sixth of a circle, then a turn back beyond heading 0.

    A choice is a pair of ends. The second turn's arc from the end of the first to heading 0 is
    counted as part of the first. Legs are driven at the ends of the turns' last steps: elsewhere
    they would hardly shorten a path. Each family has up to `_PAIRS` pairs, since the time and
    memory in which cvxpy compiles a family grow with the square of their number.
    """
    step = FULL_TURN / headings
    away = step * np.arange(int(FIRST_ARC / step + 1e-9) + 1, dtype=np.float64)
    back = step * np.arange(int(2 * FIRST_ARC / step), headings + 1, dtype=np.float64)
    there_and_back = np.array([2 * np.sin(away), 2 * np.cos(away) - 2])
    parts = np.array([-1.0, 0.0])
    first = _legs(away, np.full(away.size, step), parts)
    second = _legs(back, np.full(back.size, step), parts)
    turns = (
        Turns(-1, away, 2 * away, there_and_back, first),
        Turns(1, back, back, _arc(back), second),
    )
    at_once = max(1, _PAIRS // back.size)
    blocks = [np.arange(away.size)[n : n + at_once] for n in range(0, away.size, at_once)]
    name = "RL" if side > 0 else "LR"
    return tuple(
        Family(
            name,
            side,
            turns,
            (np.repeat(ends, back.size), np.tile(np.arange(back.size), ends.size)),
        )
        for ends in blocks
    )


def _arc(turn: FloatArray) -> FloatArray:
    """End points (2, k) of left arcs (k,) from the origin, facing +x."""
    return np.array([np.sin(turn), 1 - np.cos(turn)])


def _legs(turn: FloatArray, span: FloatArray, parts: FloatArray) -> FloatArray:
    """Headings (k, m) that are parts (m,) of angles (k,) off the turns (k,), none below zero."""
    return np.maximum(turn[:, None] + span[:, None] * parts, 0.0)


# The largest miss in radii that counts as none: a hundredth of 1e-8, and far above rounding.
ROUNDED = 1e-10
_PARALLEL = 1e-15  # sine of the angle between two legs that count as parallel


def rounding(bridged: FloatArray) -> FloatArray:
    """The miss (radii) that rounding explains where legs bridge these distances (radii)."""
    return ROUNDED + 16 * EPS * bridged


class Legs(NamedTuple):
    """The straights of a path: lengths in radii, in the order of the family's legs."""

    length: FloatArray  # shape (m,)
    duals: FloatArray | None  # (2,), of the least length by the target; None without legs


def least_legs(heading: FloatArray, gap: FloatArray) -> Legs | None:
    """The shortest legs along headings (m,) that bridge a gap (2,), in radii; None if none do.

    A linear program in two equations has a solution with two legs, so every pair is tried. The
    duals are the vector whose product with both legs' directions is 1: Pontryagin's condition on
    the costates.
    """
    length = np.zeros(heading.size)
    bridged = np.hypot(*gap)
    if bridged <= ROUNDED:
        return Legs(length, None)
    u = np.array([np.cos(heading), np.sin(heading)])
    along, across = gap @ u, gap[1] * u[0] - gap[0] * u[1]
    one = int(np.argmin(np.where(along > 0, np.abs(across), np.inf)))
    if along[one] > 0 and abs(across[one]) <= rounding(bridged):
        length[one] = along[one]
        return Legs(length, u[:, one])
    first, second = np.triu_indices(heading.size, 1)
    sine = np.sin(heading[second] - heading[first])
    crossed = np.abs(sine) > _PARALLEL
    first, second, sine = first[crossed], second[crossed], sine[crossed]
    by_first, by_second = -across[second] / sine, across[first] / sine
    ahead = np.flatnonzero((by_first >= 0) & (by_second >= 0))
    if not ahead.size:
        return None
    best = ahead[np.argmin((by_first + by_second)[ahead])]
    pair = [first[best], second[best]]
    length[pair] = by_first[best], by_second[best]
    both = u[:, pair].sum(axis=1)
    return Legs(length, both / (1 + u[:, pair[0]] @ u[:, pair[1]]))


def controls(family: Family, choice: int, legs: FloatArray) -> tuple[list[float], list[float]]:
    """Curvatures and lengths at unit radius of a choice and its legs (m,), without empty pieces."""
    pieces: list[tuple[float, float]] = []
    heading, done = 0.0, 0
    for turns, ends in zip(family.turns, family.pick, strict=True):
        end = int(ends[choice])
        stops = turns.leg[end].tolist()
        lengths = legs[done : done + len(stops)].tolist()
        done += len(stops)
        driven = [stop for stop in zip(stops, lengths, strict=True) if stop[1] > 0]
        for stop, length in [*driven, (float(turns.turn[end]), 0.0)]:
            arc = turns.sign * (turns.sign * stop - heading)
            heading = turns.sign * stop
            pieces += [(float(turns.sign * family.side), arc), (0.0, length)]
    kept = [(curvature, length) for curvature, length in pieces if length > 0]
    return [curvature for curvature, _ in kept], [length for _, length in kept]
