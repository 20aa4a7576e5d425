"""Proven lower bounds of one word's length over an interval of headings at each end of a leg.

Everything is in units of the turning radius. For a costate nu any path of a leg is as long as

    nu . P + integral of (1 - nu . e(theta)) ds,    P the way from its start to its end.

Along a word of turns and a straight the integral is a function of the first heading, one of the
last, and a rest. Less mu times each segment that is near its end, mu >= 0, it is no longer than the
path; nu and mu are chosen so that the rest is of second order and that neither heading is worth a
change. Hence a bound of each word over the box is a constant and two minima over one heading each,
taken in closed form, less a bound of the rest (docs/derivation.md, section 16).

The words here begin with a turn to the left; others are their mirror images. Ranges that decide
which paths count are widened by `_SLACK`: more paths than there are only lower a bound.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.kernel_compile import separate
from dubins_study.study.route.leg_words import between, principal, straight_direction

_PI, _TWO_PI = math.pi, 2 * math.pi
_SLACK = 1e-13
LONGEST_COSTATE = 20.0  # that of LRL is 1 / |cos psi| long; longer ones than this are not needed
_ALONG = 1.0  # of a costate along the axis of LRL, where a flat one would be long
_SHORTEST_STRAIGHT = 0.05  # below it the direction of S is not bounded by its derivative


class Box(NamedTuple):
    """A leg and an interval of headings at each of its ends, with the slope of the potential there.

    The leg ends at (x, y), seen from its start. The intervals have middles c and half widths h
    (rad); what is bounded is the length plus slope1 (theta1 - c1) less slope2 (theta2 - c2).
    """

    x: float
    y: float
    c1: float
    h1: float
    slope1: float
    c2: float
    h2: float
    slope2: float


class _Costate(NamedTuple):
    """A costate, by length and direction, and the multipliers of the first and the last arc."""

    length: float
    direction: float
    mu1: float
    mu2: float


class _Circles(NamedTuple):
    """The way from the first arc's centre to the last one's: at the box's middle, and its range."""

    dx: float
    dy: float
    distance: float
    nearest: float
    farthest: float
    along: float  # how far it may change along itself, and across
    across: float
    turned: float  # rad to either side


@separate
def mirrored(box: Box) -> Box:
    """The box whose paths are the mirror images of this one's."""
    return Box(box.x, -box.y, -box.c1, box.h1, -box.slope1, -box.c2, box.h2, -box.slope2)


@separate
def _circles(box: Box, last: float) -> _Circles:
    dx, dy = between(box.x, box.y, 1.0, last, box.c1, box.c2)
    m = math.hypot(dx, dy)
    # a centre moves along its heading, and to second order across it
    reach, bent = box.h1 + box.h2, 0.5 * (box.h1 * box.h1 + box.h2 * box.h2)
    axis, slack = math.atan2(dy, dx), _SLACK * (1.0 + m)
    along = abs(math.cos(axis - box.c1)) * box.h1 + abs(math.cos(axis - box.c2)) * box.h2
    across = abs(math.sin(axis - box.c1)) * box.h1 + abs(math.sin(axis - box.c2)) * box.h2
    along, across = min(along + bent, reach) + slack, min(across + bent, reach) + slack
    nearest, turned = max(0.0, m - along), _PI
    if nearest > 0.0:
        turned = math.atan2(across, nearest) + _SLACK
    farthest = min(math.hypot(m + along, across), m + reach + slack)
    return _Circles(dx, dy, m, nearest, farthest, along, across, turned)


