"""Arguments and options of the commands, each declared once, and their texts as values."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from dubins_study.errors import DubinsStudyError

if TYPE_CHECKING:
    from dubins_study.study.scenario import Scenario


class CommandError(DubinsStudyError, ValueError):
    """The command line cannot be read, or its result cannot be printed or saved."""


def number(text: str | float) -> float:
    """The number that a word is."""
    from dubins_study.study.values import number_of_text  # numpy, which no help waits for

    try:
        return number_of_text(str(text))
    except ValueError:
        raise typer.BadParameter(f"{text!r:.60}; expected a number") from None


class Point(NamedTuple):
    """x and y of a point."""

    x: float
    y: float


# The options that take two words: typer knows no list of pairs.
PAIRS = ("via", "via_headings")


def point(words: Sequence[str] | Point) -> Point:
    """The value of an option that is a point."""
    x, y = words
    return Point(number(x), number(y))


class StopHeading(NamedTuple):
    """A heading at a via point: its place in their order, from 1 on, and the angle as written."""

    place: int
    heading: str


def stop_heading(words: Sequence[str] | StopHeading) -> StopHeading:
    """The value of an option that is a heading at a via point."""
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
MaybeX = Annotated[
    float | None, typer.Argument(metavar="X", parser=number, help=_OR_LAST, show_default=False)
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
Speed = Annotated[float, typer.Option(metavar="NUMBER", parser=number, help="constant speed")]
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
_SHORTEST = "draw and write the check's path where it is shorter than the answer"
Shortest = Annotated[bool, typer.Option("--shortest", help=_SHORTEST)]
_STRICT = "exit code 1 unless the verdict is optimal"
Strict = Annotated[bool, typer.Option("--strict", help=_STRICT)]
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]


def scenario_of(
    x: float | None,
    y: float | None,
    start: tuple[str, str, str],
    radius: float,
    speed: float = 1.0,
    **rest: Any,
) -> Scenario:
    """A scenario from the words of the command line; every refusal names the field.

    `rest` has the other fields of a scenario.
    """
    from dubins_study.study.scenario import Scenario

    try:
        pose = number(start[0]), number(start[1]), start[2]
    except typer.BadParameter:
        expected = "expected two numbers and a heading"
        raise CommandError(f"--from is {' '.join(start)!r:.60}; {expected}") from None
    return Scenario(*pose, x, y, radius, speed, **rest)
