"""When a path counts as arriving, as drivable and as optimal."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tolerances:
    """When a path counts as arriving, as drivable and as optimal.

    Args:
        miss: largest distance to the target, in turning radii.
        curvature: largest curvature beyond what the branch allows, times the radius.
        gap: largest gap of an answer that is called optimal.
    """

    miss: float = 1e-6
    curvature: float = 1e-9
    gap: float = 1e-4