@separate
def _least_between(
    m: float, first: float, last: float, rho: float, kappa: float, mu: float, floor: float
) -> tuple[float, float]:
    """Least x + rho sin x - kappa (x - m) - mu x over [first, last], and its x - m.

    Below `floor` the first two terms are what they are there.
    """
    best, place = math.inf, first
    cosine = (kappa + mu - 1.0) / rho
    still = math.nan
    if abs(cosine) <= 1.0:
        still = -math.acos(cosine)
        still += _TWO_PI * math.ceil((first - still) / _TWO_PI)
    for candidate in range(5):
        x = first
        if candidate == 1:
            x = last
        elif candidate > 1:
            x = floor if candidate == 4 else still if candidate == 2 else still + _TWO_PI
            if not (first < x < last):
                continue
        lifted = max(x, floor)
        value = lifted + rho * math.sin(lifted) - kappa * (x - m) - mu * x
        if value < best:
            best, place = value, x
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
    """`_least_between` over all x in `within` that are within `half` of m, infinite for none.

    m is `middle` or differs from it by whole turns.
    """
    low, high = within
    best, place = math.inf, 0.0
    m = middle + _TWO_PI * math.ceil((low - half - middle) / _TWO_PI)
    while m - half <= high:
        value, x = _least_between(m, max(m - half, low), min(m + half, high), rho, kappa, mu, floor)
        if value < best:
            best, place = value, x
        m += _TWO_PI
    return best, place


@separate
def _separated(
    box: Box,
    last: float,
    nu: _Costate,
    within1: tuple[float, float],
    within2: tuple[float, float],
    floor: float,
) -> tuple[float, float, float]:
    """A bound but for the rest, and the headings, less the middles, where it is attained.

    The angles x = phi - theta1 - pi of the first arc and last (theta2 - phi) - pi of the last one,
    phi the costate's direction, count in the ranges that are given.
    """
    rho, phi = nu.length, nu.direction
    f1, x1 = _least(phi - _PI - box.c1, box.h1, within1, rho, box.slope1, nu.mu1, floor)
    f2, x2 = _least(
        last * (box.c2 - phi) - _PI, box.h2, within2, rho, last * box.slope2, nu.mu2, floor
    )
    pulled = rho * (box.x * math.cos(phi) + box.y * math.sin(phi))
    return pulled + f1 + f2 - _rounding(box, rho + nu.mu1 + nu.mu2), -x1, last * x2


@separate
def _rounding(box: Box, size: float) -> float:
    """More than the rounding of a bound whose costate and multipliers have this size in all."""
    return EPS * (
        8.0 * size * (abs(box.x) + abs(box.y))
        + 100.0 * (2.0 + 2.0 * size + abs(box.slope1) + abs(box.slope2))
    )


@separate
def _turning_bound(box: Box, low: float) -> float:
    """Least T + slope1 t1 - slope2 t2, T = theta2 - theta1 and whole turns, not below `low`.

    The turning of the first and last arc of LSL is such a T, and so is that of LRL less its middle
    arc's.
    """
    middle, half = box.c2 - box.c1, box.h1 + box.h2 + _SLACK
    middle += _TWO_PI * math.ceil((low - half - middle) / _TWO_PI)
    least = middle - abs(box.slope1 - 1.0) * box.h1 - abs(box.slope2 - 1.0) * box.h2
    return least - _rounding(box, 1.0)


