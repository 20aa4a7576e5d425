"""Arguments and options of the commands.

Each is declared once, with the function that makes a value of its text.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Annotated, Any, NamedTuple

import typer

from dubins_study.errors import DubinsStudyError


class CommandError(DubinsStudyError, ValueError):
    """The command line or its result is refused.

    The line cannot be read, or its result cannot be printed or saved.
    """


def number(text: str | float) -> float:
    """A word of the command line as a number."""
    from dubins_study.study.values import number_of_text  # numpy, which no help waits for

    try:
        return number_of_text(str(text))
    except ValueError:
        raise typer.BadParameter(f"{text!r:.60}; expected a number") from None


def number_or_file(text: str) -> float | FilePath:
    """A word as a number, else as a file.

    The file must exist; any other word is refused.
    """
    try:
        return number(text)
    except typer.BadParameter:
        if FilePath(text).exists():
            return FilePath(text)
        raise typer.BadParameter(f"{text!r:.60} is no number, and no such file is there") from None


class Point(NamedTuple):
    """x and y of a point."""

    x: float
    y: float


# The options that take two words: typer knows no list of pairs.
PAIRS = ("via", "via_headings")


def point(words: Sequence[str] | Point) -> Point:
    """The point of an option's two words."""
    x, y = words
    return Point(number(x), number(y))


class StopHeading(NamedTuple):
    """A heading at a via point.

    The place counts from 1 in the order of the points; the angle is as written.
    """

    place: int
    heading: str


def stop_heading(words: Sequence[str] | StopHeading) -> StopHeading:
    """The heading of the two words of `--via-heading`."""
    place, heading = words
    try:
        return StopHeading(int(place), str(heading))
    except ValueError:
        expected = "expected the number of a via point, from 1 on, and a heading"
        raise typer.BadParameter(f"{place!r:.60}; {expected}") from None


