"""The grids of `heading-milp`: where turns may end, where that leads, and which legs go with it.

In the vehicle's frame at unit radius. A choice says after how many steps each turn ends. With it
go the straight legs that may be driven towards the ends of the turns, at headings on a grid too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.path import FloatArray

FULL_TURN = 2 * math.pi
# A shortest CC path turns first by at most this and then by more than three times this, so that
# its net turn is at least twice this (docs/derivation.md, section 4).
FIRST_ARC = math.pi / 3
_PAIRS = 650  # all pairs of 72 headings
_HALVINGS = 25  # of a step, down to where a target is on the circle for all that rounding tells


class Turns(NamedTuple):
    """A turn that may end after each of k steps.

    Args:
        sign: 1 if it is to the family's side, -1 if away from it.
        turn: shape (k,), rad, where it may end: the heading's angle, unsigned.
        length: shape (k,), radii, what it adds to the path's length.
        shift: shape (2, k), radii, what it adds to the end point, for a family to the left.
        leg: shape (k, m), rad, headings of the legs at its end, unsigned.
    """

    sign: int
    turn: FloatArray
    length: FloatArray
    shift: FloatArray
    leg: FloatArray


@dataclass(frozen=True, eq=False)
class Family:
    """The paths of one shape.

    Args:
        name: the word.
        side: 1 if its last turn is to the left, else -1.
        turns: its turns, one after another.
        pick: for every turn, shape (n,): which of its ends each of the n choices takes.
    """

    name: str
    side: int
    turns: tuple[Turns, ...]
    pick: tuple[NDArray[np.intp], ...]

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
    # nearer to the circle, the turn ends less than two steps before the place where it passes
    passing = math.atan2(X, 1 - left) if abs(beyond) < 2 * step**2 else None
    return _one_turn(side, headings, legs, 0 < left < step * (X + step), passing)


@lru_cache(maxsize=64)
def _one_turn(side: int, headings: int, legs: int, ahead: bool, passing: float | None) -> Family:
    """Equal steps up to a full turn, and shorter ones where a target needs them.

    To a target outside a turning circle by e radii a turn ends h = sqrt(2 e) before the place where
    it would pass the target, `passing` (rad). One that ends x before that place, h/2 < x <= h, gets
    there with a leg (h^2 - x^2) / 2x before its end, which is less than 2x. So a step that is
    halved again and again leads up to the place. To a target nearly `ahead` a turn is shorter than
    a step, and a longer one passes it: there the halved steps lead down to the start.

    Besides the legs within the last step there is one at the step before: if the shortest path
    turns only just into a step, taking all of it calls for a leg a little before it.
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
    """RL (`side` 1) or LR: a turn of up to a sixth of a circle, then one back past the start's.

    A choice is a pair of ends. The second turn begins at heading -a, where the first one ends:
    its arc from there to heading 0 depends on the first turn alone and is counted with it. Legs
    are driven at the ends of last steps; more of them would make no path shorter by much, since
    it is in these places that a shortest CC path is lengthened at no cost of first order.

    The pairs come in families of up to `_PAIRS`, of a few ends of the first turn each: the time
    and memory in which cvxpy compiles a family grow with the square of their number.
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
