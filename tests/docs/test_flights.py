"""The page on flights is right about wind.

An aircraft is blown about on its paths.
"""

import math

import numpy as np
import pytest

from dubins_study import Path
from dubins_study.study.scenario import Pose

STEP = 5e-4  # of the time that the aircraft takes to fly one radius


def circles(radius: float) -> Path:
    """Two full turns, left and right, around a straight.

    Every course is turned through.
    """
    turn = math.tau * radius
    return Path(Pose(0, 0, 0.3), [1 / radius, 0, -1 / radius], [turn, 2.0, turn])


def leaves(path: Path, wind: tuple[float, float]) -> float:
    """Largest distance of an aircraft from its path.

    Its airspeed is 1 and its radius in the air is 1.

    Its nose is turned to where its velocity over ground has the course of the path, at a rate of 1
    at most; the wind carries it along.
    """
    along = 0.0
    off = 0.0
    x, y, course = path.at([0.0])[0]
    nose = holding(course, wind)
    at = np.linspace(0, path.length, 200_001)
    poses = path.at(at)
    while along < path.length:
        place = poses[int(along / path.length * 200_000)]
        off = max(off, math.hypot(x - place[0], y - place[1]))
        wanted = math.remainder(holding(place[2], wind) - nose, math.tau)
        nose += min(max(wanted, -STEP), STEP)
        east, north = math.cos(nose) + wind[0], math.sin(nose) + wind[1]
        x, y = x + STEP * east, y + STEP * north
        # what counts as flown is what points along the path
        along += STEP * (east * math.cos(place[2]) + north * math.sin(place[2]))
    return off


def holding(course: float, wind: tuple[float, float]) -> float:
    """Heading of the nose that holds a course.

    The wind across it is flown against.
    """
    across = wind[1] * math.cos(course) - wind[0] * math.sin(course)
    return course - math.asin(across)


@pytest.mark.parametrize("speed", [0.1, 0.6])
@pytest.mark.parametrize("toward", [0.3, 4.0])
def test_the_radius_for_wind_is_enough_and_no_smaller_one(speed, toward):
    """The radius for wind suffices; no smaller one does.

    Turns of r (1 + w/v)^2 are flown in any steady wind; 3 % less is too tight.
    """
    wind = (speed * math.cos(toward), speed * math.sin(toward))
    radius = (1 + speed) ** 2

    assert leaves(circles(radius), wind) < 2e-3
    assert leaves(circles(0.97 * radius), wind) > 5e-3
