"""A proven lower bound of a leg's length over an interval of headings at each of its ends.

Everything is in units of the turning radius. For a costate nu any path of a leg is as long as

    nu . P + integral of (1 - nu . e(theta)) ds,    P the way from its start to its end,

so that along a word of turns and a straight the integral is a function of the first heading, one of
the last, and a remainder that is of second order about the word of which nu is the costate. Hence a
bound of each word over the box is a constant and two minima over one heading each, taken in closed
form, less a bound of the remainder (docs/derivation.md, section 16).

Rounding. Bounds are computed in doubles and lowered by `_rounding`; ranges of angles that decide
which paths count are widened by `_SLACK`, and distances by `_SLACK` of their scale. More paths than
there are only lower a bound.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.leg_words import between, straight_direction, turns

WordArray = NDArray[np.int8]

_PI, _TWO_PI = math.pi, 2 * math.pi
_SLACK = 1e-13
# The costate of RLR and LRL is 1 / |cos psi| long; longer ones than this are not needed.
_LONGEST_COSTATE = 20.0
_SHORTEST_STRAIGHT = 0.05  # below it the direction of S is not bounded by its derivative
NO_WORD = -1


@separate
def _arc_minimum(
    middle: float,
    half: float,
    low: float,
    high: float,
    rho: float,
    kappa: float,
    floor: float,
    mu: float,
) -> tuple[float, float]:
    """Least x + rho sin x - kappa (x - m) - mu x over |x - m| <= half, x in [low, high]; its x - m.

    m is `middle` or differs from it by a whole turn. Infinite where there is no such x. Below
    `floor` the first two terms are what they are there.
    """
    middle -= _TWO_PI * math.floor(middle / _TWO_PI + 0.5)
    cosine = (kappa + mu - 1.0) / rho
    still = -math.acos(cosine) if abs(cosine) <= 1.0 else math.nan
    best, place = math.inf, 0.0
    for turn in range(-1, 2):
        m = middle + turn * _TWO_PI
        first, last = max(m - half, low), min(m + half, high)
        if first > last:
            continue
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
                best, place = value, x - m
    return best, place


@separate
def _straight_bound(
    x: float,
    y: float,
    s1: float,
    s2: float,
    direction: float,
    least: float,
    most: float,
    straight: float,
    c1: float,
    h1: float,
    slope1: float,
    c2: float,
    h2: float,
    slope2: float,
) -> tuple[float, float, float]:
    """A bound of a word with a straight, whose costate points along `direction`.

    Args:
        least, most: bounds of s1 times (the straight's direction less `direction`).
        straight: a lower bound of the straight's length.

    Returns the bound and both headings, less the middles c1 and c2, where it is attained.
    """
    if s1 == s2:
        low2, high2, error = -_PI + least, _PI + most, 0.0
    else:
        low2, high2 = -_PI - most, _PI - least
        w = max(0.0, -least)
        error = max(0.0, 2.0 * (w - math.sin(w)) - straight * (1.0 - math.cos(w)))
    # an arc that would be driven backwards for a bit makes up for it in the straight
    turned = max(most, -least)
    floor = -_PI if s1 != s2 or (straight >= 0.4 * turned and turned <= 1.0) else -math.inf
    f1, x1 = _arc_minimum(
        s1 * (direction - c1) - _PI, h1, -_PI - most, _PI - least, 1.0, s1 * slope1, floor, 0.0
    )
    f2, x2 = _arc_minimum(
        s2 * (c2 - direction) - _PI, h2, low2, high2, 1.0, s2 * slope2, floor, 0.0
    )
    along = x * math.cos(direction) + y * math.sin(direction)
    return along + _TWO_PI + f1 + f2 - error, -s1 * x1, s2 * x2


@separate
def _rounding(x: float, y: float, rho: float, slope1: float, slope2: float) -> float:
    """More than the rounding of a bound (docs/derivation.md, section 16)."""
    size = 8.0 * rho * (abs(x) + abs(y)) + 100.0 * (2.0 + 2.0 * rho + abs(slope1) + abs(slope2))
    return EPS * size


@separate
def _edge_bound(
    x: float,
    y: float,
    s: float,
    direction: float,
    tau: float,
    along: float,
    reach: float,
    least: float,
    c1: float,
    h1: float,
    slope1: float,
    c2: float,
    h2: float,
    slope2: float,
) -> float:
    """A bound of LSR (s = 1) or RSL for boxes in which the straight may vanish.

    The costate is e + s tau n, with e along `direction` and n to its left: tau >= 0 is the
    multiplier of the condition that the circles are not nearer than 2.

    Args:
        along, reach: middle and range of the way between the centres along `direction`.
        least: a lower bound of z, s times (the straight's direction less `direction`).
    """
    most = math.asin(min(1.0, 0.5 * max(along + reach, 0.0))) + _SLACK
    widest = max(-least, most)
    extent = abs(along) + reach
    if widest > 1.2 or extent >= 2.0 or least > most:
        return -math.inf
    error = 2.0 * (math.tan(most) - most)
    error += max(0.0, reach - along) * (1.0 / math.cos(widest) - 1.0)
    error += 2.0 * tau * (1.0 - math.sqrt(1.0 - 0.25 * extent * extent))
    rho, phase = math.sqrt(1.0 + tau * tau), math.atan(tau)
    low, high = phase - _PI - most, phase + _PI - least
    f1, _ = _arc_minimum(
        s * (direction - c1) + phase - _PI, h1, low, high, rho, s * slope1, -math.inf, 0.0
    )
    f2, _ = _arc_minimum(
        s * (direction - c2) + phase - _PI, h2, low, high, rho, -s * slope2, -math.inf, 0.0
    )
    cosine, sine = math.cos(direction), math.sin(direction)
    pulled = x * (cosine - s * tau * sine) + y * (sine + s * tau * cosine)
    bound = pulled + 2.0 * tau + 2.0 * (_PI - phase) + f1 + f2 - error
    return bound - _rounding(x, y, rho, slope1, slope2)


@separate
def _turning_minimum(
    s: float, c1: float, h1: float, slope1: float, c2: float, h2: float, slope2: float, low: float
) -> float:
    """Least T + slope1 t1 - slope2 t2 over a box, T = s (theta2 - theta1) + 2 pi k not below `low`.

    The turning of a word's first and last arc less its middle arc's is such a T.
    """
    middle, half = s * (c2 - c1), h1 + h2 + _SLACK
    middle += _TWO_PI * math.ceil((low - half - middle) / _TWO_PI)
    return middle - abs(slope1 - s) * h1 - abs(slope2 - s) * h2


@separate
def _circle_bound(
    x: float,
    y: float,
    s: float,
    direction: float,
    c1: float,
    h1: float,
    slope1: float,
    c2: float,
    h2: float,
    slope2: float,
) -> float:
    """A bound of LSL (s = 1) or RSR for any direction of the costate.

    It does not matter which way S goes, which is open where both circles nearly coincide: a whole
    turn more of one arc and less of the other leaves the sum of x + sin x as it is.
    """
    first = s * (direction - c1)
    total = s * (c2 - c1)
    total += _TWO_PI * math.ceil((-_SLACK - h1 - h2 - total) / _TWO_PI)
    turns1 = math.floor(first / _TWO_PI)
    first -= _TWO_PI * turns1
    last = s * (c2 - direction)
    turns2 = math.floor(last / _TWO_PI)
    last -= _TWO_PI * turns2
    whole = math.floor((total - first - last) / _TWO_PI + 0.5)
    m1, m2 = first - _PI, last - _PI
    f1, _ = _arc_minimum(m1, h1, m1 - h1, m1 + h1, 1.0, s * slope1, -math.inf, 0.0)
    f2, _ = _arc_minimum(m2, h2, m2 - h2, m2 + h2, 1.0, s * slope2, -math.inf, 0.0)
    along = x * math.cos(direction) + y * math.sin(direction)
    return along + _TWO_PI * (1.0 + whole) + f1 + f2


@separate
def _csc_bound(
    x: float,
    y: float,
    s1: float,
    s2: float,
    c1: float,
    h1: float,
    slope1: float,
    c2: float,
    h2: float,
    slope2: float,
    enough: float,
) -> float:
    """A bound of a word with a straight over a box; one above `enough` is not made better."""
    dx, dy = between(x, y, s1, s2, c1, c2)
    m = math.hypot(dx, dy)
    reach = h1 + h2 + _SLACK * (1.0 + m)
    m_low, m_high = max(0.0, m - reach), m + reach
    turned = math.asin(reach / m) if reach < m else _PI
    direction = straight_direction(dx, dy, s1, s2)
    below, above, straight = turned, turned, m_low
    if s1 != s2:
        if m_high < 2.0:
            return math.inf
        straight = math.sqrt(max(m_low * m_low - 4.0, 0.0))
        farthest = math.sqrt(max(m_high * m_high - 4.0, 0.0))
        middle = math.atan2(2.0, math.sqrt(max(m * m - 4.0, 0.0)))
        below += middle - math.atan2(2.0, farthest)
        above += math.atan2(2.0, straight) - middle
        if straight > _SHORTEST_STRAIGHT:
            below, above = min(below, reach / straight), min(above, reach / straight)
    below, above = below + _SLACK, above + _SLACK
    best, t1, t2 = _straight_bound(
        *(x, y, s1, s2, direction, -below, above, straight),
        *(c1, h1, slope1, c2, h2, slope2),
    )
    moved = 0.0
    if s1 == s2:
        turning = _turning_minimum(s1, c1, h1, slope1, c2, h2, slope2, -_SLACK)
        best = max(best, m_low + turning)
        if turned > 0.5:
            for end in range(3):
                along = direction if end == 0 else c1 if end == 1 else c2
                value = _circle_bound(x, y, s1, along, c1, h1, slope1, c2, h2, slope2)
                best = max(best, value)
    elif m_low <= 2.0 + reach and turned < 1.0 and best < enough:
        # the direction that S would have if the circles touched; tau makes the bound flat in one
        # of the headings (docs/derivation.md)
        touching = math.atan2(dy, dx) + 0.5 * s1 * _PI
        cosine, sine = math.cos(touching), math.sin(touching)
        along = dx * cosine + dy * sine
        least = -turned - 0.5 * _PI + math.atan2(2.0, farthest) - _SLACK
        a, c = touching - c1, touching - c2
        for end in range(2):
            t = a if end == 0 else c
            kappa = s1 * slope1 if end == 0 else -s1 * slope2
            tau = (kappa - 1.0 + math.cos(t)) / (s1 * math.sin(t) + 1e-12)
            if 0.0 < tau < _LONGEST_COSTATE:
                value = _edge_bound(
                    *(x, y, s1, touching, tau, along, reach, least),
                    *(c1, h1, slope1, c2, h2, slope2),
                )
                best = max(best, value)
    for _ in range(4):
        if best >= enough or turned == _PI:
            break
        dx, dy = between(x, y, s1, s2, c1 + t1, c2 + t2)
        other = straight_direction(dx, dy, s1, s2)
        # Newton's step: headings inside their intervals turn with the direction
        square = dx * dx + dy * dy - (0.0 if s1 == s2 else 4.0)
        turning = math.sin(s1 * (other - c1 - t1)) if abs(t1) < h1 else 0.0
        turning += math.sin(s2 * (c2 + t2 - other)) if abs(t2) < h2 else 0.0
        shift = other - direction - moved
        shift -= _TWO_PI * math.floor(shift / _TWO_PI + 0.5)
        moved += shift / max(0.25, 1.0 + turning / math.sqrt(max(square, 1e-4)))
        shift = moved
        # whatever the direction is, the bound holds
        other = direction + shift
        value, t1, t2 = _straight_bound(
            *(x, y, s1, s2, other, -below - s1 * shift, above - s1 * shift, straight),
            *(c1, h1, slope1, c2, h2, slope2),
        )
        if value <= best + 1e-14 * abs(best):
            best = max(best, value)
            break
        best = value
    return best


@separate
def _vanishing_bound(
    x: float,
    y: float,
    s: float,
    end: float,
    axis: float,
    psi: float,
    psi_reach: float,
    turned: float,
    near: float,
    near_half: float,
    kappa_near: float,
    far: float,
    far_half: float,
    kappa_far: float,
) -> tuple[float, float]:
    """A bound of LRL (s = 1) or RLR where an arc may vanish, and the sum of its multipliers.

    The multiplier mu >= 0 is that of the condition that the arc at `near` is not negative; `end` is
    1 if this is the first arc, -1 if it is the last.

    Args:
        axis, turned: direction from the first arc's centre to the last one's; its range.
        psi, psi_reach: half the middle arc, at the middle of the box and its range.
        near, far: s (axis less heading), signed by `end`, at both ends; with halves of intervals.
    """
    cosine, sine = -math.cos(psi), math.sin(psi)
    # both arcs, less psi, from (-pi, pi] about the vanishing one
    u = near - _TWO_PI * math.floor((near + psi) / _TWO_PI + 0.5)
    v = far - _TWO_PI * math.floor(far / _TWO_PI + 0.5)
    best, longest = -math.inf, 1.0
    for flat in range(2):
        if flat == 0:
            rise = 1.0 + math.cos(u) / cosine - kappa_near
            per_mu = 1.0 + 0.25 * (math.cos(u) / cosine + math.sin(u) / sine)
        else:
            rise = 1.0 + math.cos(v) / cosine - kappa_far
            per_mu = 0.25 * (math.cos(v) / cosine - math.sin(v) / sine)
        mu = rise / per_mu if per_mu != 0.0 else 0.0
        if not (0.0 < mu < 8.0):
            continue
        along, across = 0.25 * (4.0 - mu) / cosine, -0.25 * mu / sine
        rho, eta = math.hypot(along, across), math.atan2(across, along)
        rest = (4.0 - mu) * psi + 4.0 * sine * along - mu * eta
        rest -= 2.0 * rho * (psi_reach * psi_reach + turned * turned)
        edge = psi + psi_reach + turned
        f1, _ = _arc_minimum(
            near - eta, near_half, -edge - eta, edge - eta, rho, kappa_near, -math.inf, mu
        )
        f2, _ = _arc_minimum(
            far + eta, far_half, -edge + eta, edge + eta, rho, kappa_far, -math.inf, 0.0
        )
        direction = axis - s * end * eta
        pulled = rho * (x * math.cos(direction) + y * math.sin(direction))
        best, longest = max(best, rest - pulled + f1 + f2), max(longest, rho + mu)
    return best, longest


@separate
def _ccc_bound(
    x: float,
    y: float,
    s: float,
    c1: float,
    h1: float,
    slope1: float,
    c2: float,
    h2: float,
    slope2: float,
) -> tuple[float, float]:
    """A bound of LRL (s = 1) or RLR over a box, and the length of its costate."""
    dx, dy = between(x, y, s, s, c1, c2)
    m = math.hypot(dx, dy)
    reach = h1 + h2 + _SLACK * (1.0 + m)
    m_low, m_high = max(0.0, m - reach), m + reach
    if m_low >= 4.0:
        return math.inf, 1.0
    psi_low = _PI - math.asin(min(1.0, 0.25 * m_high)) - _SLACK
    psi_high = _PI - math.asin(0.25 * m_low) + _SLACK
    turned = math.asin(reach / m) + _SLACK if reach < m else _PI
    rho = min(_LONGEST_COSTATE, 1.0 / max(1e-3, -math.cos(0.5 * (psi_low + psi_high))))
    pull = 4.0 * rho * math.cos(turned)
    # concave in psi if the pull is positive; else both terms are least at the lower end
    rest = 4.0 * psi_low + pull * math.sin(psi_low)
    if pull > 0.0:
        rest = min(rest, 4.0 * psi_high + pull * math.sin(psi_high))
    axis = math.atan2(dy, dx)
    edge = psi_high + turned
    f1, _ = _arc_minimum(s * (axis - c1), h1, -edge, edge, rho, s * slope1, -math.inf, 0.0)
    f2, _ = _arc_minimum(s * (c2 - axis), h2, -edge, edge, rho, s * slope2, -math.inf, 0.0)
    turning = _turning_minimum(s, c1, h1, slope1, c2, h2, slope2, -2.0 * psi_high)
    value = rest - rho * (x * math.cos(axis) + y * math.sin(axis)) + f1 + f2
    value = max(value, 4.0 * psi_low + turning)
    if m_high < 3.99 and turned < 0.5:
        psi = _PI - math.asin(0.25 * m)
        psi_reach = max(psi_high - psi, psi - psi_low) + _SLACK
        near, far = s * (axis - c1), s * (c2 - axis)
        for end in range(2):
            arc = psi + (near if end == 0 else far)
            arc -= _TWO_PI * math.floor(arc / _TWO_PI + 0.5)
            if abs(arc) > 2.0 * (reach + turned):
                continue
            if end == 0:
                other, longer = _vanishing_bound(
                    *(x, y, s, 1.0, axis, psi, psi_reach, turned),
                    *(near, h1, s * slope1, far, h2, s * slope2),
                )
            else:
                other, longer = _vanishing_bound(
                    *(x, y, s, -1.0, axis, psi, psi_reach, turned),
                    *(far, h2, s * slope2, near, h1, s * slope1),
                )
            value, rho = max(value, other), max(rho, longer)
    return value, rho


@separate
def box_bound(
    x: float,
    y: float,
    c1: float,
    h1: float,
    slope1: float,
    c2: float,
    h2: float,
    slope2: float,
) -> tuple[float, int]:
    """A lower bound of the length plus `slope1` t1 less `slope2` t2, and the word that gives it.

    Args:
        x, y: the end of the leg, seen from its start (radii).
        c1, h1: middle and half the width of the interval of first headings (rad); t1 is the first
            heading less c1.
        c2, h2: those of the last heading, less c2.
    """
    best, word = math.inf, NO_WORD
    for index in range(4):
        s1, s2 = turns(index)
        value = _csc_bound(x, y, s1, s2, c1, h1, slope1, c2, h2, slope2, best)
        if value < best:
            best, word = value, index
    rho = 1.0
    if x * x + y * y < 16.0 + _SLACK:
        for index in range(4, 6):
            s, _ = turns(index)
            value, longer = _ccc_bound(x, y, s, c1, h1, slope1, c2, h2, slope2)
            rho = max(rho, longer)
            if value < best:
                best, word = value, index
    return best - _rounding(x, y, rho, slope1, slope2), word


@compiled
def bound_leg(
    leg: FloatArray,
    first: tuple[FloatArray, FloatArray, FloatArray],
    last: tuple[FloatArray, FloatArray, FloatArray],
    live: BoolArray,
    bounds: FloatArray,
    words: WordArray,
) -> None:
    """`box_bound` of every live pair of intervals; infinite for the others.

    Args:
        leg: (x, y), the end seen from the start (radii).
        first, last: middles, halves of widths and slopes of the intervals at both ends.
        live, bounds, words: shape (intervals at the start, intervals at the end); two are written.
    """
    c1, h1, slope1 = first
    c2, h2, slope2 = last
    for i in range(c1.size):
        for j in range(c2.size):
            bounds[i, j], words[i, j] = math.inf, NO_WORD
            if live[i, j]:
                bounds[i, j], words[i, j] = box_bound(
                    *(leg[0], leg[1], c1[i], h1[i], slope1[i], c2[j], h2[j], slope2[j])
                )


@separate
def _word_slopes(x: float, y: float, t1: float, t2: float, word: int) -> tuple[float, float]:
    """Derivatives of a word's length by both headings, where it exists or nearly does."""
    s1, s2 = turns(word)
    dx, dy = between(x, y, s1, s2, t1, t2)
    if word < 4:
        direction = straight_direction(dx, dy, s1, s2)
        return -s1 * (1.0 - math.cos(direction - t1)), s2 * (1.0 - math.cos(t2 - direction))
    axis = math.atan2(dy, dx)
    quarter = 0.0625 * (dx * dx + dy * dy)
    rho = 1.0 / math.sqrt(max(1.0 / _LONGEST_COSTATE**2, 1.0 - quarter))
    return -s1 * (1.0 + rho * math.cos(t1 - axis)), s1 * (1.0 + rho * math.cos(t2 - axis))


UNKNOWN, BY_EDGE, BY_WORD = range(3)  # what a slope at one end of a leg is derived from


@separate
def _slope_across(
    x: float, y: float, t1: float, t2: float, reach: float, word: int, slope: float, forward: bool
) -> tuple[float, int]:
    """The slope of the potential for which a leg is flat at its other end, and what says so.

    A word that may change in the box takes any slope at one end, the multiplier of its condition
    adapting to it, and says the other end's; else both slopes are the word's derivatives.
    """
    s1, s2 = turns(word)
    dx, dy = between(x, y, s1, s2, t1, t2)
    m = math.hypot(dx, dy)
    turn = 0.0
    if word == 2 or word == 3:
        turn = s1 if m < 2.0 + 2.0 * reach else 0.0
    elif word >= 4 and m < 4.0:
        psi, axis = _PI - math.asin(0.25 * m), math.atan2(dy, dx)
        a, c = psi + s1 * (axis - t1), psi + s1 * (t2 - axis)
        a -= _TWO_PI * math.floor(a / _TWO_PI + 0.5)
        c -= _TWO_PI * math.floor(c / _TWO_PI + 0.5)
        turn = -s1 if abs(a) < 2.0 * reach else s1 if abs(c) < 2.0 * reach else 0.0
    d1, d2 = _word_slopes(x, y, t1, t2, word)
    if turn != 0.0:
        dx, dy = between(x, y, turn, -turn, t1, t2)
        switch = math.atan2(dy, dx) + 0.5 * turn * _PI
        near, far = (t1, t2) if forward else (t2, t1)
        near, far = turn * (switch - near), turn * (switch - far)
        if math.isnan(slope) or abs(math.sin(near)) < 1e-3:
            return math.nan, UNKNOWN
        kappa = turn * slope if forward else -turn * slope
        tau = (kappa - 1.0 + math.cos(near)) / math.sin(near)
        if tau > 0.0:
            other = 1.0 - math.cos(far) + tau * math.sin(far)
            return (-turn * other if forward else turn * other), BY_EDGE
    return (d2 if forward else -d1), BY_WORD


@compiled
def slopes_across(
    leg: FloatArray,
    headings1: FloatArray,
    headings2: FloatArray,
    reach: FloatArray,
    words: WordArray,
    slopes: FloatArray,
    forward: bool,
) -> tuple[FloatArray, WordArray]:
    """`_slope_across` of some boxes: of their last ends if `forward`, else of their first."""
    across, kinds = np.empty(words.size), np.empty(words.size, np.int8)
    for j in range(words.size):
        across[j], kinds[j] = _slope_across(
            *(leg[0], leg[1], headings1[j], headings2[j], reach[j], words[j], slopes[j], forward)
        )
    return across, kinds


@compiled
def bounds_of_halves(
    leg: FloatArray,
    first: tuple[FloatArray, FloatArray, FloatArray],
    last: tuple[FloatArray, FloatArray, FloatArray],
    forward: bool,
) -> FloatArray:
    """Bounds of boxes with the lower and the upper half of one of their intervals, shape (2, n).

    Of the first interval if `forward`, else of the last.
    """
    c1, h1, slope1 = first
    c2, h2, slope2 = last
    bounds = np.empty((2, c1.size))
    for half in range(2):
        side = half - 0.5
        for j in range(c1.size):
            d1 = side * h1[j] if forward else 0.0
            d2 = 0.0 if forward else side * h2[j]
            bound, _ = box_bound(
                *(leg[0], leg[1], c1[j] + d1, h1[j] - abs(d1), slope1[j]),
                *(c2[j] + d2, h2[j] - abs(d2), slope2[j]),
            )
            bounds[half, j] = bound + slope1[j] * d1 - slope2[j] * d2
    return bounds
