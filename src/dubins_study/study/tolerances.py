"""Tolerances for arriving, for driving and for optimality.

No other module states them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from time import perf_counter

from dubins_study.errors import DubinsStudyError
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.values import did_you_mean, short

# radii: the largest distance to the target of a path that arrives, in every profile
ARRIVES = 1e-6
# rad: the largest error of a given final heading, in every profile. The error changes nothing but
# the heading itself. Turning by it takes as many radii of path as a target may be missed by.
HEADED = ARRIVES
# share of the coordinates' size and a path's length that driving in floating point loses
DRIVEN = 32.0 * EPS
# Seconds after which the search for a route's reference ends; most take less than one. They are
# counted in work (`kinds.shortest.BOXES_A_SECOND`): a slower machine takes longer for the same
# interval. Only after `PATIENCE` times as long by the clock the interval stays wider, and an answer
# may be undecided, but never wrong.
SEARCH_S = 20.0
PATIENCE = 5.0
# `patience` of a single solve, whose caller waits. The rest of its time limit is for steps that do
# not look at the clock.
_PATIENCE_OF_ONE = 0.8


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Tolerances of a check, and its effort.

    They say when a path counts as arriving, as drivable and as optimal. A check ends `patience`
    times `search_s` after it began, or soon after. Anything not done by then is not proved.
    """

    miss: float = ARRIVES  # largest distance to the target, in turning radii
    curvature: float = 1e-9  # largest curvature beyond what the branch allows, times the radius
    gap: float = 1e-4  # largest gap of an answer that is called optimal
    search_s: float = SEARCH_S
    patience: float = PATIENCE
    until: float = math.inf  # of `perf_counter`: when the check ends

    def begun(self) -> Tolerances:
        """Tolerances of a check that begins now.

        `until` is set to the check's end; an earlier one stays.
        """
        end = perf_counter() + self.patience * self.search_s
        return replace(self, until=min(end, self.until))


DEFAULT = Tolerances()
# Named tolerances; a solver may add settings of its own under the same name (its `profiles`).
# `default` calls four digits of the length optimal, enough for a plotted path or a flight plan.
# `accurate` asks for what an NLP solver reaches at its usual tolerance; `fast` for three digits.
PROFILES = {
    "default": DEFAULT,
    "fast": Tolerances(gap=1e-3),
    "accurate": Tolerances(gap=1e-6),
}


class ProfileError(DubinsStudyError, ValueError):
    """No profile of that name."""


def tolerances(profile: str, limit: float = math.inf) -> Tolerances:
    """Tolerances of a profile.

    With a limit (s) of a solve, its check takes no longer than that by the clock, and no longer
    than `SEARCH_S`.
    """
    if not isinstance(profile, str) or profile not in PROFILES:
        names = ", ".join(PROFILES)
        near = did_you_mean(profile, PROFILES)
        raise ProfileError(f"no profile named {short(profile)}; {near}choose one of: {names}")
    allowed = PROFILES[profile]
    if math.isinf(limit):
        return allowed
    return replace(allowed, search_s=min(limit, allowed.search_s), patience=_PATIENCE_OF_ONE)


def allowed_miss(miss: float, radius: float, extent: float, length: float) -> float:
    """Largest distance at which a point counts as passed.

    In the length unit, with the rounding of driving included. `miss` is `Tolerances.miss` (radii),
    `extent` is `Scenario.extent`, 0 of a path from the origin.
    """
    return miss * radius + DRIVEN * (extent + length)


def arrives(miss: float, radius: float, extent: float, length: float, allowed: float) -> bool:
    """Whether a path ends at its target.

    The tolerance and the rounding of driving are allowed for.

    A path that is so long that rounding moves its end by more than a radius cannot be checked.
    `miss` is the distance from its end to the target, `extent` is `Scenario.extent`, `allowed` is
    `Tolerances.miss` (radii). `judging.verdict_frame` compiles this function.
    """
    near = miss <= allowed_miss(allowed, radius, extent, length)
    return near & (DRIVEN * (extent + length) <= radius)
