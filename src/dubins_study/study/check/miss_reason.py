"""Why an answer's verdict is `misses`, in words: which condition of the check its path fails."""

from __future__ import annotations

import math

from dubins_study.study.check.verdict import Tolerances, curvature_excess
from dubins_study.study.path import Path, drivable
from dubins_study.study.scenario import Scenario

_DEFAULT = Tolerances()


def miss_reason(
    scenario: Scenario, path: Path, branch: str, tolerances: Tolerances = _DEFAULT
) -> str:
    """What keeps a path whose verdict is `misses` from answering its question."""
    if not drivable(path):
        return "the path has a number that is not finite, or a length below 0"
    if path.start != scenario.start:
        return "the path starts elsewhere"
    pieces = zip(path.curvature.tolist(), path.length.tolist(), strict=True)
    excess = curvature_excess([k * scenario.radius for k, s in pieces if s > 0], branch)
    if excess > tolerances.curvature:
        return f"the curvature is {excess:.3g} / R beyond what the branch allows"
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y) / scenario.radius
    if miss > tolerances.miss:
        return f"the path ends {miss:.3g} R from the target"
    return "the path is too long to be driven to within a radius, or the branch has none"
