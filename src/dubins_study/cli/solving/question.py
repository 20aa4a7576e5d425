"""The command line's words as a mission and scenario."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import CommandError, Point, StopHeading, start_pose

if TYPE_CHECKING:
    from dubins_study.missions.mission import Mission, MissionPoint
    from dubins_study.study.scenario import Scenario

_FAR = 500_000.0  # m from the middle of the points


class Words(NamedTuple):
    """The question, as the command line says it."""

    target: float | FilePath | None  # x, or a mission file
    y: float | None
    start: tuple[str, str, str] | None
    via: Sequence[Point]
    via_file: FilePath | None
    via_headings: Sequence[StopHeading]
    order: str
    closed: bool
    final_heading: str | None
    radius: float | None
    speed: float | None
    bank: str | None
    columns: str | None
    compass: bool
    drop_repeats: bool

    @property
    def to_last(self) -> bool:
        """Whether the last point is the target."""
        from dubins_study.study.words import Order

        ends_anywhere = self.order == Order.FREE and not isinstance(self.target, float)
        return not self.closed and not ends_anywhere


class Asked(NamedTuple):
    """A mission with a home, and its scenario."""

    mission: Mission
    scenario: Scenario

    @property
    def names(self) -> list[str]:
        """A name for each stop; some may be empty.

        The names have the order of the question, from the first via point on.
        """
        return [point.name for point in self.mission.points]


def question_of(words: Words) -> Asked:
    """The question of a command line.

    Every refusal names the option.
    """
    from dubins_study.study.scenario import checked_order

    checked_order(words.order)
    mission = _with_headings(_mission(words), words)
    fields: dict[str, Any] = {}
    if words.final_heading is not None:
        end = mission.home
        if words.to_last:
            end = mission.points[-1]
            if end.heading is not None:
                raise CommandError(
                    "the last point has a heading, and --final-heading is given; "
                    "expected one of them"
                )
        assert end is not None
        last = _with_heading(end, mission, "final_heading", words.final_heading, words.compass)
        fields["final_heading"] = last.heading
    speed = words.speed
    if speed is None:
        speed = mission.speed
    if speed is not None:
        fields["speed"] = speed
    scenario = mission.scenario(
        to_last=words.to_last,
        radius=_radius(words, mission, speed),
        order=words.order,
        closed=words.closed,
        **fields,
    )
    return Asked(mission, scenario)


def _mission(words: Words) -> Mission:
    """The mission of the command line, with its home.

    Points come from a mission file, or from X Y, --via and --via-file. The home is --from; without
    it, the home or first point of the file, else the origin.
    """
    from dubins_study.missions.mission import Mission

    if isinstance(words.target, FilePath):
        mission = _file_mission(words.target, words)
        if words.start is None:
            mission = mission.started()
            if words.to_last and not mission.points:
                raise CommandError(f"{words.target} has one point; expected a start, and others")
            return mission
    else:
        _refuse_unread(words)
        mission = Mission(tuple(_points(words)))
    return replace(mission, home=_start(words.start or ("0", "0", "0"), mission, words.compass))


def _refuse_unread(words: Words) -> None:
    """Refuse options that only mission files use."""
    options = {"--columns": words.columns, "--drop-repeats": words.drop_repeats}
    for option, value in options.items():
        if value:
            raise CommandError(f"{option} is given without a mission file; expected one, not X Y")


def _file_mission(file: FilePath, words: Words) -> Mission:
    from dubins_study.missions.read import read_mission

    if words.y is not None or words.via or words.via_file:
        raise CommandError(
            f"{file} is a mission file, and Y, --via or --via-file is given; "
            "expected the file alone"
        )
    columns = None
    if words.columns is not None:
        columns = words.columns.split(",")
    return read_mission(
        file,
        columns=columns,
        compass=words.compass,
        drop_repeats=words.drop_repeats,
        closed=words.closed,
    )


def _points(words: Words) -> list[MissionPoint]:
    """Via points and, if there is one, the target.

    `--via-file` may have all of them.
    """
    from dubins_study.missions.mission import MissionPoint
    from dubins_study.missions.table import read_points

    x = words.target
    y = words.y
    if words.via and words.via_file is not None:
        raise CommandError("--via and --via-file are given; expected one of them")
    if y is not None and words.closed:
        raise CommandError("X Y and --closed are given; a closed path ends at its start")
    missing = x is None and words.via_file is None and words.to_last
    if missing or (x is not None and y is None):
        # of `--from 0 0 1 2` the third number is the heading
        raise CommandError(
            "the target is missing, or a single number; expected X Y, or --via-file; "
            "--from takes X Y HEADING"
        )
    points = [MissionPoint(*each) for each in words.via]
    if words.via_file is not None:
        points += read_points(words.via_file)
    if isinstance(x, float) and y is not None:
        points.append(MissionPoint(x, y))
    return points


def _start(pose: tuple[str, str, str], mission: Mission, compass: bool) -> MissionPoint:
    """The start pose.

    For a mission on Earth it is longitude, latitude and heading.
    """
    from dubins_study.missions.mission import MissionPoint
    from dubins_study.study.tangent_plane import check_place

    x, y, heading = start_pose(pose)
    if mission.plane is not None:
        check_place(x, y)
        x, y = mission.plane.to_plane([x, y])[0].tolist()
        away = math.hypot(x, y)
        if away > _FAR:
            output.note(f"--from is {away / 1000:.0f} km from the points; it takes LON LAT HEADING")
    return _with_heading(MissionPoint(x, y), mission, "heading", heading, compass)


def _with_heading(
    point: MissionPoint, mission: Mission, name: str, text: str, compass: bool
) -> MissionPoint:
    """The point with the heading of a text.

    On Earth, the text counts from the point's true east or north, and the heading from the plane's
    +x. `name` stands for the option in refusals.
    """
    heading = _heading(name, text, compass)
    if heading is not None and mission.plane is not None:
        heading += float(mission.plane.convergence(point[:2])[0])
    return point._replace(heading=heading)


def _with_headings(mission: Mission, words: Words) -> Mission:
    """The mission with the given headings at via points."""
    points = list(mission.points)
    count = len(points) - words.to_last
    for place, text in words.via_headings:
        if not 1 <= place <= count:
            expected = "there is no via point"
            if count:
                expected = f"expected one from 1 to {count}"
            raise CommandError(f"--via-heading: place {place}; {expected}")
        if points[place - 1].heading is not None:
            raise CommandError(f"--via-heading: via point {place} has two headings; expected one")
        points[place - 1] = _with_heading(
            points[place - 1], mission, "--via-heading", text, words.compass
        )
    return replace(mission, points=tuple(points))


def _heading(name: str, text: str, compass: bool) -> float | None:
    """The heading (rad) of a word; None if free.

    The heading is counterclockwise from +x. With `compass` the word is read as clockwise from
    north. `name` stands for the option in refusals.
    """
    from dubins_study.missions.reading import heading_of
    from dubins_study.study.angle import AngleError
    from dubins_study.study.scenario import CONVENTION, FREE

    if text == FREE:
        return None
    try:
        return heading_of(text, compass)
    except AngleError as error:
        convention = CONVENTION
        if compass:
            convention = "clockwise from north"
        raise CommandError(f"{name}: {error}, {convention}") from None


def _radius(words: Words, mission: Mission, speed: float | None) -> float:
    """The turning radius, given or from a bank.

    The bank and the speed give a radius. If --radius is given too, it counts; a note is printed if
    it is too small for the bank.
    """
    from dubins_study.missions.flight import bank_radius, too_tight
    from dubins_study.study.angle import parse_angle

    if words.bank is None:
        if words.radius is not None:
            return words.radius
        if mission.plane is None:
            return 1.0
        raise CommandError(
            "the radius is missing: the points lie on Earth; "
            "expected --radius in m, or --speed and --bank"
        )
    if speed is None:
        raise CommandError("--bank is given without --speed; expected both, such as 20 and 30deg")
    bank = parse_angle(words.bank)
    if words.radius is None:
        radius = bank_radius(speed, bank)
        output.note(f"the radius is {radius:.6g}: a bank of {words.bank} at {speed:g} m/s")
        return radius
    warning = too_tight(words.radius, speed, bank)
    if warning:
        output.note(warning)
    return words.radius
