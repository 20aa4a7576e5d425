"""A mission: points to pass, with their names.

A file or a caller gives them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from dubins_study.errors import DubinsStudyError
from dubins_study.study.scenario import Scenario
from dubins_study.study.tangent_plane import TangentPlane


class MissionError(DubinsStudyError):
    """A mission or its file is not usable.

    The message names the file, the line or item, and the rule.
    """


class MissionPoint(NamedTuple):
    """A point of a mission.

    If a file does not tell a value, it is None, or an empty name.
    """

    x: float  # m to the east where the mission lies on Earth, else any unit of length
    y: float  # to the north
    heading: float | None = None  # rad, counterclockwise from +x; None is free
    name: str = ""
    altitude: float | None = None  # m, as the file has it
    speed: float | None = None  # m/s, as the file has it
    where: str = ""  # in the file, such as `line 7`


@dataclass(frozen=True)
class Mission:
    """Points to pass, in their order.

    Args:
        points: via points, then the target where there is one.
        home: where the path starts; None if at the first of the points.
        plane: what x and y are metres on; None if the points do not lie on Earth.
        source: the format's name, such as `GPX`; empty if it came from no file.
        notes: sentences about what was passed over or understood.
        warnings: sentences about what is doubtful.
    """

    points: tuple[MissionPoint, ...]
    home: MissionPoint | None = None
    plane: TangentPlane | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    speed: float | None = None  # m/s, of the whole mission, as the file has it

    @property
    def above_home(self) -> bool:
        """Whether altitudes are above home, as in plans.

        Otherwise they are above the sea.
        """
        return self.source in ("QGroundControl plan", "QGC WPL 110")

    def started(self) -> Mission:
        """The mission with a home.

        If it has none, its first point becomes the home.
        """
        if self.home is not None:
            return self
        if not self.points:
            raise MissionError("the mission has no points")
        return replace(self, home=self.points[0], points=self.points[1:])

    def scenario(self, *, to_last: bool = True, **fields: Any) -> Scenario:
        """The scenario from home past the points.

        Args:
            to_last: whether the last point is the target; else all points are via points, of a
                closed path or one that may end at any of them.
            fields: the other fields of a scenario, such as the radius.

        Raises:
            MissionError: if there is no point beside where it starts.
            ScenarioError: as a scenario.
        """
        mission = self.started()
        home = mission.home
        assert home is not None
        if to_last and not mission.points:
            raise MissionError("the mission has one point; expected one to start at, and others")
        via = mission.points
        if to_last:
            via = mission.points[:-1]
            last = mission.points[-1]
            fields.setdefault("final_heading", last.heading)
            fields |= {"target_x": last.x, "target_y": last.y}
        return Scenario(
            home.x,
            home.y,
            home.heading,
            via=[(point.x, point.y, point.heading) for point in via],
            _radians=True,
            **fields,
        )
