"""The grids of `heading-milp`: where turns may end, where that leads, and which legs go with it.

In the vehicle's frame at unit radius. A choice says after how many steps each turn ends. With it
go the straight legs that may be driven during a turn's last step, at headings spread evenly over
that step, its ends included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from study.path import FloatArray

FULL_TURN = 2 * math.pi
# A shortest CC path turns first by at most this and then by more than three times this, so that
# its net turn is at least twice this (THEORY section 3).
FIRST_ARC = math.pi / 3
# How much longer than the bee-line a path is that is worth looking for: a full turn, a straight
# longer than the distance by a radius, and the grid's coarseness.
DETOUR = 3 * math.pi


class Turns(NamedTuple):
    """A turn that may end after each of k steps.

    Args:
        sign: 1 if it is to the family's side, -1 if away from it.
        turn: shape (k,), rad, where it may end: the heading's angle, unsigned.
        length: shape (k,), radii, what it adds to the path's length.
        shift: shape (2, k), radii, what it adds to the end point, for a family to the left.
        leg: shape (k, q + 1), rad, headings of the legs within the last step, unsigned.
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
        return shift * np.array([[1.0], [self.side]])

    @cached_property
    def heading(self) -> FloatArray:
        """Headings of each choice's legs, turn by turn, shape (n, m), rad."""
        pairs = zip(self.turns, self.pick, strict=True)
        return self.side * np.hstack([turns.sign * turns.leg[ends] for turns, ends in pairs])

    @cached_property
    def direction(self) -> FloatArray:
        """Unit vectors along the legs, shape (2, n m)."""
        heading = self.heading.ravel()
        return np.array([np.cos(heading), np.sin(heading)])


@lru_cache(maxsize=64)
def one_turn(side: int, headings: int, legs: int, distance: float) -> Family:
    """LS (`side` 1) or RS: one turn of up to a full circle.

    Args:
        side, headings, legs: as in `HeadingMilp`.
        distance: how far the target is, radii.
    """
    turn = _grid(headings, distance)
    step = np.diff(turn, prepend=0.0)
    turns = Turns(1, turn, turn, _arc(turn), _legs(turn, step, legs))
    return Family("LS" if side > 0 else "RS", side, (turns,), (np.arange(turn.size),))


@lru_cache(maxsize=64)
def two_turns(side: int, headings: int) -> Family:
    """RL (`side` 1) or LR: a turn of up to a sixth of a circle, then one back past the start's.

    A choice is a pair of ends. The second turn begins at heading -a, where the first one ends:
    its arc from there to heading 0 depends on the first turn alone and is counted with it. Legs
    are driven at the ends of last steps; more of them would make no path shorter by much, since
    it is in these places that a shortest CC path is lengthened at no cost of first order.
    """
    step = FULL_TURN / headings
    away = np.arange(int(FIRST_ARC / step + 1e-9) + 1) * step
    back = np.arange(int(2 * FIRST_ARC / step), headings + 1) * step
    there_and_back = np.array([2 * np.sin(away), 2 * np.cos(away) - 2])
    # a turn that does not begin has no step before its end
    first = _legs(away, np.where(away > 0, step, 0.0), 1)
    turns = (
        Turns(-1, away, 2 * away, there_and_back, first),
        Turns(1, back, back, _arc(back), _legs(back, np.full(back.size, step), 1)),
    )
    ends = np.divmod(np.arange(away.size * back.size), back.size)
    return Family("RL" if side > 0 else "LR", side, turns, ends)


def _grid(headings: int, distance: float) -> FloatArray:
    """Turns after which a straight may begin, shape (headings + 1,), from 0 to a full turn.

    Equal steps; but a target nearer than a radius can call for a turn as small as its distance,
    so a quarter of the steps is kept for turns of up to twice that.
    """
    near, few = 2 * distance, headings // 4
    if near >= few * FULL_TURN / headings:
        return np.linspace(0.0, FULL_TURN, headings + 1)
    return np.concatenate(
        (np.linspace(0.0, near, few + 1)[:-1], np.linspace(near, FULL_TURN, headings - few + 1))
    )


def _arc(turn: FloatArray) -> FloatArray:
    """End points (2, k) of left arcs (k,) from the origin, facing +x."""
    return np.array([np.sin(turn), 1 - np.cos(turn)])


def _legs(turn: FloatArray, step: FloatArray, legs: int) -> FloatArray:
    """Headings (k, legs + 1) spread over the steps (k,) that end at turns (k,)."""
    return turn[:, None] + step[:, None] * np.linspace(-1.0, 0.0, legs + 1)