# the question of a solve
TargetX = Annotated[float, typer.Argument(metavar="X", parser=number, help="target position")]
TargetY = Annotated[float, typer.Argument(metavar="Y", parser=number, help="target position")]
_OR_LAST = "target position; default: the last point of --via-file, none with --order free"
_OR_FILE = f"{_OR_LAST}. Alone it is a mission file: CSV, GPX, KML, GeoJSON, .plan, .waypoints"
TargetOrFile = Annotated[
    Any,  # a number or a file; typer knows no union
    typer.Argument(metavar="X", parser=number_or_file, help=_OR_FILE, show_default=False),
]
MaybeY = Annotated[
    float | None, typer.Argument(metavar="Y", parser=number, help=_OR_LAST, show_default=False)
]
_FROM = (
    "start pose, e.g. 0 0 120deg, or 0 0 2.1 in rad, or 0 0 free; headings run counterclockwise "
    "from +x (east), so north is 90deg"
)
StartPose = Annotated[
    tuple[str, str, str],
    typer.Option("--from", metavar="X Y HEADING", help=_FROM),
]
_FROM_OR_HOME = f"{_FROM}; of a mission file the default is its home, or its first point"
StartOrHome = Annotated[
    tuple[str, str, str] | None,
    typer.Option("--from", metavar="X Y HEADING", help=_FROM_OR_HOME, show_default=False),
]
_COLUMNS = "what the columns of a CSV file are, e.g. lon,lat,-,name; - is passed over"
Columns = Annotated[str | None, typer.Option(metavar="NAMES", help=_COLUMNS)]
Compass = Annotated[
    bool, typer.Option("--compass", help="headings run clockwise from north, in degrees")
]
DropRepeats = Annotated[
    bool, typer.Option("--drop-repeats", help="leave out points equal to the one before")
]
_VIA = "point to pass on the way; repeat it for several, in order"
Via = Annotated[list[Point], typer.Option("--via", metavar="X Y", parser=point, help=_VIA)]
ViaFile = Annotated[
    FilePath | None,
    typer.Option(
        metavar="CSV", help="points to pass on the way: columns x, y, maybe name and heading"
    ),
]
_VIA_HEADING = "heading at a via point, e.g. 2 90deg at the second; repeat it for several"
ViaHeadings = Annotated[
    list[StopHeading],
    typer.Option("--via-heading", metavar="PLACE HEADING", parser=stop_heading, help=_VIA_HEADING),
]
_ORDER = (
    "of the via points: given, or free for the shortest of all orders; without X Y a free order "
    "ends at whichever point comes last. The given order is solved too, in a tenth of the limit"
)
OrderOfVia = Annotated[str, typer.Option("--order", metavar="NAME", help=_ORDER)]
Closed = Annotated[
    bool, typer.Option("--closed", help="end at the start, with the heading there; no X Y")
]
FinalHeading = Annotated[
    str | None,
    typer.Option(metavar="HEADING", help="heading at the target, e.g. 90deg; default: free"),
]
Radius = Annotated[
    float, typer.Option(metavar="NUMBER", parser=number, help="minimum turning radius")
]
_RADIUS = "minimum turning radius, in m for a mission on Earth; default: 1, or that of --bank"
RadiusOrBank = Annotated[
    float | None,
    typer.Option("--radius", metavar="NUMBER", parser=number, help=_RADIUS, show_default=False),
]
_SPEED = "constant speed, m/s of a mission on Earth. Default: 1"
SpeedOrNone = Annotated[
    float | None,
    typer.Option("--speed", metavar="NUMBER", parser=number, help=_SPEED, show_default=False),
]
_BANK = "bank angle of a turn, e.g. 30deg: with --speed in m/s it gives the radius in m"
Bank = Annotated[str | None, typer.Option(metavar="ANGLE", help=_BANK)]
_BRANCH = "best, LS, RS, LR or RL; with a final heading best, LSL, RSR, LSR, RSL, RLR or LRL"
Branch = Annotated[str, typer.Option(metavar="NAME", help=_BRANCH)]
# who answers
_SPEC = "name, name[setting=value] or file.py:Class"
Spec = Annotated[str, typer.Option("--solver", metavar="SPEC", help=_SPEC)]
Profile = Annotated[str, typer.Option(metavar="NAME", help="default, fast or accurate")]
_LIMIT = "seconds that the solve may take"
TimeLimit = Annotated[float, typer.Option(metavar="SECONDS", parser=number, help=_LIMIT)]
# what is printed and written
_PLOT = "draw the path: .svg, .pdf or .png"
Plot = Annotated[FilePath | None, typer.Option(metavar="FILE", help=_PLOT)]
_GEOJSON = "write path and points as GeoJSON, in their x and y"
Geojson = Annotated[FilePath | None, typer.Option(metavar="FILE", help=_GEOJSON)]
_OUT = "write the flight: .geojson, .gpx, .kml, .plan, .waypoints or .csv; repeat it for several"
Out = Annotated[list[FilePath], typer.Option("--out", metavar="FILE", help=_OUT)]
_STEP = "distance from waypoint to waypoint of --out; default: a quarter of the radius"
Step = Annotated[float | None, typer.Option(metavar="NUMBER", parser=number, help=_STEP)]
_ALTITUDE = "m above home of waypoints whose points have none, in .plan and .waypoints"
Altitude = Annotated[float, typer.Option(metavar="NUMBER", parser=number, help=_ALTITUDE)]
_SHORTEST = "draw and write the check's path where it is shorter than the answer"
Shortest = Annotated[bool, typer.Option("--shortest", help=_SHORTEST)]
_STRICT = "exit code 1 unless the verdict is optimal"
Strict = Annotated[bool, typer.Option("--strict", help=_STRICT)]
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]


def start_pose(start: tuple[str, str, str]) -> tuple[float, float, str]:
    """The words of `--from`, as two numbers and heading.

    The heading stays as it is written.
    """
    try:
        return number(start[0]), number(start[1]), start[2]
    except typer.BadParameter:
        expected = "expected two numbers and a heading"
        raise CommandError(f"--from is {' '.join(start)!r:.60}; {expected}") from None
