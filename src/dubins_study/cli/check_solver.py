"""`dubins-study check-solver`: does a solver keep its promise?

Where it does not, the report tells what to do.
"""

from __future__ import annotations

import json
from typing import Annotated

import typer

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.arguments import Json, Profile, number


def check_solver(
    solver: Annotated[str, typer.Argument(metavar="SOLVER", help="a name, or file.py:Class")],
    check: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="only this check; may be repeated")
    ] = None,
    time_limit: Annotated[
        float,
        typer.Option(metavar="SECONDS", parser=number, help="seconds that a question may take"),
    ] = 5.0,
    total_time_limit: Annotated[
        float,
        typer.Option(metavar="SECONDS", parser=number, help="seconds that all of them may take"),
    ] = 600.0,
    profile: Profile = "default",
    as_json: Json = False,
) -> None:
    """Check a solver of your own.

    Asks 40 to 90 questions, by what the solver answers. Exit code 1 if the solver fails a check.
    """
    from dubins_study.asking.attempt import check_request
    from dubins_study.conformance import CHECKS
    from dubins_study.conformance import check_solver as checked
    from dubins_study.conformance.report import report_text

    check_request("best", time_limit, "--time-limit")
    check_request("best", total_time_limit, "--total-time-limit")
    with output.progress(f"checking {solver}", []) as progress:
        report = checked(
            solver,
            checks=check or CHECKS,
            time_limit=time_limit,
            total_time_limit=total_time_limit,
            profile=profile,
            progress=progress,
        )
    if as_json:
        print(json.dumps(report.to_dict(), indent=2))
    else:
        print(report_text(report, output.terminal_width()))
    raise typer.Exit(int(not report.passed))
