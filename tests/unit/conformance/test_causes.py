"""Mix-ups of a wrong path's solver.

They are guessed from the path alone.
"""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from dubins_study import Path
from dubins_study.conformance.answers import cause_of, length_cause, mix_ups, visit_cause
from dubins_study.conformance.questions import GENERAL, OF_KIND, REFERENCE
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.kinds.shortest import shortest_route

RIGHT = shortest_path(REFERENCE)
K, S = RIGHT.curvatures, RIGHT.lengths
R, V = REFERENCE.radius, REFERENCE.speed
TURNS = K != 0


def of_other(**changes):
    """Controls of a changed question's shortest path."""
    path = shortest_path(replace(REFERENCE, **changes))
    return path.curvatures, path.lengths


# words of the advice -> the controls that a solver with this mix-up returns
MIXED_UP = {
    "left and right are swapped": (-K, S),
    "is your radius a curvature": (np.where(TURNS, np.sign(K) * R, 0), S),
    "that of radius 1": (K * R, S / R),
    "angles in rad": (K, np.where(TURNS, S / R, S)),
    "turn rates and times": (K * V, S / V),
    "heading is taken for degrees": of_other(heading=math.radians(REFERENCE.heading)),
    "starts at .0, 0. with heading 0": of_other(x=0.0, y=0.0, heading=0.0),
    "are these positions": RIGHT.sample(30)[:, :2].T,  # what planners of waypoints return
}


@pytest.mark.parametrize("words", MIXED_UP)
def test_controls_that_are_mixed_up(words):
    """Controls that are mixed up are recognised.

    The mix-up is applied to the shortest path, and found again.
    """
    cause = cause_of(REFERENCE, Path(REFERENCE.start, *MIXED_UP[words]))

    assert re.search(words, cause)
    assert len(MIXED_UP) == len([*mix_ups(REFERENCE, RIGHT)]) + 1


def test_a_path_to_nowhere_has_no_cause():
    """A path to nowhere has no cause.

    Two hundred paths are drawn at random: none fits a guess by accident.
    """
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
    ("controls", "words"),
    [
        ((K, np.where(TURNS, S + 2 * math.pi * R, S)), "more than a full turn"),
        (of_other(radius=2 * R), "2 times as wide"),
        ((K, S), ""),
    ],
)
def test_a_path_that_arrives_and_is_longer(controls, words):
    cause = length_cause(REFERENCE, Path(REFERENCE.start, *controls))

    assert words in cause
    assert bool(words) == bool(cause)


TOURS, ROUTES = OF_KIND["tour"], OF_KIND["route"]
FAR = TOURS["4 points far apart"]
ANY = TOURS["5 points, the end at any"]
BACK = TOURS["4 points, closed"]
LINES = TOURS["2 lines to fly along"]


def bare(scenario):
    """The via points without their headings."""
    return {"via": tuple(point[:2] for point in scenario.via)}


# words of the advice -> a question, and what a solver with this mistake takes it for
TAKEN_FOR = {
    "never passes .4, -3.,": (FAR, {"via": FAR.via[:-1]}),
    "never passes .12, 5.,": (ANY, {"via": ANY.via[:-1]}),
    "ends at a point of question.scenario.via": (FAR, {"target_x": None, "target_y": None}),
    "drives on to its start": (BACK, {"closed": False}),
    "not as it starts": (
        BACK,
        {"closed": False, "order": "given", "target_x": BACK.x, "target_y": BACK.y},
    ),
    "passes .3, 2. with another heading": (LINES, bare(LINES)),
    "passes .4, 3. with another heading": (
        ROUTES["3 legs, a heading on the way"],
        bare(ROUTES["3 legs, a heading on the way"]),
    ),
    "the order of question.scenario.via": (
        ROUTES["5 legs of 1 R to 2 R"],
        {"order": "free"},
    ),
}


@pytest.mark.parametrize("words", TAKEN_FOR)
def test_what_a_path_through_points_leaves_out(words):
    """Conditions that a path through points leaves out.

    It is the shortest path of another question, which lacks just that.
    """
    scenario, changes = TAKEN_FOR[words]
    if words == "ends at a point of question.scenario.via":
        passed = (*scenario.via, (scenario.target_x, scenario.target_y))
        changes = changes | {"via": passed}
    path = shortest_route(replace(scenario, **changes), limit=2.0).path

    assert re.search(words, visit_cause(scenario, path))
    assert visit_cause(replace(scenario, **changes), path) == ""
