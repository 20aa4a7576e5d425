"""The grids of `heading-milp`: where turns may end, where that leads, and which legs go with it.

In the vehicle's frame at unit radius, turning to the left first seen (`side` 1) or in the mirror
(`side` -1). A choice is a turning step after which a turn may end. It carries the straight legs
that may be driven during this last step, at headings spread evenly over it, ends included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from study.path import FloatArray

FULL_TURN = 2 * math.pi
# A shortest CC path turns first by at most this and then by more than three times this, so that
# its net turn is at least twice this (THEORY section 3).
FIRST_ARC = math.pi / 3
# How much longer than the bee-line a path is that is worth looking for: a turn, then a straight
# of at most one radius more than the distance, and a step's coarseness.
DETOUR = 3 * math.pi


class Turns(NamedTuple):
    """A group of n choices, of which one is made.

    Args:
        turn: shape (n,), the heading's angle at the end of the turn, rad, unsigned.
        length: shape (n,), what the turn adds to the path's length, radii.
        shift: shape (2, n), what it adds to the path's end point, radii.
        leg: shape (n, q + 1), headings of the legs that go with a choice, rad, unsigned.
        sign: 1 if the turn is to the side that the frame is seen from, -1 if away from it.
    """

    turn: FloatArray
    length: FloatArray
    shift: FloatArray
    leg: FloatArray
    sign: int


@dataclass(frozen=True, eq=False)
class Family:
    """The paths of one shape: a turn and a straight, or two turns, with legs at their last steps.

    `side` is 1 if the (last) turn is to the left.
    """

    name: str
    side: int
    turns: tuple[Turns, ...]

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """Number of choices in every group."""
        return tuple(group.turn.size for group in self.turns)

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Where every group begins among all N choices."""
        return tuple(int(n) for n in np.cumsum((0, *self.sizes[:-1])))

    @cached_property
    def length(self) -> FloatArray:
        """What each choice adds to the length, shape (N,) over all groups, radii."""
        return np.concatenate([group.length for group in self.turns])

    @cached_property
    def shift(self) -> FloatArray:
        """What each choice adds to the end point, shape (2, N), radii."""
        shift = np.hstack([group.shift for group in self.turns])
        shift[1] *= self.side
        return shift

    @cached_property
    def heading(self) -> FloatArray:
        """Headings of the legs, shape (N, q + 1), rad, in the vehicle's frame."""
        return self.side * np.vstack([group.sign * group.leg for group in self.turns])

    @cached_property
    def direction(self) -> FloatArray:
        """Unit vectors along the legs, shape (2, N (q + 1))."""
        heading = self.heading.ravel()
        return np.array([np.cos(heading), np.sin(heading)])


@lru_cache(maxsize=64)
def one_turn(side: int, headings: int, legs: int, distance: float) -> Family:
    """LS (`side` 1) or RS: one turn of up to a full circle."""
    turn = _grid(headings, distance)
    name = "LS" if side > 0 else "RS"
    return Family(name, side, (Turns(turn, turn, _arc(turn), _legs(turn, legs), 1),))


@lru_cache(maxsize=64)
def two_turns(side: int, headings: int, legs: int) -> Family:
    """RL (`side` 1) or LR: a turn of up to a sixth of a circle, then one back beyond the start's.

    The second turn's arc begins where the first one ends, at heading -a. In headings it is the
    arc from -a to 0 and the arc from 0 on; the former depends on the first turn alone, which
    makes the end point a sum of a term for either turn.
    """
    step = FULL_TURN / headings
    away = np.arange(int(FIRST_ARC / step + 1e-9) + 1) * step
    back = np.arange(int(2 * FIRST_ARC / step), headings + 1) * step
    there_and_back = np.array([2 * np.sin(away), 2 * np.cos(away) - 2])
    first = Turns(away, 2 * away, there_and_back, _legs(away, legs), -1)
    # its first choice may end a step that began before the grid's least turn
    leg = _legs(np.concatenate(([back[0] - step], back)), legs)[1:]
    return Family("RL" if side > 0 else "LR", side, (first, Turns(back, back, _arc(back), leg, 1)))


def _grid(headings: int, distance: float) -> FloatArray:
    """Turns after which a straight may begin, shape (headings + 1,), from 0 to a full turn.

    Equal steps; but a target nearer than a radius can call for a turn as small as its distance,
    so a quarter of the steps is kept for turns of up to twice that.
    """
    near = 2 * distance
    few = headings // 4
    if near >= few * FULL_TURN / headings:
        return np.linspace(0.0, FULL_TURN, headings + 1)
    return np.concatenate(
        (np.linspace(0.0, near, few + 1)[:-1], np.linspace(near, FULL_TURN, headings - few + 1))
    )


def _arc(turn: FloatArray) -> FloatArray:
    """End points (2, n) of left arcs from the origin, facing +x."""
    return np.array([np.sin(turn), 1 - np.cos(turn)])


def _legs(turn: FloatArray, legs: int) -> FloatArray:
    """Headings (n, legs + 1) spread over the step that ends at each turn (n,)."""
    step = np.diff(turn, prepend=turn[0])
    part: FloatArray = np.linspace(-1.0, 0.0, legs + 1)
    return turn[:, None] + step[:, None] * part
