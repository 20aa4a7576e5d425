"""What a wrong path's solver has mixed up, guessed from the path alone."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from dubins_study import Path, Scenario
from dubins_study.conformance.causes import CAUSES, cause_of, start_cause, tightness_cause
from dubins_study.conformance.questions import GENERAL, REFERENCE
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.scenario import Pose

RIGHT = shortest_path(REFERENCE)
K, S = RIGHT.curvature, RIGHT.length
R, V = REFERENCE.radius, REFERENCE.speed
TURNS = K != 0


def of_other(**changes) -> Path:
    """The controls of the shortest path of a changed question."""
    return shortest_path(replace(REFERENCE, **changes))


# words of the advice -> the controls that a solver with this mix-up returns
MIXED_UP = {
    "is your radius a curvature": (np.where(TURNS, np.sign(K) * R, 0), S),
    "left and right are swapped": (-K, S),
    "curvatures in units of 1 / radius": (K * R, S),
    "curvatures angles of turn": (K * S, S),
    "curvatures in degrees": (np.degrees(K), S),
    "lengths in radii": (K, S / R),
    "that of radius 1": (K * R, S / R),
    "angles in rad": (K, np.where(TURNS, S / R, S)),
    "angles in degrees": (K, np.where(TURNS, np.degrees(S / R), S)),
    "are your lengths times": (K, S / V),
    "are your curvatures turn rates": (K * V, S),
    "turn rates and times": (K * V, S / V),
    "summed up from the start": (K, np.cumsum(S)),
    "curvature and length swapped": (S, K),
    "from the target to the start": (K[::-1], S[::-1]),
}
# words of the advice -> what the solver takes the question for
MISREAD = {
    "heading is taken for degrees": {"heading": math.radians(REFERENCE.heading)},
    "heading is turned into degrees": {"heading": math.degrees(REFERENCE.heading)},
    "start heading is 0": {"heading": 0.0},
    "compass course": {"heading": math.pi / 2 - REFERENCE.heading},
    "heading is clockwise": {"heading": -REFERENCE.heading},
    "start is .0, 0.": {"x": 0.0, "y": 0.0},
    "x and y are swapped": {
        "x": REFERENCE.y,
        "y": REFERENCE.x,
        "target_x": REFERENCE.target_y,
        "target_y": REFERENCE.target_x,
    },
}


@pytest.mark.parametrize("words", MIXED_UP)
def test_controls_that_are_mixed_up(words):
    """The mix-up is applied to the shortest path, and found again."""
    cause = cause_of(REFERENCE, Path(REFERENCE.start, *MIXED_UP[words]))

    assert re.search(words, cause)


@pytest.mark.parametrize("words", MISREAD)
def test_a_question_that_is_misread(words):
    other = of_other(**MISREAD[words])
    cause = cause_of(REFERENCE, Path(REFERENCE.start, other.curvature, other.length))

    assert re.search(words, cause)


def test_positions_are_no_controls():
    """What planners of waypoints return."""
    positions = RIGHT.sample(30)

    cause = cause_of(REFERENCE, Path(REFERENCE.start, positions[:, 0], positions[:, 1]))
    assert "are these positions" in cause


def test_every_cause_has_a_test():
    """But for the start, which is told before any cause is guessed."""
    words = [*MIXED_UP, *MISREAD, "start at question.scenario.start"]

    for cause in CAUSES:
        assert any(re.search(one, cause.advice) for one in words), cause.advice
    assert len(CAUSES) == len(words)


def test_a_path_to_nowhere_has_no_cause():
    """Two hundred paths drawn at random: none fits a guess by accident."""
    rng = np.random.default_rng(3)
    for scenario in [*GENERAL.values()] * 22:
        curvature = rng.uniform(-1, 1, 2) / scenario.radius
        path = Path(scenario.start, curvature, rng.uniform(0, 9, 2) * scenario.radius)
        assert cause_of(scenario, path) == ""


@pytest.mark.parametrize(
    "controls", [([], []), ([np.nan], [1.0]), ([1.0], [np.inf]), ([0.0], [0.0])]
)
def test_a_path_that_cannot_be_driven_has_no_cause(controls):
    assert cause_of(REFERENCE, Path(REFERENCE.start, *controls)) == ""


@pytest.mark.parametrize(
    ("radius", "ratio", "words"),
    [
        (2.5, 6.25, "is your radius a curvature"),
        (2.5, 2.5, "that of radius 1"),
        (2.5, 2.0, "is your radius a diameter"),
        (2.5, 1.00001, "within 1 / radius exactly"),
        (2.5, 1.7, "between -1 / radius and 1 / radius"),
        (0.4, 3.0, "turn rate"),
    ],
)
def test_a_path_that_arrives_and_is_too_tight(radius, ratio, words):
    """The tightest curvature times the radius tells what was taken for the curvature."""
    scenario = Scenario(target_x=1, target_y=1, radius=radius, speed=3)

    assert words in tightness_cause(scenario, ratio - 1)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        (Pose(0, 0, 0), "vehicle's frame"),
        (Pose(-3, 4, math.degrees(2.2)), "in degrees"),
        (Pose(-3, 4, 0.3), "cannot turn on the spot"),
        (Pose(1, 1, 2.2), "give question.scenario.start as it is"),
    ],
)
def test_a_path_that_starts_elsewhere(start, words):
    assert words in start_cause(REFERENCE, start)
