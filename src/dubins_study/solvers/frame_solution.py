"""The answers of a solver to a whole frame of scenarios."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.claim import Claim
from dubins_study.study.path import FloatArray

if TYPE_CHECKING:
    from dubins_study.study.paths import Paths


@dataclass(frozen=True, eq=False)
class FrameSolution:
    """The answers of a solver's `solve_frame(frame, branch)` to n scenarios, as arrays.

    The frame that the solver gets has passed `study.scenario.check_frame`; `branch` is one of the
    solver's own. The caller times the call and judges the paths, as for `Solver.solve`.

    Args:
        claim: one for all rows, or indices into `study.paths.CLAIMS`, shape (n,).
        paths: controls of n paths of at most two arcs, and which rows have one.
        claimed_length: as the solver reports it (length unit), shape (n,); NaN where there is
            none. None if there is none in any row.
        lower_bound: proven bounds (length unit), shape (n,), or None.
        native_status, message: the solver's status and message, one for all rows; there may be
            n messages.
    """

    claim: Claim | ArrayLike
    paths: Paths
    claimed_length: FloatArray | None = None
    lower_bound: FloatArray | None = None
    native_status: str = ""
    message: str | Sequence[str] = ""

    def __post_init__(self) -> None:
        from dubins_study.study.paths import CLAIMS

        n = len(self.paths)
        per_row = {"claimed_length": self.claimed_length, "lower_bound": self.lower_bound}
        if not isinstance(self.claim, Claim):
            per_row["claim"] = codes = np.asarray(self.claim)
            if codes.dtype.kind not in "iu" or not np.isin(codes, range(len(CLAIMS))).all():
                raise TypeError("claim is neither a Claim nor indices into CLAIMS")
        for name, values in per_row.items():
            if values is not None and np.shape(values) != (n,):
                raise TypeError(f"{name} has shape {np.shape(values)}; expected {(n,)}")
        if not isinstance(self.message, str) and len(self.message) != n:
            raise TypeError(f"there are {len(self.message)} messages; expected 1 or {n}")
