"""From the choices of a MILP of `heading-milp` to controls: its legs, freed of its tolerances."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solvers.heading_milp_grid import Family
from study.path import FloatArray

# What rounding may leave of a leg or of an end point, in units of the larger of a radius and the
# distance that the legs bridge; HiGHS's own tolerances leave a hundred times as much.
ROUNDED = 1e-10
_PARALLEL = 1e-7  # sine of the least angle between two legs that are solved for together


class Legs(NamedTuple):
    """The straights of a path.

    Args:
        length: shape (k, q + 1), radii: row g belongs to the last step of turn g.
        duals: how the length changes with the target, (2,), vehicle's frame; None without legs.
    """

    length: FloatArray
    duals: FloatArray | None


def fewest_legs(family: Family, chosen: list[int], target: FloatArray) -> Legs | None:
    """The legs of least sum that lead a path's turns to the target (2,); None if none do.

    With the choices made, the MILP is a linear program in two equations, so at most two legs are
    driven: every pair is solved for. The duals of a pair are the lambda with lambda.u = 1 for the
    direction u of both legs.
    """
    rows = [int(n) + j for n, j in zip(family.starts, chosen, strict=True)]
    heading = family.heading[rows]
    flat = heading.ravel()
    gap = target - family.shift[:, rows].sum(axis=1)
    allowed = ROUNDED * max(1.0, math.hypot(*gap))
    if math.hypot(*gap) <= allowed:
        return Legs(np.zeros(heading.shape), None)
    u = np.array([np.cos(flat), np.sin(flat)])
    length = np.zeros(flat.size)
    first, second = np.triu_indices(flat.size, 1)
    sine = np.sin(flat[second] - flat[first])
    crossed = np.abs(sine) > _PARALLEL
    first, second, sine = first[crossed], second[crossed], sine[crossed]
    one = (gap[0] * u[1, second] - gap[1] * u[0, second]) / sine
    two = (gap[1] * u[0, first] - gap[0] * u[1, first]) / sine
    ahead = np.flatnonzero((one >= -allowed) & (two >= -allowed))
    if ahead.size:
        best = ahead[np.argmin((one + two)[ahead])]
        pair = [first[best], second[best]]
        length[pair] = np.maximum((one[best], two[best]), 0.0)
        return Legs(length.reshape(heading.shape), np.linalg.solve(u[:, pair].T, np.ones(2)))
    # every leg in one direction, as for a target straight ahead
    if gap @ u[:, 0] > 0 and abs(gap[0] * u[1, 0] - gap[1] * u[0, 0]) <= allowed:
        length[0] = math.hypot(*gap)
        return Legs(length.reshape(heading.shape), u[:, 0])
    return None


def controls(family: Family, chosen: list[int], legs: Legs) -> tuple[list[float], list[float]]:
    """Curvatures and lengths at unit radius, pieces of no length left out."""
    pieces: list[tuple[float, float]] = []
    now = 0.0  # heading, to the side of the family
    for group, j, lengths in zip(family.turns, chosen, legs.length, strict=True):
        stops = [*zip(group.leg[j], lengths, strict=True), (group.turn[j], 0.0)]
        for heading, straight in stops:
            if straight > 0 or heading == group.turn[j]:
                end = float(group.sign * heading)
                pieces += [
                    (float(group.sign * family.side), abs(end - now)),
                    (0.0, float(straight)),
                ]
                now = end
    kept = [(k, length) for k, length in pieces if length > 0]
    return [k for k, _ in kept], [length for _, length in kept]
