"""Guess from a path that misses what its solver mixed up: which question it would be right for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dubins_study.study.path import Path, drivable
from dubins_study.study.scenario import Scenario

SWAPPED_SIDES = "left and right are swapped: curvature is positive to the left"
# A path fits a guess if it ends within this many radii of the target, and is no more than this
# share too tight: far more than a solver's tolerance, far less than a guess fits by chance.
FIT = 1e-3


class _Case(NamedTuple):
    """The question that a path would answer, and the path that it would be."""

    scenario: Scenario
    path: Path


class Cause(NamedTuple):
    """A mix-up: how it changes a right answer back, and what to ask its author."""

    advice: str
    undo: Callable[[Scenario, Path], _Case]


def cause_of(scenario: Scenario, path: Path) -> str:
    """What the author of a path that misses, or is too tight, has mixed up; empty if unknown."""
    if not path.length.size:
        return ""
    if _is_target(scenario, path.curvature[-1], path.length[-1]):
        return (
            "are these positions? A path is its controls: a curvature and a length for each arc, "
            "from which the check drives it"
        )
    turning = path.curvature != 0
    if turning.any() and not path.length[turning].any():
        return "are its turns left out? They have the length 0; an arc is angle * radius long"
    with np.errstate(all="ignore"):
        for cause in CAUSES:
            try:
                case = cause.undo(scenario, path)
            except (ValueError, TypeError):  # the path does not fit the guess at all
                continue
            if fits(*case):
                return cause.advice
    return ""


def _is_target(scenario: Scenario, x: float, y: float) -> bool:
    """Whether two numbers are the target's coordinates."""
    near = 1e-6 * scenario.radius
    return abs(x - scenario.target_x) <= near and abs(y - scenario.target_y) <= near


def fits(scenario: Scenario, path: Path) -> bool:
    """Whether a path is one of a scenario's, but for rounding and a solver's tolerance."""
    if not drivable(path):
        return False
    driven = path.curvature[path.length > 0]
    tightest = float(np.abs(driven).max(initial=0.0)) * scenario.radius
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
    return tightest <= 1 + FIT and miss <= FIT * scenario.radius


def _controls(
    curvature: Callable[[Scenario, Path], np.ndarray] | None = None,
    length: Callable[[Scenario, Path], np.ndarray] | None = None,
) -> Callable[[Scenario, Path], _Case]:
    """The path with other controls, from the right start."""

    def undo(scenario: Scenario, path: Path) -> _Case:
        k = path.curvature if curvature is None else curvature(scenario, path)
        lengths = path.length if length is None else length(scenario, path)
        return _Case(scenario, Path(scenario.start, k, lengths))

    return undo


def _asked(change: Callable[[Scenario], Scenario]) -> Callable[[Scenario, Path], _Case]:
    """The path's controls, from the start of another question."""

    def undo(scenario: Scenario, path: Path) -> _Case:
        other = change(scenario)
        return _Case(other, Path(other.start, path.curvature, path.length))

    return undo


def _inverse(path: Path) -> np.ndarray:
    turning = path.curvature != 0
    return np.where(turning, 1 / np.where(turning, path.curvature, 1.0), 0.0)


def _turning(path: Path, factor: float | np.ndarray) -> np.ndarray:
    """The lengths, those of the turns times a factor."""
    return np.where(path.curvature != 0, path.length * factor, path.length)


def _flipped(path: Path, which: int) -> np.ndarray:
    """The curvatures, one of the turns to the other side; `which` counts turns, -1 is the last."""
    turns = np.flatnonzero((path.curvature != 0) & (path.length > 0))
    if turns.size < 2:
        raise ValueError("a path of one turn has no other")
    return np.where(np.arange(path.length.size) == turns[which], -path.curvature, path.curvature)


def _of_chords(scenario: Scenario, path: Path) -> np.ndarray:
    """The lengths, those of turns taken for chords; not a number where a chord is too long."""
    half = path.length / (2 * scenario.radius)
    return np.where(path.curvature != 0, 2 * scenario.radius * np.arcsin(half), path.length)


def _exchanged(scenario: Scenario) -> Scenario:
    s = scenario
    return replace(s, x=s.target_x, y=s.target_y, target_x=s.x, target_y=s.y)


def _compass(scenario: Scenario) -> Scenario:
    return replace(scenario, heading=math.pi / 2 - scenario.heading)


def _swapped(scenario: Scenario) -> Scenario:
    s = scenario
    return replace(s, x=s.y, y=s.x, target_x=s.target_y, target_y=s.target_x)


