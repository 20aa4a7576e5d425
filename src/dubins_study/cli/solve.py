"""`dubins-study solve`: one scenario, solved and judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import typer

from dubins_study.cli.solving.answer_text import answer_json, answer_text
from dubins_study.cli.solving.files import Files
from dubins_study.cli.solving.question import Words, question_of
from dubins_study.cli.terminal import arguments, output
from dubins_study.cli.terminal.output import plain
from dubins_study.study.words import Order, Outcome

if TYPE_CHECKING:
    from dubins_study.asking.attempt import Answer
    from dubins_study.missions.flight import Flight
    from dubins_study.study.scenario import Scenario

# Share of the limit for a tour's points in their given order. A good path of thousands of points
# takes a second; the proof that it is the shortest is for `--order given`.
_COMPARED = 0.1


def solve(
    x: arguments.TargetOrFile = None,
    y: arguments.MaybeY = None,
    start: arguments.StartOrHome = None,
    via: arguments.Via = [],  # noqa: B006  typer makes a new one
    via_file: arguments.ViaFile = None,
    via_headings: arguments.ViaHeadings = [],  # noqa: B006
    order: arguments.OrderOfVia = "given",
    closed: arguments.Closed = False,
    final_heading: arguments.FinalHeading = None,
    radius: arguments.RadiusOrBank = None,
    speed: arguments.SpeedOrNone = None,
    bank: arguments.Bank = None,
    columns: arguments.Columns = None,
    compass: arguments.Compass = False,
    drop_repeats: arguments.DropRepeats = False,
    solver: arguments.Spec = "analytic",
    branch: arguments.Branch = "best",
    profile: arguments.Profile = "default",
    time_limit: arguments.TimeLimit = 60.0,
    as_json: arguments.Json = False,
    plot: arguments.Plot = None,
    geojson: arguments.Geojson = None,
    out: arguments.Out = [],  # noqa: B006
    step: arguments.Step = None,
    altitude: arguments.Altitude = 50.0,
    shortest: arguments.Shortest = False,
    strict: arguments.Strict = False,
) -> None:
    """Solve one scenario and judge the answer."""
    from dubins_study.asking.attempt import check_request, shorter_answer
    from dubins_study.missions.flight import flight_of

    words = Words(
        target=x,  # a number, or a file
        y=y,
        start=start,
        via=via,
        via_file=via_file,
        via_headings=via_headings,
        order=order,
        closed=closed,
        final_heading=final_heading,
        radius=radius,
        speed=speed,
        bank=bank,
        columns=columns,
        compass=compass,
        drop_repeats=drop_repeats,
    )
    question = question_of(words)
    for note in question.mission.notes:
        output.note(note, always=False)
    check_request(branch, time_limit, "--time-limit")
    files = Files(plot=plot, geojson=geojson, out=out, step=step, altitude=altitude)
    files.check(question.mission, [x, via_file])
    answer, in_given_order = _answers(
        question.scenario, solver, branch=branch, profile=profile, limit=time_limit
    )
    flight = flight_of(answer, question.mission)
    _print(answer, question.names, in_given_order, flight, as_json)
    if shortest:
        flight = flight_of(shorter_answer(answer) or answer, question.mission)
    complete = files.write(flight, question.names)
    ended = complete and answer.outcome == Outcome.RETURNED
    if not ended or (strict and answer.verdict != "optimal"):
        raise typer.Exit(1)


def _answers(
    scenario: Scenario, solver: str, branch: str, profile: str, limit: float
) -> tuple[Answer, Answer | None]:
    """The answer, and a tour's in the given order.

    The second answer is the shortest route through a tour's points in the order in which they are
    given; None if the question is no tour, or its answer has no order.
    """
    from dubins_study.experiments.solve import solve as ask
    from dubins_study.study.tolerances import SEARCH_S

    compared_s = 0.0
    if scenario.order is Order.FREE:
        compared_s = _COMPARED * limit
    at_most = limit + min(limit, SEARCH_S) + compared_s
    with output.solvers_to_stderr(), output.steps(f"solving, at most {at_most:g} s"):
        answer = ask(scenario, solver, branch, profile=profile, limit=limit, isolated=True)
        if answer.order is None:
            return answer, None
        return answer, ask(_route_of(scenario), limit=compared_s, isolated=True)


def _print(
    answer: Answer,
    names: Sequence[str],
    in_given_order: Answer | None,
    flight: Flight | None,
    as_json: bool,
) -> None:
    """Print an answer, or refuse the request.

    The request is refused if no solver was asked for the answer.
    """
    refused = answer.outcome in (Outcome.UNAVAILABLE, Outcome.UNSUPPORTED)
    # flushed before the drawing, which may fail
    if as_json:
        print(answer_json(answer, names, in_given_order, flight), flush=True)
    elif not refused:
        print(answer_text(answer, names, in_given_order, flight), flush=True)
    if refused:
        message = f"solver {answer.solver!r} is {answer.outcome}: {plain(answer.message)}"
        raise arguments.CommandError(message)


def _route_of(scenario: Scenario) -> Scenario:
    """A tour's question with its order given.

    If the tour may end at any point, the route ends at the last one.
    """
    changed: dict[str, Any] = {"order": "given"}
    if scenario.target is None:
        x, y, heading = scenario.stops[-1]
        changed["via"] = scenario.via[:-1]
        changed |= {"target_x": x, "target_y": y, "final_heading": heading}
    return replace(scenario, **changed)
