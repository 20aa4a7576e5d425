"""The word and the costates of a path of at most two arcs, in plain scalar arithmetic.

Python runs these functions for one path; `judging.verdict_frame` compiles `path_word` for millions.
"""

from __future__ import annotations

import math
from itertools import pairwise

from dubins_study.study.angle import TWO_PI
from dubins_study.study.path import RIPPLE

PATH_WORDS = ("", "S", "L", "R", "LS", "RS", "LR", "RL", "SL", "SR")
# A run of arcs that turns by less than this (rad) is straight; a straight shorter than this share
# of the path is left out.
WORD = 1e-6
# how far from +1, -1 or 0 a rate may be and still name a letter
FULL_RATE = 1e-9
# A certificate is read from the pieces that matter (docs/derivation.md, section 9): an arc that
# turns by less than this (rad) is straight,
NO_TURN = 1e-6
# and a straight shorter than this (radii, or share of a path shorter than a radius) is left out.
NO_LENGTH = 1e-6
# a costate nu0 below this share of (nu1, nu2) is none: the extremal is abnormal
ABNORMAL = 1e-9


def path_word(k1: float, l1: float, k2: float, l2: float) -> int:
    """`Path.word` of two arcs of curvatures k and lengths l >= 0, as an index into `PATH_WORDS`."""
    k1, k2 = (k1 if l1 > 0.0 else 0.0), (k2 if l2 > 0.0 else 0.0)
    ripple = RIPPLE * max(abs(k1), abs(k2))
    # 0 straight, 1 left, 2 right
    side1 = (1 if k1 > 0.0 else 2) if abs(k1) > ripple else 0
    side2 = (1 if k2 > 0.0 else 2) if abs(k2) > ripple else 0
    turn1, turn2 = abs(k1) * l1, abs(k2) * l2
    both = turn1 + turn2
    one_side = side1 == side2
    a = side1 if (both if one_side else turn1) > WORD else 0
    b = side2 if (both if one_side else turn2) > WORD else 0
    total = l1 + l2
    alike = a == b
    seen1 = (a > 0) | ((total if alike else l1) > WORD * total)
    seen2 = (b > 0) | ((total if alike else l2) > WORD * total)
    one = (a if seen1 else b) + 1 if seen1 | seen2 else 0  # "", S, L, R
    two = (3 + a if b == 0 else 5 + a) if a > 0 else 7 + b  # LS RS, LR RL, SL SR
    return two if seen1 & seen2 & (not alike) else one


def nearest_rate(u: float) -> float:
    """The rate +1, 0 or -1 that a rate is nearest to."""
    return math.copysign(1.0, u) if abs(u) > 0.5 else 0.0


def costates(
    heading: float, turn1: float, first: float, turn2: float, second: float
) -> tuple[float, float, bool, float, float, float]:
    """The costates of a word S, C, CS or CC in closed form, and how well they satisfy Pontryagin.

    The final heading is free: nu3 is 0 at the end (docs/derivation.md, sections 9 and 10).

    Args:
        heading: of the start (rad).
        turn1, turn2: rates +1, 0 or -1 of the pieces; turn1 is 0 only if there is but one.
        first, second: their lengths in radii.

    Returns:
        nu1 and nu2 in the world frame, with nu0 = 1 or of norm 1 if abnormal; whether nu0 = 0;
        max |H|, sign margin and cut margin.
    """
    if turn2 != 0.0:
        longest = 2 * math.atan2(-math.sin(second), 2 - math.cos(second))
        cut = min(min(second - math.pi, TWO_PI - second), longest - first)
    else:
        cut = math.pi if turn1 == 0.0 else 2 * (math.pi - math.atan(second)) - first
    x, y, abnormal, worst, margin = _inflected(heading, turn1, first, turn2, second, 0.0, 0.0)
    return x, y, abnormal, worst, margin, cut


