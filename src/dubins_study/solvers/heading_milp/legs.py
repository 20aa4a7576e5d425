"""From the MILP's choice to controls: the legs are computed anew, without HiGHS's tolerances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dubins_study.solvers.heading_milp.grid import Family
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import FloatArray

# The largest miss in radii that counts as none: a hundredth of 1e-8, and far above rounding.
ROUNDED = 1e-10
_PARALLEL = 1e-15  # sine of the angle between two legs that count as parallel


def rounding(bridged: FloatArray) -> FloatArray:
    """The miss (radii) that rounding explains where legs bridge these distances (radii)."""
    return ROUNDED + 16 * EPS * bridged


class Legs(NamedTuple):
    """The straights of a path.

    Args:
        length: shape (m,), radii, in the order of the family's legs.
        duals: gradient (2,) of the least length by the target, vehicle's frame; None without legs.
    """

    length: FloatArray
    duals: FloatArray | None


def least_legs(heading: FloatArray, gap: FloatArray) -> Legs | None:
    """The shortest legs that together bridge a gap; None if no legs do.

    A linear program in two equations has a solution with two legs, so every pair is tried. The
    duals are the vector whose product with both legs' directions is 1. For a leg at the switch and
    one at the end that is Pontryagin's condition on the costates of a CC path; for two neighbouring
    headings it is nearly the unit vector between them.

    Args:
        heading: directions of the legs, shape (m,), rad.
        gap: from the end of the turns to the target, (2,), radii.
    """
    length = np.zeros(heading.size)
    bridged = np.hypot(*gap)
    if bridged <= ROUNDED:
        return Legs(length, None)
    u = np.array([np.cos(heading), np.sin(heading)])
    along, across = gap @ u, gap[1] * u[0] - gap[0] * u[1]
    one = int(np.argmin(np.where(along > 0, np.abs(across), np.inf)))
    if along[one] > 0 and abs(across[one]) <= rounding(bridged):
        length[one] = along[one]
        return Legs(length, u[:, one])
    first, second = np.triu_indices(heading.size, 1)
    sine = np.sin(heading[second] - heading[first])
    crossed = np.abs(sine) > _PARALLEL
    first, second, sine = first[crossed], second[crossed], sine[crossed]
    by_first, by_second = -across[second] / sine, across[first] / sine
    ahead = np.flatnonzero((by_first >= 0) & (by_second >= 0))
    if not ahead.size:
        return None
    best = ahead[np.argmin((by_first + by_second)[ahead])]
    pair = [first[best], second[best]]
    length[pair] = by_first[best], by_second[best]
    both = u[:, pair].sum(axis=1)
    return Legs(length, both / (1 + u[:, pair[0]] @ u[:, pair[1]]))


def controls(family: Family, choice: int, legs: FloatArray) -> tuple[list[float], list[float]]:
    """Curvatures and lengths at unit radius of a choice and its legs (m,), without empty pieces."""
    pieces: list[tuple[float, float]] = []
    heading, done = 0.0, 0
    for turns, ends in zip(family.turns, family.pick, strict=True):
        end = int(ends[choice])
        stops = turns.leg[end].tolist()
        lengths = legs[done : done + len(stops)].tolist()
        done += len(stops)
        driven = [stop for stop in zip(stops, lengths, strict=True) if stop[1] > 0]
        for stop, length in [*driven, (float(turns.turn[end]), 0.0)]:
            arc = turns.sign * (turns.sign * stop - heading)
            heading = turns.sign * stop
            pieces += [(float(turns.sign * family.side), arc), (0.0, length)]
    kept = [(curvature, length) for curvature, length in pieces if length > 0]
    return [curvature for curvature, _ in kept], [length for _, length in kept]
