"""Arguments and options of the commands, each declared once, and their texts as values."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.cli.terminal import completion
from dubins_study.cli.terminal.refusals import CommandError, is_number

if TYPE_CHECKING:
    from dubins_study.study.scenario import Scenario

# A target such as -6 3 must not be read as options. `terminal.refusals` refuses unknown options.
NEGATIVE_NUMBERS: dict[str, Any] = {"ignore_unknown_options": True}


def whole_number(text: str | int) -> int:
    """The value of an option that is a whole number, or its default.

    Raises:
        typer.BadParameter: naming the value and what was expected.
    """
    try:
        if not is_number(str(text)):
            raise ValueError
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r:.60}; expected a whole number") from None


def number(text: str | float) -> float:
    """The value of an option that is a number, or its default.

    Raises:
        typer.BadParameter: naming the value and what was expected.
    """
    if not is_number(str(text)):
        raise typer.BadParameter(f"{text!r:.60}; expected a number")
    return float(text)


# the question of a solve
TargetX = Annotated[str, typer.Argument(metavar="X", help="target position")]
TargetY = Annotated[str, typer.Argument(metavar="Y", help="target position")]
StartPose = Annotated[
    tuple[str, str, str],
    typer.Option("--from", metavar="X Y HEADING", help="start pose, e.g. 0 0 120deg"),
]
Radius = Annotated[str, typer.Option(metavar="NUMBER", help="minimum turning radius")]
Speed = Annotated[str, typer.Option(metavar="NUMBER", help="constant speed")]
Branch = Annotated[
    str,
    typer.Option(metavar="NAME", help="best, LS, RS, LR or RL", autocompletion=completion.branches),
]
# who answers, and within which limits
Spec = Annotated[
    str,
    typer.Option(
        "--solver",
        metavar="SPEC",
        help="name, name[setting=value] or file.py:Class",
        autocompletion=completion.solvers,
    ),
]
Specs = Annotated[
    list[str] | None,
    typer.Option(
        "--solver",
        metavar="SPEC",
        help="instead of the experiment's own; may be given several times",
        autocompletion=completion.solvers,
    ),
]
Profile = Annotated[
    str,
    typer.Option(
        metavar="NAME", help="default, fast or accurate", autocompletion=completion.profiles
    ),
]
SolveLimit = Annotated[
    float,
    typer.Option(
        "--time-limit", metavar="SECONDS", parser=number, help="seconds that the solve may take"
    ),
]
# a run
Experiment = Annotated[
    str | None,
    typer.Argument(
        metavar="EXPERIMENT",
        help="a name, or the path of a .toml file; optional with --scenarios",
        autocompletion=completion.experiments,
    ),
]
Scenarios = Annotated[
    FilePath | None,
    typer.Option(metavar="FILE", help="ask about these: .csv or .parquet, a row a scenario"),
]
ResultsFolder = Annotated[
    FilePath | None,
    typer.Option("--out", metavar="DIR", help="default: results/<experiment or file>"),
]
Jobs = Annotated[
    int,
    typer.Option(metavar="N", parser=whole_number, help="processes; 1 where times are quoted"),
]
CellLimit = Annotated[
    float | None,
    typer.Option(
        "--time-limit",
        metavar="SECONDS",
        parser=number,
        help="seconds after which a solve is ended",
    ),
]
MemoryLimit = Annotated[
    float | None, typer.Option(metavar="GIB", parser=number, help="GiB that a solve may hold")
]
Repeats = Annotated[
    int | None, typer.Option(metavar="N", parser=whole_number, help="attempts per cell")
]
Restart = Annotated[bool, typer.Option("--restart", help="throw away earlier rows")]
TrustPlugins = Annotated[
    bool, typer.Option("--trust-plugins", help="the experiment may name plug-ins and programs")
]
Engine = Annotated[str, typer.Option(metavar="NAME", help="local, or dask")]
Scheduler = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="of Dask's; default: one on this machine")
]
# what is printed and drawn
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]
StatusJson = Annotated[
    bool, typer.Option("--json", help="print the folder's status as one JSON object")
]
Plot = Annotated[
    FilePath | None, typer.Option(metavar="FILE", help="draw the path: .svg, .pdf or .png")
]
Strict = Annotated[bool, typer.Option("--strict", help="exit code 1 unless the verdict is optimal")]


def scenario_of(
    target: tuple[str, str],
    start: tuple[str, str, str],
    radius: str,
    speed: str = "1",
) -> Scenario:
    """A scenario from the texts of the command line.

    Raises:
        CommandError, AngleError, ScenarioError: naming the field, its value and what was expected.
    """
    from dubins_study.study.angle import AngleError, parse_angle
    from dubins_study.study.scenario import Scenario

    try:
        heading = parse_angle(start[2])
    except AngleError as error:
        raise AngleError(f"heading: {error}") from None
    return Scenario(
        x=_number("x", start[0]),
        y=_number("y", start[1]),
        heading=heading,
        target_x=_number("target_x", target[0]),
        target_y=_number("target_y", target[1]),
        radius=_number("radius", radius),
        speed=_number("speed", speed),
    )


def _number(name: str, text: str) -> float:
    if not is_number(text):
        from dubins_study.study.values import short

        raise CommandError(f"{name} is {short(text)}; expected a number")
    return float(text)
