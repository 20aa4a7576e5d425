"""A flight: times and places of an answer's path.

Its points have the names of a mission's points.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from dubins_study.asking.attempt import Answer
from dubins_study.errors import DubinsStudyError
from dubins_study.missions.mission import Mission
from dubins_study.study.path import Path
from dubins_study.study.values import short

_GRAVITY = 9.80665  # m/s**2, the standard one
_MOST_WAYPOINTS = 1_000_000


class FlightError(DubinsStudyError, ValueError):
    """A flight cannot be made or written; says why."""


class Waypoint(NamedTuple):
    """The vehicle at one time.

    `name` is empty between the mission's points.
    """

    time: float  # s
    length: float  # m along the path, or in the points' unit
    x: float
    y: float
    lon: float | None  # degrees; None if the mission does not lie on Earth
    lat: float | None
    heading: float  # rad, counterclockwise from +x, between -pi and pi
    compass: float  # degrees, clockwise from true north, from 0 to 360
    curvature: float  # positive to the left
    altitude: float | None  # m; between two points that have one it rises evenly
    place: int | None = None  # of a stop: its number in the question, from 1
    name: str = ""  # of a stop; its number if it has none


@dataclass(frozen=True)
class Flight:
    """An answer's path beside the mission that it flies.

    Args:
        answer: with a finite path.
        path: of the answer.
        mission: whose points are the answer's stops, in the question's order.
    """

    answer: Answer
    path: Path
    mission: Mission

    @property
    def arrives(self) -> bool:
        """Whether the path is known to pass all points."""
        return self.answer.gap is not None

    @cached_property
    def stops(self) -> list[Waypoint]:
        """The mission's points in the order of passing.

        Empty if the path misses some of them.
        """
        return self._at([length for length, _ in self._passed])

    def waypoints(self, step: float) -> list[Waypoint]:
        """Start, stops and end, with points in between.

        The points between two of them are evenly apart.

        Args:
            step: the most that two neighbours lie apart along the path (m, or the points' unit).

        Raises:
            FlightError: if the step is no positive number, or makes a million points and more.
        """
        total = self.path.length
        if not (step > 0 and total / step < _MOST_WAYPOINTS):
            raise FlightError(
                f"step is {short(step)}; "
                f"expected a length above 0, for less than {_MOST_WAYPOINTS} points"
            )
        marks = [length for length, _ in self._passed]
        if 0.0 not in marks:
            marks.insert(0, 0.0)
        if total not in marks:
            marks.append(total)
        lengths: list[float] = []
        for begin, end in pairwise(marks):
            # 1e-12: rounding alone adds no part
            parts = max(math.ceil((end - begin) / step * (1 - 1e-12)), 1)
            lengths += np.linspace(begin, end, parts, endpoint=False).tolist()
        return self._at([*lengths, marks[-1]])

    @cached_property
    def _passed(self) -> list[tuple[float, int]]:
        """Length and place of each stop, as passed.

        The stops are in the path's order. The length is along the path. The place counts from 0 in
        the question, and the target is the last. Empty if the path does not arrive.
        """
        scenario = self.answer.scenario
        visits = self.answer.visits or []
        if len(visits) < len(scenario.via) or not self.arrives:
            return []
        passed = list(zip(visits, self.answer.order or range(len(visits)), strict=True))
        if scenario.target is not None:
            passed.append((self.path.length, len(scenario.via)))
        return passed

    def _at(self, lengths: Sequence[float]) -> list[Waypoint]:
        """The waypoints at rising lengths along the path.

        Where a length is that of a stop, the waypoint has the stop's number and name.
        """
        x, y, heading = self.path.at(lengths).T
        compass = 0.5 * math.pi - heading
        # for each waypoint longitude, latitude and, on Earth, convergence (rad)
        degrees: Sequence[Sequence[float | None]] = [(None, None)] * len(lengths)
        if self.mission.plane is not None:
            points = np.column_stack((x, y))
            degrees = list(self.mission.plane.on_earth(points))
            compass = compass + [convergence for _, _, convergence in degrees]
        curvatures = self.path.curvature_at(lengths)
        altitudes = self._altitudes(lengths)
        waiting = deque(self._passed)
        waypoints = []
        for i, length in enumerate(lengths):
            waypoint = Waypoint(
                time=length / self.answer.scenario.speed,
                length=length,
                x=float(x[i]),
                y=float(y[i]),
                lon=degrees[i][0],
                lat=degrees[i][1],
                heading=math.remainder(heading[i], math.tau),
                compass=math.degrees(compass[i]) % 360.0,
                curvature=float(curvatures[i]),
                altitude=altitudes[i],
            )
            if waiting and waiting[0][0] == length:
                number = waiting.popleft()[1] + 1
                waypoint = waypoint._replace(place=number, name=self._shown_name(number))
            waypoints.append(waypoint)
        return waypoints

    @property
    def title(self) -> str:
        """Length, time and proof in one line."""
        answer = self.answer
        unit = ""
        if self.mission.plane is not None:
            unit = " m"
        return f"{answer.length:.6g}{unit}, {answer.travel_time:.6g} s, proof: {answer.proof}"

    def _shown_name(self, place: int) -> str:
        default = str(place)
        if place > len(self.mission.points):
            default = "home"
        return self.given_name(place) or default

    def given_name(self, place: int) -> str:
        """The name of a stop, or an empty text.

        `place` is the stop's number in the question, from 1.
        """
        points = self.mission.points
        if place <= len(points):
            return points[place - 1].name
        if self.mission.home:  # a closed path ends at home
            return self.mission.home.name
        return ""

    def _altitudes(self, lengths: Sequence[float]) -> list[float | None]:
        """The altitudes at lengths along the path.

        Between stops that have an altitude it is interpolated, before the first and behind the last
        it stays. All are None if no stop has one.
        """
        points = dict(enumerate(self.mission.points))
        if self.mission.home is not None and not self.mission.above_home:
            # the path starts there, and a closed one ends there
            points |= {-1: self.mission.home, len(points): self.mission.home}
        marks = []
        # place -1 is the start
        for length, place in [(0.0, -1), *self._passed]:
            point = points.get(place)
            if point and point.altitude is not None:
                marks.append((length, point.altitude))
        if not marks:
            return [None] * len(lengths)
        marked_lengths, altitudes = zip(*marks, strict=True)
        interpolated: list[float | None] = np.interp(lengths, marked_lengths, altitudes).tolist()
        return interpolated


def flight_of(answer: Answer, mission: Mission) -> Flight | None:
    """The flight of an answer, or None.

    None means that the answer has no finite path.
    """
    if answer.path is None or answer.length is None:
        return None
    return Flight(answer, answer.path, mission)


def bank_radius(speed: float, bank: float) -> float:
    """The radius (m) of a level turn.

    The radius is v**2 / (g tan bank).

    Args:
        speed: m/s, above 0.
        bank: rad, above 0 and below a quarter turn.

    Raises:
        FlightError: of a speed or a bank outside.
    """
    if not 0 < speed < math.inf:
        raise FlightError(f"speed is {short(speed)}; expected m/s above 0")
    if not 0 < bank < 0.5 * math.pi:
        degrees = f"{math.degrees(bank):.4g}deg"
        raise FlightError(f"bank is {degrees}; expected an angle between 0 and 90deg")
    return speed * speed / (_GRAVITY * math.tan(bank))


def too_tight(radius: float, speed: float, bank: float) -> str | None:
    """A warning if the bank allows no such radius.

    None if the radius is at least that of a level turn with the bank (rad) at the speed (m/s).
    """
    least = bank_radius(speed, bank)
    if radius >= least:
        return None
    return (
        f"the radius {radius:g} m is below {least:.4g} m, which a bank of "
        f"{math.degrees(bank):.4g}deg allows at {speed:g} m/s"
    )
