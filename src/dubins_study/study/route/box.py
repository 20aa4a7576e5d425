"""A box of headings, and its bounds' common parts.

Everything is in units of the turning radius. For a costate nu any path of a leg is as long as

    nu . P + integral of (1 - nu . e(theta)) ds,    P the way from its start to its end.

Along a word of turns and a straight the integral is the sum of a function of the first heading, one
of the last, and a rest. Less mu times each segment that is near its end, mu >= 0, it is no longer
than the path. nu and mu are chosen so that the rest is of second order and that neither heading is
worth a change. Hence a bound of each word over the box is a constant and two minima over one
heading each, taken in closed form, less a bound of the rest (docs/derivation.md, section 16).

The words here begin with a turn to the left; others are their mirror images. Ranges that decide
which paths count are widened by `SLACK`: paths that do not exist can only lower a bound.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.angle import TWO_PI
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.kernel_compile import separate
from dubins_study.study.route.leg_words import between

_PI = math.pi
SLACK = 1e-13
# a costate of LRL has the length 1 / |cos psi|; longer ones than this are not needed
LONGEST_COSTATE = 20.0
START_LEFT = 1
START_RIGHT = 2
END_LEFT = 4
END_RIGHT = 8
START_HALF = 16
END_HALF = 32


class Box(NamedTuple):
    """A leg and the headings at its ends.

    The leg ends at (x, y), seen from its start. The intervals have middles c and half widths h
    (rad). Each end has the slope of the potential there. The bounded quantity is the length plus
    slope1 (theta1 - c1) less slope2 (theta2 - c2).

    `apart` is a sum of flags. `START_LEFT` says that the leg's end lies on the left turning circle
    of the start, and that no pair of headings in the box is that of the arc there; `START_RIGHT`,
    `END_LEFT` and `END_RIGHT` likewise. `START_HALF` or `END_HALF` is added if the arc is half a
    turn.
    """

    x: float
    y: float
    c1: float
    h1: float
    slope1: float
    c2: float
    h2: float
    slope2: float
    apart: int


class Costate(NamedTuple):
    """A costate and the multipliers of the outer arcs.

    The costate is given by length and direction.
    """

    length: float
    direction: float
    mu1: float
    mu2: float


class Circles(NamedTuple):
    """Way from the first arc's centre to the last.

    It is given at the box's middle, with its range over the box.
    """

    dx: float
    dy: float
    nearest: float
    farthest: float
    along: float  # largest change of the way along itself, and across
    across: float
    turned: float  # rad to either side


@separate
def mirrored(box: Box) -> Box:
    """Box whose paths are the mirror images."""
    left = START_LEFT | END_LEFT
    halves = box.apart & (START_HALF | END_HALF)
    # the flag of a right circle is twice that of the left one
    apart = 2 * (box.apart & left) + (box.apart // 2 & left) + halves
    return Box(box.x, -box.y, -box.c1, box.h1, -box.slope1, -box.c2, box.h2, -box.slope2, apart)


@separate
def circles_of(box: Box, last: float) -> Circles:
    """Way between the outer arcs' centres, with its range.

    The first arc turns left. `last` is the turn of the last one: 1 left, -1 right.
    """
    dx, dy = between(box.x, box.y, 1.0, last, box.c1, box.c2)
    m = math.hypot(dx, dy)
    # a centre moves along its heading, and to second order across it
    reach = box.h1 + box.h2
    bent = 0.5 * (box.h1 * box.h1 + box.h2 * box.h2)
    axis = math.atan2(dy, dx)
    slack = SLACK * (1.0 + m)
    along = abs(math.cos(axis - box.c1)) * box.h1 + abs(math.cos(axis - box.c2)) * box.h2
    across = abs(math.sin(axis - box.c1)) * box.h1 + abs(math.sin(axis - box.c2)) * box.h2
    along, across = min(along + bent, reach) + slack, min(across + bent, reach) + slack
    nearest = max(0.0, m - along)
    turned = _PI
    if nearest > 0.0:
        turned = math.atan2(across, nearest) + SLACK
    farthest = min(math.hypot(m + along, across), m + reach + slack)
    return Circles(dx, dy, nearest, farthest, along, across, turned)


@separate
def least_between(
    m: float, first: float, last: float, rho: float, kappa: float, mu: float, floor: float
) -> tuple[float, float]:
    """Least value of a function over [first, last].

    The function is x + rho sin x - kappa (x - m) - mu x. Below `floor` the first two terms keep the
    value that they have there. The x - m of the least value is returned too.
    """
    best = math.inf
    place = first
    cosine = (kappa + mu - 1.0) / rho
    still = math.nan
    if abs(cosine) <= 1.0:
        still = -math.acos(cosine)
        still += TWO_PI * math.ceil((first - still) / TWO_PI)
    # both ends, two places without slope (`still`), and the kink at `floor`
    for x in (first, last, still, still + TWO_PI, floor):
        if not (first <= x <= last):
            continue
        lifted = max(x, floor)
        value = lifted + rho * math.sin(lifted) - kappa * (x - m) - mu * x
        if value < best:
            best = value
            place = x
    return best, place - m


@separate
def _least(
    middle: float,
    half: float,
    within: tuple[float, float],
    rho: float,
    kappa: float,
    mu: float,
    floor: float,
) -> tuple[float, float]:
    """`least_between` over all intervals around m.

    x is in `within` and within `half` of m, where m is `middle` or differs from it by whole turns.
    The value is infinite if there is no such x.
    """
    low, high = within
    best = math.inf
    place = 0.0
    m = middle + TWO_PI * math.ceil((low - half - middle) / TWO_PI)
    while m - half <= high:
        value, x = least_between(m, max(m - half, low), min(m + half, high), rho, kappa, mu, floor)
        if value < best:
            best = value
            place = x
        m += TWO_PI
    return best, place


@separate
def separated(
    box: Box,
    last: float,
    nu: Costate,
    within1: tuple[float, float],
    within2: tuple[float, float],
    floor: float,
) -> tuple[float, float, float]:
    """Bound without the rest, and where it is attained.

    Returns the bound, then each heading there less the middle of its interval.

    The angles x = phi - theta1 - pi of the first arc and last (theta2 - phi) - pi of the last one,
    phi the costate's direction, count in the ranges that are given.
    """
    rho, phi = nu.length, nu.direction
    f1, x1 = _least(phi - _PI - box.c1, box.h1, within1, rho, box.slope1, nu.mu1, floor)
    f2, x2 = _least(
        last * (box.c2 - phi) - _PI, box.h2, within2, rho, last * box.slope2, nu.mu2, floor
    )
    pulled = rho * (box.x * math.cos(phi) + box.y * math.sin(phi))
    return pulled + f1 + f2 - rounding(box, rho + nu.mu1 + nu.mu2), -x1, last * x2


@separate
def rounding(box: Box, size: float) -> float:
    """Upper limit of a bound's rounding error.

    `size` is the sum of the sizes of its costate and multipliers.
    """
    return EPS * (
        8.0 * size * (abs(box.x) + abs(box.y))
        + 100.0 * (2.0 + 2.0 * size + abs(box.slope1) + abs(box.slope2))
    )


@separate
def turning_bound(box: Box, low: float) -> float:
    """Least turning over the box, with the potential.

    It is the least T + slope1 t1 - slope2 t2. T is theta2 - theta1 plus whole turns, and not below
    `low`. The turning of the first and last arc of LSL is such a T, and so is that of LRL less its
    middle arc's.
    """
    middle = box.c2 - box.c1
    half = box.h1 + box.h2 + SLACK
    middle += TWO_PI * math.ceil((low - half - middle) / TWO_PI)
    least = middle - abs(box.slope1 - 1.0) * box.h1 - abs(box.slope2 - 1.0) * box.h2
    return least - rounding(box, 1.0)
