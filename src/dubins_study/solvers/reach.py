"""Targets that no path of a word reaches."""

from __future__ import annotations

from dubins_study.study.closed_form.shortest import Local


def unreachable(target: Local, branch: str) -> str | None:
    """Why no path of the branch's word ends at a target, or None.

    Turning left and then going straight never enters the left turning circle: its arc lies on
    the circle and its tangents outside. (Rates of one sign alone would: straight, then left.) What
    the coordinates' rounding hides counts as on the circle.

    Args:
        target: in the vehicle's frame.
        branch: `LS` or `RS`; any other ends everywhere as far as is known here.
    """
    if branch == "LS" and target.w > 0:
        return "the target is inside the left turning circle, which no LS path enters"
    if branch == "RS" and target.mirrored.w > 0:
        return "the target is inside the right turning circle, which no RS path enters"
    return None
