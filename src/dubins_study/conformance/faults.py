"""What is wrong with a path besides its end: its start, its turns, its length and its claims."""

from __future__ import annotations

import math

import numpy as np

from dubins_study.conformance.causes import FIT, fits
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario


def start_cause(scenario: Scenario, path: Path) -> str:
    """What makes a path's start differ from the question's."""
    right, start = scenario.start, path.start
    near = FIT * scenario.radius
    if math.hypot(start.x - scenario.target_x, start.y - scenario.target_y) <= near:
        return (
            "is your path from the target to the start? It begins at question.scenario.start, and "
            "its arcs come in the order of driving"
        )
    if start == (0.0, 0.0, 0.0) and fits(scenario, path):
        return "it leads from (0, 0) to the target: is question.scenario.start used?"
    if start == (0.0, 0.0, 0.0):
        return "is it in the vehicle's frame? Its controls are the same in the world's frame"
    same_place = (start.x, start.y) == (right.x, right.y)
    if same_place and math.isclose(start.heading, math.degrees(right.heading)):
        return "its heading is in degrees; a Pose has rad"
    turns = (start.heading - right.heading) / math.tau
    if same_place and math.isclose(turns, round(turns), abs_tol=FIT):
        return (
            "its heading differs by full turns or by rounding: give question.scenario.start "
            "itself, with its heading as it is"
        )
    if same_place:
        return "its heading is another one; the vehicle cannot turn on the spot"
    return "give question.scenario.start as it is"


def length_cause(scenario: Scenario, path: Path) -> str:
    """What makes an arriving path longer than the shortest of its word; empty if unknown."""
    driven = path.length > 0
    radii = np.abs(path.curvature[driven]) * scenario.radius
    if (radii * path.length[driven] > (2 * math.pi + FIT) * scenario.radius).any():
        return "an arc turns by more than a full turn: take its angle modulo 2 pi"
    width = 1 / radii.max() if radii.any() else 1.0
    if width <= 1 + FIT:
        return ""
    wide = f"its turns are {width:.3g} times as wide as the radius allows"
    if math.isclose(width, 2, rel_tol=FIT):
        return f"{wide}: is question.scenario.radius taken for a diameter?"
    if math.isclose(width, scenario.speed, rel_tol=FIT):
        return f"{wide}: is your radius multiplied by the speed? Paths do not depend on it"
    return f"{wide}: a shortest path turns with the curvature 1 / radius"


def claimed_length_cause(scenario: Scenario, path: Path, claimed: float) -> str:
    """What makes a claimed length differ from its path's own."""
    length, straight = path.total_length, float(path.length[path.curvature == 0].sum())
    near = [
        (straight, "claimed_length is that of the straight alone: add the turns, angle * radius"),
        (length / scenario.speed, "claimed_length is a length, not a travel time"),
        (length * scenario.speed, "claimed_length is the length, not the length times the speed"),
        (length / scenario.radius, "claimed_length is in the unit of the scenario, not in radii"),
    ]
    for value, advice in near:
        if math.isclose(claimed, value, rel_tol=FIT):
            return advice
    return "claimed_length is the length that the solver reports for its path"


def tightness_cause(scenario: Scenario, excess: float) -> str:
    """What makes an arriving path too tight, from its tightest curvature times the radius."""
    radius, ratio = scenario.radius, 1 + excess
    near = [
        (radius**2, "is your radius a curvature? A path's curvature is 1 / radius at most"),
        (radius, "is your path that of radius 1? Its curvature is 1 / question.scenario.radius"),
        (2.0, "is your radius a diameter?"),
        (1 / scenario.speed, "is your radius multiplied by the speed? Paths do not depend on it"),
        (scenario.speed, "is your curvature a turn rate? A curvature is turn rate / speed"),
    ]
    for value, advice in near:
        if value > 1 and math.isclose(ratio, value, rel_tol=FIT):
            return advice
    if excess < FIT:
        return "keep the curvature within 1 / radius exactly: clip it, or tighten the bound"
    return "keep the curvature between -1 / radius and 1 / radius"