def pose_costates(
    heading: float,
    turn1: float,
    first: float,
    turn2: float,
    second: float,
    turn3: float,
    third: float,
) -> tuple[float, float, bool, float, float]:
    """The costates of a leg with a given final heading, a path CSC or CCC or a part of one.

    Where S vanishes, or an arc of CCC, there are many: then those of CSC are taken, which satisfy
    Pontryagin's conditions whatever the arcs (docs/derivation.md, section 9).

    Args:
        heading: of the start (rad).
        turn1, turn2, turn3: rates +1, 0 or -1 of the pieces; turn2 is 0 in CSC.
        first, second, third: their lengths in radii, 0 for what is not there.

    Returns:
        As `costates`, without the cut margin.
    """
    if turn2 != 0.0 and first == 0.0:
        turn1, first, turn2, second = turn2, second, 0.0, 0.0
    elif turn2 != 0.0 and third == 0.0:
        turn2, second, turn3, third = 0.0, 0.0, turn2, second
    if second == 0.0 and turn1 == turn3:
        first, third = first + third, 0.0
    return _inflected(heading, turn1, first, turn2, second, turn3, third)


def _inflected(
    heading: float,
    turn1: float,
    first: float,
    turn2: float,
    second: float,
    turn3: float,
    third: float,
) -> tuple[float, float, bool, float, float]:
    """Costates with nu3 = 0 at both ends of the second piece, and how well they satisfy Pontryagin.

    What is measured comes from positions and headings, not from the word.
    """
    middle = turn1 * first
    last = middle + turn2 * second
    if turn2 != 0.0:  # along or against the chord of the arc
        half = math.cos(second / 2)
        nu0, rho, phi = abs(half), -math.copysign(1.0, half), middle + turn2 * second / 2
    else:  # against the heading of S
        nu0, rho, phi = 1.0, -1.0, middle
    angles = (-phi, middle - phi, last - phi, last + turn3 * third - phi)
    turns = (turn1 * first, turn2 * second, turn3 * third)
    arcs = [pair for pair, turn in zip(pairwise(angles), turns, strict=True) if turn != 0.0]
    margin = min((_least(nu0, rho, *arc) for arc in arcs), default=0.0)
    abnormal = nu0 < ABNORMAL
    if abnormal:  # either sign will do
        other = min((_least(nu0, -rho, *arc) for arc in arcs), default=0.0)
        rho, margin = (-rho, other) if other > margin else (rho, margin)
    x1, y1 = _displacement(turn1, first, 0.0)
    x2, y2 = _displacement(turn2, second, middle)
    along, across = math.cos(phi), math.sin(phi)
    nu1, nu2 = rho * along, rho * across
    start_nu3, last_nu3 = nu2 * x1 - nu1 * y1, nu1 * y2 - nu2 * x2
    H1 = nu0 + nu1 + turn1 * start_nu3
    H2 = nu0 + rho * math.cos(middle - phi)
    H3 = nu0 + rho * math.cos(last - phi) + turn3 * last_nu3
    inflected = abs(last_nu3) / max(1.0, first + second + third)
    worst = max(max(abs(H1), abs(H2)), max(abs(H3), inflected))
    size = rho if abnormal else rho / nu0
    # turned by the heading apart: added to a heading of many turns, phi would lose its digits
    c, s = math.cos(heading), math.sin(heading)
    x, y = size * (c * along - s * across), size * (s * along + c * across)
    return x, y, abnormal, worst, margin


def _displacement(turn: float, length: float, heading: float) -> tuple[float, float]:
    """Displacement (radii) of a piece driven from a heading."""
    half = turn * length / 2
    chord = length * (math.sin(half) / half if half != 0.0 else 1.0)
    return chord * math.cos(heading + half), chord * math.sin(heading + half)


def _least(nu0: float, rho: float, a: float, b: float) -> float:
    """Least nu0 + rho cos(theta) for theta between a and b, as in `extremal.sign_margin`."""
    low, high = min(a, b), max(a, b)
    if rho < 0.0:  # least where the cosine is greatest
        passed = math.floor(high / TWO_PI) > math.floor(low / TWO_PI)
        return nu0 + rho * (1.0 if passed else max(math.cos(a), math.cos(b)))
    passed = math.floor((high - math.pi) / TWO_PI) > math.floor((low - math.pi) / TWO_PI)
    return nu0 + rho * (-1.0 if passed else min(math.cos(a), math.cos(b)))