_PATH = "Path(start, curvature, length)"
CAUSES = (
    Cause(
        f"does your path start at question.scenario.start? A path is {_PATH}",
        _controls(),
    ),
    Cause(
        "is your radius a curvature? A path's curvature is 1 / radius at most, not the radius",
        _controls(lambda s, p: _inverse(p)),
    ),
    Cause(
        SWAPPED_SIDES,
        _controls(lambda s, p: -p.curvature),
    ),
    *(
        Cause(
            "one of its turns is to the wrong side: curvature is positive to the left and negative "
            "to the right",
            _controls(lambda s, p, which=which: _flipped(p, which)),  # type: ignore[misc]
        )
        for which in (0, -1)
    ),
    Cause(
        "are your curvatures in units of 1 / radius? Divide them by the radius",
        _controls(lambda s, p: p.curvature / s.radius),
    ),
    Cause(
        "are your curvatures angles of turn? A curvature is angle / length",
        _controls(lambda s, p: p.curvature / np.where(p.length == 0, 1.0, p.length)),
    ),
    Cause(
        "are your curvatures in degrees? A curvature is rad / length",
        _controls(lambda s, p: np.radians(p.curvature)),
    ),
    Cause(
        "are your lengths in radii? Multiply them by the radius",
        _controls(length=lambda s, p: p.length * s.radius),
    ),
    Cause(
        "is your path that of radius 1? Divide its curvatures by the radius and multiply its "
        "lengths by it",
        _controls(lambda s, p: p.curvature / s.radius, lambda s, p: p.length * s.radius),
    ),
    Cause(
        "are the lengths of your turns angles in rad? An arc is angle * radius long",
        _controls(length=lambda s, p: _turning(p, s.radius)),
    ),
    Cause(
        "are the lengths of your turns angles in degrees? An arc is radians * radius long",
        _controls(length=lambda s, p: _turning(p, s.radius * math.pi / 180)),
    ),
    Cause(
        "are your lengths times? A length is time * speed",
        _controls(length=lambda s, p: p.length * s.speed),
    ),
    Cause(
        "are your lengths multiplied by the speed? A path's lengths do not depend on it",
        _controls(length=lambda s, p: p.length / s.speed),
    ),
    Cause(
        "are the lengths of your turns chords? An arc is angle * radius long",
        _controls(length=_of_chords),
    ),
    Cause(
        "are your curvatures turn rates? A curvature is turn rate / speed",
        _controls(lambda s, p: p.curvature / s.speed),
    ),
    Cause(
        "are your controls turn rates and times? A path takes curvatures and lengths: divide by "
        "the speed, and multiply by it",
        _controls(lambda s, p: p.curvature / s.speed, lambda s, p: p.length * s.speed),
    ),
    Cause(
        "are your lengths summed up from the start? Each is the length of its own arc",
        _controls(length=lambda s, p: np.diff(p.length, prepend=0.0)),
    ),
    Cause(
        f"are curvature and length swapped? A path is {_PATH}",
        _controls(lambda s, p: p.length, lambda s, p: p.curvature),
    ),
    Cause(
        "is your path from the target to the start? Its arcs come in the order of driving",
        _controls(lambda s, p: p.curvature[::-1], lambda s, p: p.length[::-1]),
    ),
    Cause(
        "your path arrives if the heading is taken for degrees: question.scenario.heading is in "
        "rad, counter-clockwise from +x",
        _asked(lambda s: replace(s, heading=math.radians(s.heading))),
    ),
    Cause(
        "your path arrives if the heading is turned into degrees: question.scenario.heading is "
        "in rad, as math.cos takes it",
        _asked(lambda s: replace(s, heading=math.degrees(s.heading))),
    ),
    Cause(
        "your path arrives if the start heading is 0: is question.scenario.heading used?",
        _asked(lambda s: replace(s, heading=0.0)),
    ),
    Cause(
        "your path arrives if the heading is a compass course: question.scenario.heading is "
        "counter-clockwise from +x",
        _asked(_compass),
    ),
    Cause(
        "your path arrives if the heading is clockwise: question.scenario.heading is "
        "counter-clockwise from +x",
        _asked(lambda s: replace(s, heading=-s.heading)),
    ),
    # the same path arrives at a target that is taken to be relative to the start
    Cause(
        "your path arrives if the start is (0, 0): are question.scenario.x and y used? Start and "
        "target are positions in one frame",
        _asked(lambda s: replace(s, x=0.0, y=0.0)),
    ),
    Cause(
        "your path arrives if it starts at (0, 0) with heading 0: is question.scenario.start used?",
        _asked(lambda s: replace(s, x=0.0, y=0.0, heading=0.0)),
    ),
    Cause("your path arrives if x and y are swapped", _asked(_swapped)),
    Cause(
        "your path arrives if y points down: headings are counter-clockwise and curvature is "
        "positive to the left where y points up",
        _asked(lambda s: replace(s, y=-s.y, target_y=-s.target_y)),
    ),
    Cause(
        "your path arrives if start and target are exchanged: it leads from "
        "question.scenario.start to the target",
        _asked(_exchanged),
    ),
)
