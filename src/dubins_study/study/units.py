"""Detect points and radius in different length units."""

from __future__ import annotations

import numpy as np

from dubins_study.study.scenario import Scenario

_TOGETHER = 0.01  # radii; no vehicle's points are all this near to each other
_DEGREES = np.array([180.0, 90.0])  # of longitude and latitude


def doubtful_units(scenario: Scenario) -> str | None:
    """Warning about the units of a route's points.

    The text says why the points look odd beside the radius, and how they are understood. None if
    they look right.

    Points look odd if all lie within `_TOGETHER` radii of each other, as degrees do, or kilometres
    beside a radius in metres. Points that may be longitudes and latitudes, with a radius above 1,
    look odd within one radius already: a dense track hardly ever has such numbers. The start may be
    a default, and does not count.
    """
    if scenario.legs < 2:
        return None
    points = scenario.points[1:]
    extent = float(np.ptp(points, axis=0).max())
    odd_extent = _TOGETHER
    if scenario.radius > 1 and (np.abs(points) <= _DEGREES).all():
        odd_extent = 1.0
    if extent > odd_extent * scenario.radius:
        return None
    kinds = "degrees, or kilometres beside a radius in metres"
    return (
        f"all points lie within {extent:.3g} of each other, and the radius is "
        f"{scenario.radius:.3g}: are they {kinds}? x, y and radius are taken to be in one unit"
    )