@separate
def _apex_bound(box: Box, circles: _Circles) -> float:
    """A bound of LSL where S may vanish and its direction phi is open.

    The rest is S (1 - nu . e(phi)), with phi between both headings unless an arc has a turn more.
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
    first = box.c1 - box.h1 - _SLACK
    total = box.c2 + box.h2 + _SLACK - first
    whole = -math.floor(total / _TWO_PI)
    total += _TWO_PI * whole
    # the angle from the first heading to nu, and the nearest that S comes to nu
    after = nu - first - _TWO_PI * math.floor((nu - first) / _TWO_PI)
    away = 0.0 if after <= total else min(after - total, _TWO_PI - after)
    # S sin a and S sin c: what is left of S's direction of each heading
    farthest = circles.farthest
    sine = abs(math.sin(box.c2 - box.c1))
    bent = 0.5 * (1.0 + farthest) * (box.h1 + box.h2) ** 2 + _SLACK
    along1 = abs(circles.dx * math.cos(box.c1) + circles.dy * math.sin(box.c1))
    along2 = abs(circles.dx * math.cos(box.c2) + circles.dy * math.sin(box.c2))
    left1 = circles.dy * math.cos(box.c1) - circles.dx * math.sin(box.c1)
    left2 = circles.dx * math.sin(box.c2) - circles.dy * math.cos(box.c2)
    out1 = left1 + along1 * box.h1 + sine * box.h2 + bent < 0.0
    out2 = left2 + along2 * box.h2 + sine * box.h1 + bent < 0.0
    none = (out1 and out2) or (total < _PI and (out1 or out2))
    best = -math.inf
    for clipped in range(2 if length > 1.0 else 1):
        rho = min(length, 1.0) if clipped else min(length, LONGEST_COSTATE)
        m1, m2 = nu - _PI - box.c1, box.c2 - nu - _PI
        f1, _ = _least_between(m1, m1 - box.h1, m1 + box.h1, rho, box.slope1, 0.0, -math.inf)
        f2, _ = _least_between(m2, m2 - box.h2, m2 + box.h2, rho, box.slope2, 0.0, -math.inf)
        pulled = rho * (box.x * math.cos(nu) + box.y * math.sin(nu))
        value = pulled + f1 + f2 + _TWO_PI * (1.0 + whole) - _rounding(box, rho)
        inside = -math.inf if none else farthest * max(0.0, rho * math.cos(away) - 1.0)
        outside = farthest * max(0.0, rho - 1.0) - _TWO_PI
        best = max(best, value - max(inside, outside))
    return best


@separate
def _straight_bound(
    box: Box, last: float, direction: float, least: float, most: float, straight: float
) -> tuple[float, float, float]:
    """A bound of LSL or LSR whose costate has length 1, and the headings where it is attained.

    Args:
        least, most: bounds of the straight's direction less `direction`.
        straight: a lower bound of the straight's length.
    """
    within1 = (-_PI - most, _PI - least)
    within2, error = within1, 0.0
    if last > 0.0:
        within2 = (-_PI + least, _PI + most)
    else:
        w = max(0.0, -least)
        error = max(0.0, 2.0 * (w - math.sin(w)) - straight * (1.0 - math.cos(w)))
    # an arc that would be driven backwards for a bit makes up for it in the straight
    turned = max(most, -least)
    floor = -_PI if last < 0.0 or (straight >= 0.4 * turned and turned <= 1.0) else -math.inf
    nu = _Costate(1.0, direction, 0.0, 0.0)
    value, t1, t2 = _separated(box, last, nu, within1, within2, floor)
    return value + _TWO_PI - error, t1, t2


@separate
def _touching_bound(
    box: Box, circles: _Circles, tau: float, mu: float, end: int, short: float
) -> float:
    """A bound of LSR in boxes in which the straight may vanish.

    Args:
        tau: multiplier of the condition that the circles are not nearer than 2; if it is negative,
            of the one that the line at the end of a short arc does not cut the other arc's circle.
        mu: multiplier of the short arc.
        end: 0 if the first arc is known to be short, 1 if the last one is, -1 for neither.
        short: bound of that arc less what the direction of S adds; if negative, arcs there above pi
            count instead of those below it.
    """
    # e points where S would if the circles touched; E is the way between the centres along it
    direction = math.atan2(circles.dy, circles.dx) + 0.5 * _PI
    cosine, sine = math.cos(direction), math.sin(direction)
    middle, reach = circles.dx * cosine + circles.dy * sine, circles.across
    # z, the straight's direction less that of e
    square = max(circles.farthest * circles.farthest - 4.0, 0.0)
    least = math.atan2(2.0, math.sqrt(square)) - 0.5 * _PI - circles.turned - _SLACK
    most = math.asin(min(1.0, 0.5 * max(middle + reach, 0.0))) + _SLACK
    widest, extent = max(-least, most), abs(middle) + reach
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
    within = (low, high + _TWO_PI)
    part = within if end < 0 else (low, high + _PI) if short >= 0.0 else (low + _PI, high + _TWO_PI)
    length, phi = math.hypot(tau, along), direction + phase
    if end == 0:
        nu, within1, within2 = _Costate(length, phi, mu, 0.0), part, within
    else:
        nu, within1, within2 = _Costate(length, phi, 0.0, mu), within, part
    value, _, _ = _separated(box, -1.0, nu, within1, within2, -math.inf)
    return value + 2.0 * along * (_PI - phase) + 2.0 * tau - error


@separate
def _edge_bound(box: Box, circles: _Circles) -> float:
    """A bound of LSR in boxes in which the straight may vanish, and one of the arcs with it."""
    direction = math.atan2(circles.dy, circles.dx) + 0.5 * _PI
    arcs = (direction - box.c1, direction - box.c2)
    slopes = (box.slope1, -box.slope2)
    halves = (box.h1, box.h2)
    best = -math.inf
    for first in range(2):
        # tau makes the bound flat in this heading, mu in that of the other arc if it may vanish
        a, c = arcs[first], arcs[1 - first]
        rise, rise2 = slopes[first] - 1.0 + math.cos(a), slopes[1 - first] - 1.0 + math.cos(c)
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
    box: Box, circles: _Circles, tau: float, mu: float, end: int, short: float
) -> float:
    """`_touching_bound` with multipliers for an arc that is short, if it is not nearly a turn."""
    return min(
        _touching_bound(box, circles, tau, mu, end, short),
        _touching_bound(box, circles, 0.0, 0.0, end, -1.0),
    )


@separate
def csc_bound(box: Box, last: float, enough: float) -> float:
    """A bound of LSL (`last` = 1) or LSR (-1); one above `enough` is not made better."""
    circles = _circles(box, last)
    reach = box.h1 + box.h2
    direction = straight_direction(circles.dx, circles.dy, 1.0, last)
    below = above = circles.turned
    straight = circles.nearest
    if last < 0.0:
        if circles.farthest < 2.0:
            return math.inf
        straight = math.sqrt(max(straight * straight - 4.0, 0.0))
        farthest = math.sqrt(circles.farthest * circles.farthest - 4.0)
        middle = math.atan2(2.0, math.sqrt(max(circles.distance * circles.distance - 4.0, 0.0)))
        below += middle - math.atan2(2.0, farthest) + _SLACK
        above += math.atan2(2.0, straight) - middle + _SLACK
        if straight > _SHORTEST_STRAIGHT:
            below = min(below, reach / straight + _SLACK)
            above = min(above, reach / straight + _SLACK)
    best, t1, t2 = _straight_bound(box, last, direction, -below, above, straight)
    if last > 0.0:
        best = max(best, circles.nearest + _turning_bound(box, -_SLACK))
        if circles.turned > 0.1 or circles.farthest < 0.1:
            best = max(best, _apex_bound(box, circles))
    elif circles.nearest <= 2.0 + circles.along and circles.turned < 1.0 and best < enough:
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


@separate
def _triangle_bound(
    box: Box,
    axis: float,
    psis: tuple[float, float],
    turned: float,
    rho: float,
    tilt: float,
    mu1: float,
    mu2: float,
) -> float:
    """A bound of LRL with a costate of length rho that points against the direction axis - tilt.

    Args:
        axis, turned: direction from the first arc's centre to the last one's; its range.
        psis: range of half the middle arc.
    """
    rest = math.inf
    for corner in range(4):
        # concave in psi, or least at its lower end; concave in eps, or cos(eps) alone
        psi = psis[corner % 2]
        eps = tilt - turned if corner < 2 else tilt + turned
        value = (4.0 - mu1 - mu2) * psi + 4.0 * rho * math.sin(psi) * math.cos(eps)
        rest = min(rest, value - (mu1 - mu2) * eps)
    if mu1 + mu2 > 0.0:
        # convex where cos(eps) < 0
        spread = 0.5 * (psis[1] - psis[0])
        steep = max(0.0, -math.cos(min(_PI, abs(tilt) + turned)))
        rest -= 2.0 * rho * steep * (turned * turned + spread * spread)
    edge = psis[1] + turned
    nu = _Costate(rho, axis - tilt + _PI, mu1, mu2)
    within1, within2 = (-edge - tilt, edge - tilt), (-edge + tilt, edge + tilt)
    value, _, _ = _separated(box, 1.0, nu, within1, within2, -math.inf)
    return value + rest


@separate
def lrl_bound(box: Box) -> float:
    """A bound of LRL, with multipliers of the outer arcs where these may vanish."""
    circles = _circles(box, 1.0)
    if circles.nearest >= 4.0:
        return math.inf
    psis = (
        _PI - math.asin(min(1.0, 0.25 * circles.farthest)) - _SLACK,
        _PI - math.asin(0.25 * circles.nearest) + _SLACK,
    )
    axis, turned = math.atan2(circles.dy, circles.dx), circles.turned
    rho = min(LONGEST_COSTATE, 1.0 / max(1e-3, -math.cos(0.5 * (psis[0] + psis[1]))))
    best = _triangle_bound(box, axis, psis, turned, rho, 0.0, 0.0, 0.0)
    best = max(best, 4.0 * psis[0] + _turning_bound(box, -2.0 * psis[1]))
    if turned > 0.5:
        return best
    psi = 0.5 * (psis[0] + psis[1])
    u, v = axis - box.c1, box.c2 - axis
    near = 2.0 * (box.h1 + box.h2 + turned)
    short1, short2 = abs(principal(psi + u)) < near, abs(principal(psi + v)) < near
    # flat in the first heading if rate11 mu1 + rate12 mu2 = rise1, in the last likewise
    c, s = -4.0 * math.cos(psi), 4.0 * math.sin(psi)
    rise1 = box.slope1 - 1.0 - 4.0 * math.cos(u) / c
    rise2 = box.slope2 - 1.0 - 4.0 * math.cos(v) / c
    rate11, rate12 = -1.0 - math.cos(u) / c - math.sin(u) / s, math.sin(u) / s - math.cos(u) / c
    rate22, rate21 = -1.0 - math.cos(v) / c - math.sin(v) / s, math.sin(v) / s - math.cos(v) / c
    size = rate11 * rate22 - rate12 * rate21
    for flat in range(7):
        mu1 = mu2 = 0.0
        if flat == 4 and short1 and short2:
            mu1 = (rise1 * rate22 - rise2 * rate12) / size
            mu2 = (rise2 * rate11 - rise1 * rate21) / size
        elif flat < 2 and short1:
            mu1 = rise1 / rate11 if flat == 0 else rise2 / rate21
        elif 2 <= flat < 4 and short2:
            mu2 = rise1 / rate12 if flat == 2 else rise2 / rate22
        elif flat == 5 and short1:
            mu1 = 4.0 - _ALONG * c
        elif flat == 6 and short2:
            mu2 = 4.0 - _ALONG * c
        mu1, mu2 = min(mu1, 8.0), min(mu2, 8.0)
        if not (mu1 >= 0.0 and mu2 >= 0.0 and mu1 + mu2 > 0.0):
            continue
        # the rest is stationary at the middle of the box
        along, across = (4.0 - mu1 - mu2) / c, (mu2 - mu1) / s
        rho, tilt = math.hypot(along, across), math.atan2(across, along)
        if rho <= LONGEST_COSTATE:
            value = _triangle_bound(box, axis, psis, turned, rho, tilt, mu1, mu2)
            best = max(best, value)
    return best
