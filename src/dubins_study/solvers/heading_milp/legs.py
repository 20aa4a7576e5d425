"""From the choice of a MILP of `heading-milp` to controls: its legs, freed of its tolerances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dubins_study.solvers.heading_milp.grid import Family
from dubins_study.study.closed_form.shortest import EPS
from dubins_study.study.path import FloatArray

# What may be left of an end point, in radii: two digits inside 1e-8, and far above rounding.
ROUNDED = 1e-10
_PARALLEL = 1e-15  # sine of an angle that is none


def rounding(bridged: FloatArray) -> FloatArray:
    """The distance (radii) that is rounding beside legs that bridge so much."""
    return ROUNDED + 16 * EPS * bridged


class Legs(NamedTuple):
    """The straights of a path.

    Args:
        length: shape (m,), radii, as the family's legs are ordered.
        duals: how the least length changes with the target, (2,), vehicle's frame; None if there
            is no leg to tell.
    """

    length: FloatArray
    duals: FloatArray | None


def least_legs(heading: FloatArray, gap: FloatArray) -> Legs | None:
    """The legs of least sum that add up to a vector; None if none do.

    A linear program in two equations, so two legs are enough: every pair is solved for. Its duals
    are the lambda with lambda.u = 1 for the directions u of both, which for a leg at the switch
    and one at the end is Pontryagin's condition on the costates of a CC path, and for two
    neighbouring headings nearly the unit vector between them.

    Args:
        heading: of the legs, shape (m,), rad.
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
    """Curvatures and lengths at unit radius of a choice with its legs (m,).

    Pieces of no length are left out.
    """
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
