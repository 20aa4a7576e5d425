"""The answers of a solver to a whole frame of scenarios."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.path import FloatArray
from dubins_study.study.values import short
from dubins_study.study.words import Claim

if TYPE_CHECKING:
    from dubins_study.study.path import Paths


@dataclass(frozen=True, eq=False)
class FrameSolution:
    """The answers of a solver's `solve_frame(frame, branch)` to n scenarios, as arrays.

    The frame that the solver gets has passed `study.scenario.check_frame`; `branch` is one of the
    solver's own. The caller times the call and judges the paths, as for `Solver.solve`.

    Args:
        claim: one for all rows, or indices into `study.path.CLAIMS`, shape (n,).
        paths: controls of n paths of at most two arcs, and which rows have one.
        claimed_length: as the solver reports it (length unit), shape (n,); NaN where there is
            none. None if there is none in any row.
        lower_bound: proven bounds (length unit), shape (n,), or None.
        native_status, message: the solver's status and message, one for all rows; there may be
            n messages.

    Raises:
        TypeError: naming the field, its shape or type, and what was expected. It is raised inside
            the solver that makes the solution, and so counts as that solver's failure.
    """

    claim: Claim | ArrayLike
    paths: Paths
    claimed_length: FloatArray | None = None
    lower_bound: FloatArray | None = None
    native_status: str = ""
    message: str | Sequence[str] = ""

    def __post_init__(self) -> None:
        from dubins_study.study.path import CLAIMS, Paths
        from dubins_study.study.values import real_array

        paths = self.paths
        if not isinstance(paths, Paths):
            raise TypeError(f"paths is {short(paths)}; expected Paths")
        # checked anew: a plug-in may have replaced the arrays since
        object.__setattr__(self, "paths", Paths(paths.curvature, paths.length, paths.returned))
        n = len(self.paths)
        for name in ("claimed_length", "lower_bound"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, real_array(name, getattr(self, name), (n,)))
        if not isinstance(self.claim, Claim):
            codes = np.asarray(self.claim)
            known = codes.dtype.kind in "iu" and codes.min(initial=0) >= 0
            if not known or codes.max(initial=0) >= len(CLAIMS):
                raise TypeError("claim is neither a Claim nor indices into CLAIMS")
            if codes.shape != (n,):
                raise TypeError(f"claim has shape {codes.shape}; expected {(n,)}")
            native = codes.astype(codes.dtype.newbyteorder("="), copy=False)
            object.__setattr__(self, "claim", native)
        if not isinstance(self.native_status, str):
            raise TypeError(f"native_status is {short(self.native_status)}; expected a text")
        if isinstance(self.message, str):
            return
        if len(self.message) != n:
            raise TypeError(f"there are {len(self.message)} messages; expected 1 or {n}")
        for row, message in enumerate(self.message):
            if not isinstance(message, str):
                raise TypeError(f"row {row}: message is {short(message)}; expected a text")
