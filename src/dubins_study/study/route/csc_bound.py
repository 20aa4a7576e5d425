"""Lower bounds of LSL and LSR over a box.

They hold on edges too, where a straight or an arc vanishes. The identities are equations 18, 18a,
20 and 20a of docs/derivation.md.
"""

from __future__ import annotations

import math

from dubins_study.study.angle import TWO_PI
from dubins_study.study.closed_form.kernel_compile import separate
from dubins_study.study.route.box import (
    END_HALF,
    END_LEFT,
    END_RIGHT,
    LONGEST_COSTATE,
    SLACK,
    START_HALF,
    START_LEFT,
    START_RIGHT,
    Box,
    Circles,
    Costate,
    circles_of,
    separated,
    turning_bound,
)
from dubins_study.study.route.leg_words import between, principal, straight_direction

_PI = math.pi
_SHORTEST_STRAIGHT = 0.05  # radii; for a shorter S the derivative does not bound its direction


@separate
def _last_centre(circles: Circles, heading: float) -> tuple[float, float]:
    """Position of the last centre from the first.

    Distances ahead and to the left, seen along a heading.
    """
    cosine, sine = math.cos(heading), math.sin(heading)
    ahead = circles.dx * cosine + circles.dy * sine
    return ahead, circles.dy * cosine - circles.dx * sine


@separate
def _apex_bound(box: Box, circles: Circles) -> float:
    """Bound of LSL where S may vanish.

    The direction phi of S is open. The rest is S (1 - nu . e(phi)), with phi between both headings
    unless an arc has a turn more.
    """
    # nu . e(theta1) = 1 - slope1 and nu . e(theta2) = 1 - slope2 make the bound flat
    flat1, flat2 = 1.0 - box.slope1, 1.0 - box.slope2
    sine = math.sin(box.c2 - box.c1)
    if box.h1 == 0.0 or abs(sine) < 1e-3:
        along, across = flat2 * math.cos(box.c2), flat2 * math.sin(box.c2)
    elif box.h2 == 0.0:
        along, across = flat1 * math.cos(box.c1), flat1 * math.sin(box.c1)
    else:
        along = (flat1 * math.sin(box.c2) - flat2 * math.sin(box.c1)) / sine
        across = (flat2 * math.cos(box.c1) - flat1 * math.cos(box.c2)) / sine
    length, nu = math.hypot(along, across), math.atan2(across, along)
    first = box.c1 - box.h1 - SLACK
    total = box.c2 + box.h2 + SLACK - first
    whole = -math.floor(total / TWO_PI)
    total += TWO_PI * whole
    # S sin a and S sin c: the part of S to the left of each heading's direction
    farthest = circles.farthest
    sine = abs(math.sin(box.c2 - box.c1))
    bent = 0.5 * (1.0 + farthest) * (box.h1 + box.h2) ** 2 + SLACK
    along1, left1 = _last_centre(circles, box.c1)
    along2, left2 = _last_centre(circles, box.c2)
    # an arc above pi takes half a turn from the range of S's direction
    long1, long2 = _long_arcs(box, 1.0)
    if long1 or left1 + abs(along1) * box.h1 + sine * box.h2 + bent < 0.0:
        first += _PI
        total -= _PI
    if long2 or -left2 + abs(along2) * box.h2 + sine * box.h1 + bent < 0.0:
        total -= _PI
    # angle from the first such direction to nu, and least angle between S and nu
    after = nu - first - TWO_PI * math.floor((nu - first) / TWO_PI)
    away = 0.0 if after <= total else min(after - total, TWO_PI - after)
    # both arcs may have any angle in the box
    m1, m2 = nu - _PI - box.c1, box.c2 - nu - _PI
    within1 = (m1 - box.h1, m1 + box.h1)
    within2 = (m2 - box.h2, m2 + box.h2)
    best = -math.inf
    # 0: nu as it is, 1: nu shortened to length 1
    for clipped in range(2 if length > 1.0 else 1):
        rho = min(length, 1.0) if clipped else min(length, LONGEST_COSTATE)
        value, _, _ = separated(box, 1.0, Costate(rho, nu, 0.0, 0.0), within1, within2, -math.inf)
        value += TWO_PI * (1.0 + whole)
        inside = -math.inf if total < 0.0 else farthest * max(0.0, rho * math.cos(away) - 1.0)
        outside = farthest * max(0.0, rho - 1.0) - TWO_PI
        best = max(best, value - max(inside, outside))
    return best


