"""One leg with a given final heading.

It is answered by the closed form of six words.
"""

from __future__ import annotations

from functools import lru_cache, partial

from dubins_study.study.check.enclosure import Enclosure, Part, enclose_pose
from dubins_study.study.check.extremal import measure
from dubins_study.study.check.verdict import words_of
from dubins_study.study.closed_form.pose import pose_path
from dubins_study.study.kinds import visiting
from dubins_study.study.kinds.kind import Costates, Exact, Kind, Reference
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import FINAL_HEADING, POSE_BRANCHES

_EVERYWHERE = ("best", "LSL", "RSR")  # branches with a path to every pose


def _end(scenario: Scenario) -> Pose:
    x, y, heading = scenario.stops[-1]
    assert heading is not None
    return Pose(x, y, heading)


def _exact(scenario: Scenario, branch: str, limit: float) -> Exact:
    return Exact.known(pose_path(scenario.start, _end(scenario), scenario.radius, branch))


def _exists(scenario: Scenario, branch: str) -> bool:
    return branch in _EVERYWHERE


def _reference(scenario: Scenario, branch: str, tolerances: Tolerances) -> Reference:
    return _of_poses(scenario.start, _end(scenario), scenario.radius, branch)


@lru_cache(maxsize=4096)  # asked for when an answer is judged and when it is certified
def _of_poses(start: Pose, end: Pose, radius: float, branch: str) -> Reference:
    question = start, end, radius, branch
    return Reference(enclose_pose(*question), pose_path(*question), ())


def _nearest(enclosure: Enclosure, length: float, tolerance: float) -> Part:
    """Shortest length nearest to the path's, twice.

    The shortest lengths are those for all data within delta. The reference is one number, so that
    it is both the shortest and the longest length that the reference may have.
    """
    nearest = enclosure.nearest(length, tolerance)
    assert nearest is not None  # one exists
    return nearest, nearest


def _costates(scenario: Scenario, path: Path, judgement: Judgement, until: float) -> Costates:
    if judgement.gap is None:
        return Costates()
    return Costates(*measure(path, scenario.radius, free=False))


POSE = Kind(
    name="pose",
    title="one leg with a given final heading",
    task="targets with a final heading",
    fields={"searched": False, "final_heading": True},
    branches=POSE_BRANCHES,
    # without names: x, y, heading, target_x, target_y, radius, speed
    examples={
        "to a heading, far": Scenario(target_x=6, target_y=-3, final_heading=2.0),
        "to a heading, all at once": Scenario(2, -1, 0.8, -7, 4, 2.5, 3, final_heading=-1.2),
        "to a heading, near": Scenario(1, 2, -0.6, 1.7, 2.5, 0.4, 3, final_heading=2.4),
        "to a heading, three arcs": Scenario(target_x=0.3, target_y=1.1, final_heading=3.0),
    },
    exact=_exact,
    exists=_exists,
    reference=_reference,
    words_of=words_of,
    verdict=partial(visiting.verdict, reference_of=_reference, compared=_nearest),
    costates=_costates,
    need_of_rows=FINAL_HEADING,
)
