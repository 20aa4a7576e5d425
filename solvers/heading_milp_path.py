"""From the choice of a MILP of `heading-milp` to controls: its legs, freed of its tolerances."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solvers.heading_milp_grid import Family
from study.path import FloatArray

# What may be left of a leg or of an end point, in units of the larger of a radius and the distance
# that the legs bridge; HiGHS's own tolerance leaves ten times as much.
ROUNDED = 1e-10
_PARALLEL = 1e-7  # sine of the least angle between two legs that are solved for together


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
    bridged = math.hypot(*gap)
    allowed = ROUNDED * max(1.0, bridged)
    length = np.zeros(heading.size)
    if bridged <= ROUNDED:
        return Legs(length, None)
    u = np.array([np.cos(heading), np.sin(heading)])
    first, second = np.triu_indices(heading.size, 1)
    sine = np.sin(heading[second] - heading[first])
    crossed = np.abs(sine) > _PARALLEL
    first, second, sine = first[crossed], second[crossed], sine[crossed]
    one = (gap[0] * u[1, second] - gap[1] * u[0, second]) / sine
    two = (gap[1] * u[0, first] - gap[0] * u[1, first]) / sine
    ahead = np.flatnonzero((one >= -allowed) & (two >= -allowed))
    if ahead.size:
        best = ahead[np.argmin((one + two)[ahead])]
        pair = [first[best], second[best]]
        length[pair] = np.maximum((one[best], two[best]), 0.0)
        return Legs(length, np.linalg.solve(u[:, pair].T, np.ones(2)))
    # all legs in one direction, as for a target straight ahead
    if gap @ u[:, 0] > 0 and abs(gap[0] * u[1, 0] - gap[1] * u[0, 0]) <= allowed:
        length[0] = bridged
        return Legs(length, u[:, 0])
    return None


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
