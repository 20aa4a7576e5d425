"""What a wrong path's solver has mixed up, guessed from the path alone."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from dubins_study import Path, Scenario
from dubins_study.conformance.causes import CAUSES, cause_of
from dubins_study.conformance.faults import (
    claimed_length_cause,
    length_cause,
    start_cause,
    tightness_cause,
)
from dubins_study.conformance.questions import DISCS, GENERAL, REFERENCE
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
    "multiplied by the speed": (K, S * V),
    "turns chords": (K, np.where(TURNS, 2 * R * np.sin(S / (2 * R)), S)),
    "turns left out. They have the length 0": (K, np.where(TURNS, 0.0, S)),
}
# words of the advice -> what the solver takes the question for
MISREAD = {
    "heading is taken for degrees": {"heading": math.radians(REFERENCE.heading)},
    "heading is turned into degrees": {"heading": math.degrees(REFERENCE.heading)},
    "start heading is 0": {"heading": 0.0},
    "compass course": {"heading": math.pi / 2 - REFERENCE.heading},
    "heading is clockwise": {"heading": -REFERENCE.heading},
    "start is .0, 0.": {"x": 0.0, "y": 0.0},
    "starts at .0, 0. with heading 0": {"x": 0.0, "y": 0.0, "heading": 0.0},
    "y points down": {"y": -REFERENCE.y, "target_y": -REFERENCE.target_y},
    "start and target are exchanged": {
        "x": REFERENCE.target_x,
        "y": REFERENCE.target_y,
        "target_x": REFERENCE.x,
        "target_y": REFERENCE.y,
    },
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


@pytest.mark.parametrize("flipped", [0, 1])
def test_a_turn_to_the_wrong_side(flipped):
    """Of two turns, the first or the last; of one turn, left and right are swapped."""
    scenario = DISCS["in the left disc"]
    right = shortest_path(scenario)
    assert len(right.curvature) == 2
    assert (right.curvature != 0).all()
    curvature = np.where(np.arange(2) == flipped, -right.curvature, right.curvature)

    cause = cause_of(scenario, Path(scenario.start, curvature, right.length))
    assert cause.startswith("one of its turns is to the wrong side")


def test_positions_are_no_controls():
    """What planners of waypoints return."""
    positions = RIGHT.sample(30)

    cause = cause_of(REFERENCE, Path(REFERENCE.start, positions[:, 0], positions[:, 1]))
    assert "are these positions" in cause


def test_every_cause_has_a_test():
    """But for the start, which is told before any cause is guessed."""
    words = [*MIXED_UP, *MISREAD, "start at question.scenario.start", "to the wrong side"]

    for cause in CAUSES:
        assert any(re.search(one, cause.advice) for one in words), cause.advice
    # turns that are left out are told apart, and the first and the last turn are two causes
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
    path = Path(start, K * 0.9, S)
    assert words in start_cause(REFERENCE, path)


def test_a_path_from_elsewhere_that_arrives():
    """From the origin, and from the target back to the start."""
    origin = replace(REFERENCE, x=0, y=0, heading=0)
    assert "question.scenario.start used" in start_cause(REFERENCE, shortest_path(origin))
    back = replace(REFERENCE, x=REFERENCE.target_x, y=REFERENCE.target_y, target_x=-3, target_y=4)
    assert "from the target to the start" in start_cause(REFERENCE, shortest_path(back))


@pytest.mark.parametrize(
    ("controls", "words"),
    [
        ((K, np.where(TURNS, S + 2 * math.pi * R, S)), "more than a full turn"),
        ((of_other(radius=2 * R).curvature, of_other(radius=2 * R).length), "for a diameter"),
        ((of_other(radius=5 * R).curvature, of_other(radius=5 * R).length), "5 times as wide"),
        ((K, S), ""),
    ],
)
def test_a_path_that_arrives_and_is_longer(controls, words):
    cause = length_cause(REFERENCE, Path(REFERENCE.start, *controls))

    assert words in cause
    assert bool(words) == bool(cause)


def test_a_radius_times_the_speed():
    fast = replace(REFERENCE, speed=3.0)
    path = shortest_path(replace(fast, radius=3 * R))

    assert re.search("3 times as wide.*multiplied by the speed", length_cause(fast, path))


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1 / V, "not a travel time"),
        (V, "length times the speed"),
        (1 / R, "not in radii"),
        (S[~TURNS].sum() / S.sum(), "the straight alone"),
        (1.3, "the length that the solver reports"),
    ],
)
def test_a_claimed_length_of_something_else(factor, words):
    slow = replace(REFERENCE, speed=V)

    assert words in claimed_length_cause(slow, RIGHT, factor * RIGHT.total_length)
