"""Costates and cut of a shortest word.

Both are in closed form.
"""

from __future__ import annotations

import math
from itertools import pairwise

from dubins_study.study.angle import TWO_PI

# largest distance from +1, -1 or 0 of a rate that names a letter, and between two equal rates
RATE_TOLERANCE = 1e-9
# Pieces that matter for a certificate (docs/derivation.md, section 9).
# rad; an arc that turns by less is straight
NO_TURN = 1e-6
# radii, or share of a path shorter than a radius; a shorter straight is left out
NO_LENGTH = 1e-6
# a costate nu0 below this share of (nu1, nu2) counts as 0: the extremal is abnormal
ABNORMAL = 1e-9


# A piece: rate +1, 0 or -1 and length (radii). A word has three pieces; a missing one is (0, 0).
Piece = tuple[float, float]
Word = tuple[Piece, Piece, Piece]


def nearest_rate(u: float) -> float:
    """Nearest of the rates +1, 0 and -1."""
    if abs(u) > 0.5:
        return math.copysign(1.0, u)
    return 0.0


def cut_margin(word: Word) -> float:
    """Cut margin (rad) of a path.

    The path is S, C, CS or CC with a free final heading. The margin says by how much it stays clear
    of where another path becomes shorter (docs/derivation.md, section 10).
    """
    (turn1, first), (turn2, second), _ = word
    if turn2 != 0.0:  # CC
        longest = 2 * math.atan2(-math.sin(second), 2 - math.cos(second))
        return min(second - math.pi, TWO_PI - second, longest - first)
    if turn1 == 0.0:  # S
        return math.pi
    # CS, or C with a straight of no length
    return 2 * (math.pi - math.atan(second)) - first


def costates(heading: float, word: Word) -> tuple[float, float, bool, float, float]:
    """Costates of a path, in closed form.

    The residuals say how well they satisfy Pontryagin's conditions. For S, C, CS and CC they are
    those of a free final heading, where nu3 is 0; for CSC and CCC those of a given one. Where S
    vanishes there are many. Then those of CSC are taken, which satisfy the conditions whatever the
    arcs (docs/derivation.md, section 9). They have nu3 = 0 at both ends of the second piece. The
    residuals are measured from positions and headings, not from the word.

    Args:
        heading: of the start (rad).
        word: the pieces; the second is S in CSC, and of no length if it is not there.

    Returns:
        nu1 and nu2 in the world frame, with nu0 = 1 or of norm 1 if abnormal; whether nu0 = 0;
        max |H| and sign margin.
    """
    (turn1, first), (turn2, second), (turn3, third) = word
    if second == 0.0 and turn1 == turn3:
        first = first + third
        third = 0.0
    middle = turn1 * first
    last = middle + turn2 * second
    if turn2 != 0.0:  # along or against the chord of the arc
        half = math.cos(second / 2)
        nu0 = abs(half)
        rho = -math.copysign(1.0, half)
        phi = middle + turn2 * second / 2
    else:  # against the heading of S
        nu0 = 1.0
        rho = -1.0
        phi = middle
    angles = (-phi, middle - phi, last - phi, last + turn3 * third - phi)
    turns = (turn1 * first, turn2 * second, turn3 * third)
    arcs = [pair for pair, turn in zip(pairwise(angles), turns, strict=True) if turn != 0.0]
    margin = sign_margin([nu0, rho, 0.0, 0.0], arcs)
    abnormal = nu0 < ABNORMAL
    if abnormal:  # either sign will do
        other = sign_margin([nu0, -rho, 0.0, 0.0], arcs)
        if other > margin:
            rho = -rho
            margin = other
    x1, y1 = _displacement(turn1, first, 0.0)
    x2, y2 = _displacement(turn2, second, middle)
    along = math.cos(phi)
    across = math.sin(phi)
    nu1 = rho * along
    nu2 = rho * across
    start_nu3 = nu2 * x1 - nu1 * y1
    last_nu3 = nu1 * y2 - nu2 * x2
    H1 = nu0 + nu1 + turn1 * start_nu3
    H2 = nu0 + rho * math.cos(middle - phi)
    H3 = nu0 + rho * math.cos(last - phi) + turn3 * last_nu3
    inflected = abs(last_nu3) / max(1.0, first + second + third)
    worst = max(max(abs(H1), abs(H2)), max(abs(H3), inflected))
    size = rho
    if not abnormal:
        size = rho / nu0
    # turn by the heading separately: added to a heading of many turns, phi would lose its digits
    c = math.cos(heading)
    s = math.sin(heading)
    x = size * (c * along - s * across)
    y = size * (s * along + c * across)
    return x, y, abnormal, worst, margin


def _displacement(turn: float, length: float, heading: float) -> tuple[float, float]:
    """Displacement (radii) of a piece driven from a heading."""
    half = turn * length / 2
    chord = length
    if half != 0.0:
        chord = length * (math.sin(half) / half)
    return chord * math.cos(heading + half), chord * math.sin(heading + half)


def sign_margin(nu: list[float], arcs: list[tuple[float, float]]) -> float:
    """Least -u nu3 over the turning pieces.

    It is the least nu0 + nu1 cos + nu2 sin, which is -u nu3 where H = 0. `arcs` are the headings
    (rad) at the ends of the pieces.
    """
    if not arcs:
        return 0.0
    nu0, nu1, nu2, _ = nu
    # the least is at the heading opposite to (nu1, nu2) if an arc passes through it, or at an end
    opposite = math.atan2(-nu2, -nu1)
    nearest = -1.0
    for before, after in arcs:
        a = before - opposite
        b = after - opposite
        if max(a, b) // TWO_PI > min(a, b) // TWO_PI:
            return nu0 - math.hypot(nu1, nu2)
        nearest = max(nearest, math.cos(a), math.cos(b))
    return nu0 - math.hypot(nu1, nu2) * nearest
