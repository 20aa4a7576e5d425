"""Guess from a path that misses what its solver mixed up: which question it would be right for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dubins_study.study.path import Path, drivable
from dubins_study.study.scenario import Scenario

# A path fits a guess if it ends within this many radii of the target, and is no more than this
# share too tight: far more than a solver's tolerance, far less than a guess fits by chance.
_FIT = 1e-3
_POSITIONS = (
    "are these positions? A path is its controls: a curvature and a length for each arc, from "
    "which the check drives it"
)


class Cause(NamedTuple):
    """A mix-up: what to tell its author, and the question and the controls without it."""

    advice: str
    scenario: Callable[[Scenario], Scenario] = lambda s: s
    curvature: Callable[[Scenario, Path], np.ndarray] = lambda s, p: p.curvature
    length: Callable[[Scenario, Path], np.ndarray] = lambda s, p: p.length


def _inverse(path: Path) -> np.ndarray:
    turning = path.curvature != 0
    return np.where(turning, 1 / np.where(turning, path.curvature, 1.0), 0.0)


CAUSES = (
    Cause(
        "left and right are swapped: curvature is positive to the left",
        curvature=lambda s, p: -p.curvature,
    ),
    Cause(
        "is your radius a curvature? A path's curvature is 1 / radius at most, not the radius",
        curvature=lambda s, p: _inverse(p),
    ),
    Cause(
        "is your path that of radius 1? Divide its curvatures by the radius and multiply its "
        "lengths by it",
        curvature=lambda s, p: p.curvature / s.radius,
        length=lambda s, p: p.length * s.radius,
    ),
    Cause(
        "are the lengths of your turns angles in rad? An arc is angle * radius long",
        length=lambda s, p: np.where(p.curvature != 0, p.length * s.radius, p.length),
    ),
    Cause(
        "are your controls turn rates and times? A path takes curvatures and lengths: divide by "
        "the speed, and multiply by it",
        curvature=lambda s, p: p.curvature / s.speed,
        length=lambda s, p: p.length * s.speed,
    ),
    Cause(
        "your path arrives if the heading is taken for degrees: question.scenario.heading is in "
        "rad, counter-clockwise from +x",
        scenario=lambda s: replace(s, heading=math.radians(s.heading)),
    ),
    Cause(
        "your path arrives if it starts at (0, 0) with heading 0: is question.scenario.start used?",
        scenario=lambda s: replace(s, x=0.0, y=0.0, heading=0.0),
    ),
)


def cause_of(scenario: Scenario, path: Path) -> str:
    """What the author of a path that misses, or is too tight, has mixed up; empty if unknown."""
    if not path.length.size:
        return ""
    last = np.array([path.curvature[-1] - scenario.target_x, path.length[-1] - scenario.target_y])
    if (np.abs(last) <= 1e-6 * scenario.radius).all():
        return _POSITIONS
    with np.errstate(all="ignore"):
        for cause in CAUSES:
            other = cause.scenario(scenario)
            controls = cause.curvature(scenario, path), cause.length(scenario, path)
            if _fits(other, Path(other.start, *controls)):
                return cause.advice
    return ""


def _fits(scenario: Scenario, path: Path) -> bool:
    """Whether a path is one of a scenario's, but for rounding and a solver's tolerance."""
    if not drivable(path):
        return False
    tightest = float(np.abs(path.curvature[path.length > 0]).max(initial=0.0)) * scenario.radius
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
    return tightest <= 1 + _FIT and miss <= _FIT * scenario.radius


def length_cause(scenario: Scenario, path: Path) -> str:
    """What makes an arriving path longer than the shortest of its word; empty if unknown."""
    turns = np.abs(path.curvature * path.length)
    if (turns > 2 * math.pi + _FIT).any():
        return "an arc turns by more than a full turn: take its angle modulo 2 pi"
    tightest = np.abs(path.curvature[path.length > 0]).max(initial=0.0) * scenario.radius
    if 0 < tightest < 1 - _FIT:
        return (
            f"its turns are {1 / tightest:.3g} times as wide as the radius allows: a shortest path "
            "turns with the curvature 1 / radius"
        )
    return ""
