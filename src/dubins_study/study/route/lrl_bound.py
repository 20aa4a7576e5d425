"""Lower bound of LRL over a box of headings.

It is equation 19 of docs/derivation.md.
"""

from __future__ import annotations

import math

from dubins_study.study.closed_form.kernel_compile import separate
from dubins_study.study.route.box import (
    END_HALF,
    END_RIGHT,
    LONGEST_COSTATE,
    SLACK,
    START_HALF,
    START_RIGHT,
    Box,
    Costate,
    circles_of,
    rounding,
    separated,
    turning_bound,
)
from dubins_study.study.route.leg_words import principal

_PI = math.pi
_ALONG = 1.0  # length of a costate along the axis of LRL, where a flat one would be too long


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
    """Bound of LRL by one costate.

    The costate has length rho and points against the direction axis - tilt.

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
    nu = Costate(rho, axis - tilt + _PI, mu1, mu2)
    within1 = (-edge - tilt, edge - tilt)
    within2 = (-edge + tilt, edge + tilt)
    value, _, _ = separated(box, 1.0, nu, within1, within2, -math.inf)
    return value + rest


@separate
def _opposite_bound(box: Box, half: float, slope: float) -> float:
    """Bound of LRL to the start's opposite point.

    If the last heading is open, the leg's end is the point opposite the start on the start's right
    circle. If the first heading is open, the start is the point opposite the end on the end's. Half
    and slope are those of the open heading.
    """
    # theta2 - theta1 is pi + t; the arcs are 4 psi - pi + t, concave in t, and exist for t >= 0
    middle = principal(box.c2 - box.c1 - _PI)
    low, high = middle - half, middle + half
    if low < -1.0 or high > 1.0:
        return -math.inf
    if high < 0.0:
        return math.inf
    least = math.inf
    for t in (max(0.0, low), high):
        psi = 0.5 * _PI + math.asin(math.sqrt(0.75) * math.sin(0.5 * t))
        least = min(least, 4.0 * psi - _PI + t - slope * (t - middle))
    return least - rounding(box, 1.0)


@separate
def _rates(angle: float, slope: float, c: float, s: float) -> tuple[float, float, float]:
    """Coefficients of flatness in one heading.

    They are the rise that is still missing, the rate by this heading's own multiplier, and the rate
    by the other one. The angle is from that heading to the axis, c and s are -4 cos(psi) and 4
    sin(psi).
    """
    along, across = math.cos(angle) / c, math.sin(angle) / s
    return slope - 1.0 - 4.0 * along, -1.0 - along - across, across - along


@separate
def lrl_bound(box: Box) -> float:
    """Bound of LRL.

    Outer arcs that may vanish have multipliers.
    """
    circles = circles_of(box, 1.0)
    if circles.nearest >= 4.0:
        return math.inf
    psis = (
        _PI - math.asin(min(1.0, 0.25 * circles.farthest)) - SLACK,
        _PI - math.asin(0.25 * circles.nearest) + SLACK,
    )
    axis = math.atan2(circles.dy, circles.dx)
    turned = circles.turned
    rho = min(LONGEST_COSTATE, 1.0 / max(1e-3, -math.cos(0.5 * (psis[0] + psis[1]))))
    best = _triangle_bound(box, axis, psis, turned, rho, 0.0, 0.0, 0.0)
    best = max(best, 4.0 * psis[0] + turning_bound(box, -2.0 * psis[1]))
    if box.apart & START_RIGHT and box.apart & START_HALF:
        best = max(best, _opposite_bound(box, box.h2, box.slope2))
    if box.apart & END_RIGHT and box.apart & END_HALF:
        best = max(best, _opposite_bound(box, box.h1, box.slope1))
    if turned > 0.5:
        return best
    psi = 0.5 * (psis[0] + psis[1])
    u, v = axis - box.c1, box.c2 - axis
    near = 2.0 * (box.h1 + box.h2 + turned)
    short1 = abs(principal(psi + u)) < near
    short2 = abs(principal(psi + v)) < near
    # flat in the first heading if rate11 mu1 + rate12 mu2 = rise1, in the last likewise
    c, s = -4.0 * math.cos(psi), 4.0 * math.sin(psi)
    rise1, rate11, rate12 = _rates(u, box.slope1, c, s)
    rise2, rate22, rate21 = _rates(v, box.slope2, c, s)
    size = rate11 * rate22 - rate12 * rate21
    along_axis = 4.0 - _ALONG * c
    flat_in_both = (
        (rise1 * rate22 - rise2 * rate12) / size,
        (rise2 * rate11 - rise1 * rate21) / size,
    )
    # Pairs (mu1, mu2) to try: one multiplier that makes the bound flat in the first or in the last
    # heading, both that make it flat in both, one that gives nu the part `_ALONG` along the axis.
    multipliers = (
        (rise1 / rate11, 0.0),
        (rise2 / rate21, 0.0),
        (0.0, rise1 / rate12),
        (0.0, rise2 / rate22),
        flat_in_both,
        (along_axis, 0.0),
        (0.0, along_axis),
    )
    for mu1, mu2 in multipliers:
        if (mu1 != 0.0 and not short1) or (mu2 != 0.0 and not short2):
            continue
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
