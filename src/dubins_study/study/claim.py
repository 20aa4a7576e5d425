"""The claims that a solver can make of its answer."""

from __future__ import annotations

from enum import StrEnum


class Claim(StrEnum):
    """What a solver says of its answer, strongest first."""

    OPTIMAL = "optimal"
    LOCAL = "local"
    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    LIMIT = "limit"
    FAILED = "failed"
    NONE = "none"
