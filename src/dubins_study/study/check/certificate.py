"""The levels of a proof, and the tolerances that decide between them."""

from __future__ import annotations

import math
from typing import Any

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.words import Proof

PROOFS = tuple(Proof)
# A solver's 1e-8 on lengths leaves angles off by about as much; the turn of 1e-3 that an
# interior-point method adds to a segment leaves its square, 1e-6 (docs/derivation.md, section 9).
PMP_TOLERANCE = 1e-7
# nu3 sums products of the costates with positions, which loses this much for every radius of length
PMP_ROUNDING = 16 * EPS
# branch whose proof needs no costates: for `proof_levels`, of routes and given final headings too
BY_INTERVAL = "LR"
# rad: at the tie straight behind the margin is zero up to rounding
CUT_TOLERANCE = 1e-9
# relative: a bound above the shortest length by less is so by the solver's own tolerance
BOUND_TOLERANCE = 1e-9


def proof_levels(
    branch: str,
    optimal: Any,
    none_exists: Any,
    arrives: Any,
    length: Any,
    radius: Any,
    residual: Any,
    cut: Any,
    low: Any,
    near: Any,
    bound: Any,
    allowed: Any,
) -> tuple[Any, Any, Any]:
    """Whether answers are proved, bounded and extremals, in this order of precedence.

    Plain operators only, which serve one answer and arrays alike.

    Args:
        branch: of the question; `BY_INTERVAL` where the interval alone proves the shortest path.
        optimal, none_exists: whether the verdict is this.
        arrives: whether the path does.
        length, radius: of the path and of its turns; NaN where there is no path.
        residual: of Pontryagin's conditions; NaN where unknown.
        cut: margin (rad); NaN where unknown.
        low: of the proven interval around the shortest length.
        near: whether that interval is finite and the length within `allowed` of it. An answer far
            below it owes that to its miss, and proves nothing.
        bound: the solver's own; NaN if it is false, since then it contradicts the answer.
        allowed: tolerance of lengths.
    """
    tolerance = PMP_TOLERANCE + PMP_ROUNDING * length / radius
    # a path of no length has no costates, and needs none
    is_extremal = arrives & ((length == 0) | (residual <= tolerance))
    clear = (cut >= -CUT_TOLERANCE) | (branch != "best")
    near = arrives & near
    proved = near & optimal & ((is_extremal & clear) | (branch in ("LR", "RL")))
    no_path = none_exists & (low == math.inf)
    return proved | no_path, near & (abs(length - bound) <= allowed), is_extremal
