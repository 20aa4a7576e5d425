"""Named tolerances; a solver may add settings of its own under the same name (its `profiles`)."""

from __future__ import annotations

import math
from dataclasses import replace

from dubins_study.errors import DubinsStudyError
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.values import did_you_mean, short

# `default` calls four digits of the length optimal: what a plotted path or a flight plan can use.
# `accurate` asks for what an NLP solver reaches at its usual tolerance; `fast` for three digits.
PROFILES = {
    "default": Tolerances(),
    "fast": Tolerances(gap=1e-3),
    "accurate": Tolerances(gap=1e-6),
}


class ProfileError(DubinsStudyError, ValueError):
    """No profile of that name."""


def tolerances(profile: str, limit: float = math.inf) -> Tolerances:
    """The tolerances of a profile; the check searches no longer than the limit (s) of a solve."""
    if not isinstance(profile, str) or profile not in PROFILES:
        names = ", ".join(PROFILES)
        near = did_you_mean(profile, PROFILES)
        raise ProfileError(f"no profile named {short(profile)}; {near}choose one of: {names}")
    allowed = PROFILES[profile]
    return allowed if limit >= allowed.search_s else replace(allowed, search_s=limit)
