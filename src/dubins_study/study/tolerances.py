"""When a path counts as arriving, as drivable and as optimal: the one place that says so."""

from __future__ import annotations

from dataclasses import dataclass

from dubins_study.study.body_coordinates import EPS

# radii: the largest distance to the target of a path that arrives, in every profile
ARRIVES = 1e-6
# rad: the largest error of a final heading that is given, in every profile. It moves nothing but
# the heading itself, and turning by it takes as many radii of path as a target may be missed by.
HEADED = ARRIVES
# of the coordinates' size and a path's length: what driving in floating point loses
DRIVEN = 32.0 * EPS
# Seconds after which the search for a route's reference ends; most take less than one. On a slower
# machine an interval may be wider, and an answer undecided there, but never wrong.
SEARCH_S = 20.0


@dataclass(frozen=True, slots=True)
class Tolerances:
    """When a path counts as arriving, as drivable and as optimal, and the effort to find out."""

    miss: float = ARRIVES  # largest distance to the target, in turning radii
    curvature: float = 1e-9  # largest curvature beyond what the branch allows, times the radius
    gap: float = 1e-4  # largest gap of an answer that is called optimal
    search_s: float = SEARCH_S


def arrives(miss: float, radius: float, extent: float, length: float, allowed: float) -> bool:
    """Whether a path ends at its target, up to the tolerance and the rounding of driving it.

    A path that is so long that rounding moves its end by more than a radius cannot be checked.
    `miss` is the distance from its end to the target, `extent` is `Scenario.extent`, `allowed` is
    `Tolerances.miss` (radii). `check.verdict_frame` compiles this function.
    """
    rounding = DRIVEN * (extent + length)
    return (miss <= allowed * radius + rounding) & (rounding <= radius)