@separate
def _long_arcs(box: Box, last: float) -> tuple[bool, bool]:
    """Whether the outer arcs are known above pi.

    Two flags, for the first and the last arc of LSL (`last` = 1) or LSR (-1).
    """
    if last > 0.0:
        return box.apart & END_LEFT > 0, box.apart & START_LEFT > 0
    half1 = box.apart & START_RIGHT > 0 and box.apart & START_HALF > 0
    return half1, box.apart & END_LEFT > 0 and box.apart & END_HALF > 0


@separate
def _straight_bound(
    box: Box, last: float, direction: float, least: float, most: float, straight: float
) -> tuple[float, float, float]:
    """Bound of LSL (`last` = 1) or LSR (-1).

    The costate has length 1.

    The headings where it is attained are returned too, less the middles of their intervals.

    Args:
        least, most: bounds of the straight's direction less `direction`.
        straight: a lower bound of the straight's length.
    """
    long1, long2 = _long_arcs(box, last)
    within1 = ((0.0 if long1 else -_PI) - most, _PI - least)
    within2 = ((0.0 if long2 else -_PI) - most, _PI - least)
    error = 0.0
    if last > 0.0:
        within2 = ((0.0 if long2 else -_PI) + least, _PI + most)
    else:
        w = max(0.0, -least)
        error = max(0.0, 2.0 * (w - math.sin(w)) - straight * (1.0 - math.cos(w)))
    # the straight makes up for an arc that would be driven backwards for a bit
    turned = max(most, -least)
    floor = -_PI if last < 0.0 or (straight >= 0.4 * turned and turned <= 1.0) else -math.inf
    nu = Costate(1.0, direction, 0.0, 0.0)
    value, t1, t2 = separated(box, last, nu, within1, within2, floor)
    return value + TWO_PI - error, t1, t2


@separate
def _touching_bound(
    box: Box, circles: Circles, tau: float, mu: float, end: int, short: float
) -> float:
    """Bound of LSR where the straight may vanish.

    Args:
        tau: multiplier of the condition that the circles are not nearer than 2; if it is negative,
            of the one that the line at the end of a short arc does not cut the other arc's circle.
        mu: multiplier of the short arc.
        end: 0 if the first arc is known to be short, 1 if the last one is, -1 for neither.
        short: bound of that arc less the part that the direction of S adds; if negative, arcs there
            above pi count instead of those below it.
    """
    # e points where S would if the circles touched; E is the way between the centres along it
    direction = math.atan2(circles.dy, circles.dx) + 0.5 * _PI
    cosine, sine = math.cos(direction), math.sin(direction)
    middle = circles.dx * cosine + circles.dy * sine
    reach = circles.across
    # z, the straight's direction less that of e
    square = max(circles.farthest * circles.farthest - 4.0, 0.0)
    least = math.atan2(2.0, math.sqrt(square)) - 0.5 * _PI - circles.turned - SLACK
    most = math.asin(min(1.0, 0.5 * max(middle + reach, 0.0))) + SLACK
    widest = max(-least, most)
    extent = abs(middle) + reach
    if widest > 1.2 or extent >= 2.0:
        return -math.inf
    along = 1.0 - 0.5 * mu
    error = 2.0 * (math.tan(most) - most)
    error += max(0.0, reach - middle) * (1.0 / math.cos(widest) - 1.0)
    error *= abs(along)
    if tau >= 0.0:
        error += 2.0 * tau * (1.0 - math.sqrt(1.0 - 0.25 * extent * extent))
    else:
        sine, cosine = math.sin(short), math.cos(short)
        error -= tau * (1.0 - cosine + sine * (extent + sine)) / cosine
    phase = math.atan2(tau, along)
    low, high = phase - _PI - most, phase - _PI - least
    within = (low, high + TWO_PI)
    part = within if end < 0 else (low, high + _PI) if short >= 0.0 else (low + _PI, high + TWO_PI)
    length = math.hypot(tau, along)
    phi = direction + phase
    if end == 0:
        nu = Costate(length, phi, mu, 0.0)
        within1 = part
        within2 = within
    else:
        nu = Costate(length, phi, 0.0, mu)
        within1 = within
        within2 = part
    value, _, _ = separated(box, -1.0, nu, within1, within2, -math.inf)
    return value + 2.0 * along * (_PI - phase) + 2.0 * tau - error


