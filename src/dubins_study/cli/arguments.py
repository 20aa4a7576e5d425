"""Arguments that several commands share: a target, a start pose and a radius."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from dubins_study.errors import DubinsStudyError

if TYPE_CHECKING:
    from dubins_study.study.scenario import Scenario

# A target such as -6 3 must not be read as options. `_check_rest` refuses unknown options.
NEGATIVE_NUMBERS: dict[str, Any] = {"ignore_unknown_options": True, "allow_extra_args": True}

TargetX = Annotated[str, typer.Argument(metavar="X", help="target position")]
TargetY = Annotated[str, typer.Argument(metavar="Y", help="target position")]
StartPose = Annotated[
    tuple[str, str, str],
    typer.Option("--from", metavar="X Y HEADING", help="start pose, e.g. 0 0 120deg"),
]
Radius = Annotated[str, typer.Option(help="minimum turning radius")]


def whole_number(text: str | int) -> int:
    """The value of an option that is a whole number, or its default.

    Raises:
        typer.BadParameter: naming the value and what was expected.
    """
    try:
        if "_" in str(text):  # which Python takes within a number
            raise ValueError
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r:.60}; expected a whole number") from None


def number(text: str | float) -> float:
    """The value of an option that is a number, or its default.

    Raises:
        typer.BadParameter: naming the value and what was expected.
    """
    try:
        return _number("", str(text))
    except CommandError:
        raise typer.BadParameter(f"{text!r:.60}; expected a number") from None


class CommandError(DubinsStudyError, ValueError):
    """The command line cannot be read, or its result cannot be printed or saved."""


def _check_rest(context: typer.Context, target: tuple[str, str]) -> None:
    """Refuse unknown options, and words after the target."""
    rest = context.args
    for word in (*target, *rest):
        if word.startswith("-") and not _is_number(word):
            from dubins_study.study.nearest import did_you_mean

            known = [name for option in context.command.params for name in option.opts]
            near = did_you_mean(word.partition("=")[0], known)
            raise CommandError(
                f"no such option: {word}; {near}see dubins-study {context.info_name} --help"
            )
    if rest:
        raise CommandError(
            f"unexpected argument {rest[0]!r}; expected a target of two numbers, X Y"
        )


def _is_number(text: str) -> bool:
    try:
        _number("", text)
    except CommandError:
        return False
    return True


def scenario_of(
    context: typer.Context,
    target: tuple[str, str],
    start: tuple[str, str, str],
    radius: str,
    speed: str = "1",
) -> Scenario:
    """A scenario from the texts of the command line.

    Raises:
        CommandError, AngleError, ScenarioError: naming the field, its value and what was expected,
            or naming the first unknown option or the first word after the target.
    """
    from dubins_study.study.angle import AngleError, parse_angle
    from dubins_study.study.scenario import Scenario

    _check_rest(context, target)
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
    from dubins_study.study.printable import short

    try:
        if "_" in text:  # which Python takes within a number
            raise ValueError
        return float(text)
    except ValueError:
        raise CommandError(f"{name} is {short(text)}; expected a number") from None
