"""Many short paths as arrays: controls of paths of at most two arcs, one per scenario."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.claim import Claim
from dubins_study.study.number import doubles
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
        ValueError: naming the array, its shape and what was expected.
        TypeError: if an array does not hold numbers, or `returned` no booleans.
    """

    curvature: FloatArray
    length: FloatArray
    returned: BoolArray | None = None

    def __post_init__(self) -> None:
        n = np.shape(self.curvature)[-1] if np.ndim(self.curvature) else 0
        for name in ("curvature", "length"):
            array = doubles(name, getattr(self, name))
            if array.shape != (2, n):
                raise ValueError(f"{name} has shape {array.shape}; expected {(2, n)}")
            object.__setattr__(self, name, array)
        if self.returned is not None:
            returned = np.asarray(self.returned)
            if returned.shape != (n,):
                raise ValueError(f"returned has shape {returned.shape}; expected {(n,)}")
            if returned.dtype != np.bool_:
                raise TypeError(f"returned is an array of {returned.dtype}; expected booleans")
            object.__setattr__(self, "returned", returned)

    def __len__(self) -> int:
        return int(self.curvature.shape[-1])

    def path(self, row: int, scenario: Scenario) -> Path | None:
        """One row's path, as the scalar check takes it."""
        if self.returned is not None and not self.returned[row]:
            return None
        driven = self.length[:, row] != 0
        return Path(scenario.start, self.curvature[driven, row], self.length[driven, row])