@separate
def _edge_bound(box: Box, circles: Circles) -> float:
    """Bound of LSR where two segments may vanish.

    They are the straight and one of the arcs.
    """
    direction = math.atan2(circles.dy, circles.dx) + 0.5 * _PI
    arcs = (direction - box.c1, direction - box.c2)
    slopes = (box.slope1, -box.slope2)
    halves = (box.h1, box.h2)
    best = -math.inf
    for first in range(2):
        # tau makes the bound flat in this heading, mu in that of the other arc if it may vanish;
        # c, `rise2`, `sine2` and `half2` are of the other arc
        a, c = arcs[first], arcs[1 - first]
        rise = slopes[first] - 1.0 + math.cos(a)
        rise2 = slopes[1 - first] - 1.0 + math.cos(c)
        sine, sine2 = math.sin(a), math.sin(c)
        half, half2 = 0.5 * math.cos(a), 0.5 * math.cos(c) - 1.0
        tau = rise / sine
        if 0.0 <= tau < LONGEST_COSTATE:
            best = max(best, _touching_bound(box, circles, tau, 0.0, -1, 0.0))
        short = abs(principal(c)) + halves[1 - first]
        if short > 1.0:
            continue
        if -LONGEST_COSTATE < tau < 0.0:
            best = max(best, _short_bound(box, circles, tau, 0.0, 1 - first, short))
        size = half2 * sine - half * sine2
        mu = (rise2 * sine - rise * sine2) / size
        tau = (half2 * rise - half * rise2) / size
        if abs(tau) < LONGEST_COSTATE and 0.0 <= mu < LONGEST_COSTATE:
            best = max(best, _short_bound(box, circles, tau, mu, 1 - first, short))
    return best


@separate
def _short_bound(
    box: Box, circles: Circles, tau: float, mu: float, end: int, short: float
) -> float:
    """`_touching_bound` with multipliers for a short arc.

    The arc is short, or nearly a full turn; the bound holds for both.
    """
    return min(
        _touching_bound(box, circles, tau, mu, end, short),
        _touching_bound(box, circles, 0.0, 0.0, end, -1.0),
    )


@separate
def csc_bound(box: Box, last: float, enough: float) -> float:
    """Bound of LSL (`last` = 1) or LSR (-1).

    A bound above `enough` is not improved further.
    """
    if last < 0.0 and box.apart & (START_LEFT | END_RIGHT):
        return math.inf
    long1, long2 = _long_arcs(box, last)
    circles = circles_of(box, last)
    reach = box.h1 + box.h2
    direction = straight_direction(circles.dx, circles.dy, 1.0, last)
    below = above = circles.turned
    straight = circles.nearest
    if last < 0.0:
        if circles.farthest < 2.0:
            return math.inf
        straight = math.sqrt(max(straight * straight - 4.0, 0.0))
        farthest = math.sqrt(circles.farthest * circles.farthest - 4.0)
        # rounding moves both by 1e-8 where the circles touch: one computation has to give both
        middle = direction - math.atan2(circles.dy, circles.dx)
        below += middle - math.atan2(2.0, farthest) + SLACK
        above += math.atan2(2.0, straight) - middle + SLACK
        if straight > _SHORTEST_STRAIGHT:
            below = min(below, reach / straight + SLACK)
            above = min(above, reach / straight + SLACK)
    best, t1, t2 = _straight_bound(box, last, direction, -below, above, straight)
    if last > 0.0:
        least = (_PI if long1 else 0.0) + (_PI if long2 else 0.0)
        best = max(best, circles.nearest + turning_bound(box, least - SLACK))
        if circles.turned > 0.1 or circles.farthest < 0.1:
            best = max(best, _apex_bound(box, circles))
    elif (
        circles.nearest <= 2.0 + circles.along
        and circles.turned < 1.0
        and best < enough
        and not (long1 or long2)
    ):
        best = max(best, _edge_bound(box, circles))
    moved = 0.0
    for _ in range(4):
        if best >= enough or circles.turned == _PI:
            break
        dx, dy = between(box.x, box.y, 1.0, last, box.c1 + t1, box.c2 + t2)
        other = straight_direction(dx, dy, 1.0, last)
        # Newton's step: headings inside their intervals turn with the direction
        square = dx * dx + dy * dy - (0.0 if last > 0.0 else 4.0)
        turning = math.sin(other - box.c1 - t1) if abs(t1) < box.h1 else 0.0
        turning += math.sin(last * (box.c2 + t2 - other)) if abs(t2) < box.h2 else 0.0
        shift = principal(other - direction - moved)
        moved += shift / max(0.25, 1.0 + turning / math.sqrt(max(square, 1e-4)))
        # whatever the direction is, the bound holds
        value, t1, t2 = _straight_bound(
            box, last, direction + moved, -below - moved, above - moved, straight
        )
        if value <= best + 1e-14 * abs(best):
            break
        best = value
    return best
