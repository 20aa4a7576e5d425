"""Many short paths as arrays: controls of paths of at most two arcs, one per scenario."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.claim import Claim
from dubins_study.study.number import real_array
from dubins_study.study.path import FloatArray, Path
from dubins_study.study.scenario import Scenario

BoolArray = NDArray[np.bool_]
CLAIMS = tuple(Claim)


@dataclass(frozen=True, eq=False)
class Paths:
    """Controls of n paths of at most two arcs, each starting at its scenario's start.

    Args:
        curvature: shape (2, n), 1 / length unit, positive to the left.
        length: shape (2, n), length unit; an arc of length 0 is left out.
        returned: shape (n,), False where there is no path; None if all rows have one.

    Raises:
        TypeError: naming the array, its shape or type, and what was expected.
    """

    curvature: FloatArray
    length: FloatArray
    returned: BoolArray | None = None

    def __post_init__(self) -> None:
        n = np.shape(self.curvature)[-1] if np.ndim(self.curvature) else 0
        for name in ("curvature", "length"):
            object.__setattr__(self, name, real_array(name, getattr(self, name), (2, n)))
        if self.returned is not None:
            returned = np.asarray(self.returned)
            if returned.shape != (n,) or returned.dtype != np.bool_:
                kind = f"has shape {returned.shape} and type {returned.dtype}"
                raise TypeError(f"returned {kind}; expected shape {(n,)} and type bool")
            object.__setattr__(self, "returned", returned)

    def __len__(self) -> int:
        return int(self.curvature.shape[-1])

    def path(self, row: int, scenario: Scenario) -> Path | None:
        """One row's path, as the scalar check takes it."""
        if self.returned is not None and not self.returned[row]:
            return None
        driven = self.length[:, row] != 0
        return Path(scenario.start, self.curvature[driven, row], self.length[driven, row])
