"""Where no path of a word ends."""

from __future__ import annotations

from solvers.turn_rate_dynamics import CLOSE


def unreachable(X: float, Y: float, branch: str) -> str | None:
    """Why no path of the branch's word ends at (X, Y), or None.

    Turning left and then going straight never enters the left turning circle: its arc lies on
    the circle and its tangents outside. (Rates of one sign alone would: straight, then left.)

    Args:
        X, Y: target in the vehicle's frame in radii, forward and to the left.
        branch: `best`, which ends everywhere, `LS` or `RS`.
    """
    side = {"LS": 1.0, "RS": -1.0}.get(branch)
    # 1 - |T - C|^2, without cancellation near the start; above what a miss of CLOSE can hide
    if side is None or Y * side * (2 - Y * side) - X * X <= 4 * CLOSE * (1 + abs(X) + abs(Y)):
        return None
    disc = "left" if side > 0 else "right"
    return f"the target is inside the {disc} turning circle, which no {branch} path enters"
