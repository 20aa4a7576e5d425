"""Compute what the paper's algorithm returns, and whether the paper's statements hold."""

from __future__ import annotations

from decimal import Decimal
from typing import Any, NamedTuple

from flint import arb

from dubins_study.report.paper.exact import (
    NIL,
    Target,
    ball,
    decide,
    heading,
    left_straight,
    offset,
    pieces,
    positive,
    target,
    text,
)
from dubins_study.report.paper.printed import PROBLEMS, Problem
from dubins_study.study.check.enclosure import right_left_solutions

Record = dict[str, Any]
_WORDS = ("LS", "RS")


def algorithm() -> list[Record]:
    """Algorithm 1 on each test problem, at radii at which a turning circle reaches the target.

    A turning circle passes through the target at the radius R* = r^2 / (2 |Y|); r is the target's
    distance and Y its offset from the start's heading line. For larger radii the optimum begins
    with a turn away from the target (RL in the left disc, LR in the right disc). Of the algorithm's
    two words, only the one that begins with this turn then exists. The unsplit model (4.12)
    contains LR too, so it is right in the right disc, but it does not contain RL.
    """
    positions = {problem.position: problem for problem in PROBLEMS.values()}
    return [_crossing(position, problem) for position, problem in positions.items()]


def _crossing(position: str, problem: Problem) -> Record:
    unit = target(problem, arb(1))
    left = positive(unit.Y)
    circle = (unit.X**2 + unit.Y**2) / (2 * abs(unit.Y))
    near = _beside(problem, circle, left)
    arc = arb.atan2(near.X, 1 - near.Y)
    front = positive(near.X)
    optimum, algorithm = _beyond(near)
    round_radius = _rounded_up(circle)
    there, algorithm_there = _beyond(_beside(problem, ball(round_radius), left))
    excess = float(algorithm / optimum - 1)
    return {
        "label": position,
        "circle": "left" if left else "right",
        "half": "front" if front else "rear",
        "radius": text(circle),
        "length_there": float((arc if front else arc + 2 * arb.pi()) * circle),
        "word_beyond": "RL" if left else "LR",
        "length_beyond": float(optimum * circle),
        "algorithm_word": "RS" if left else "LS",
        "algorithm_length": float(algorithm * circle),
        "algorithm_excess": excess,
        "model_excess": excess if left else 0.0,
        "example_radius": round_radius,
        "example_length": float(there * round_radius),
        "example_algorithm_length": float(algorithm_there * round_radius),
        "example_excess": float(algorithm_there / there - 1),
    }


def _beside(problem: Problem, radius: arb, left: bool) -> Target:
    """The target in radii, mirrored if it enters the right turning circle, not the `left` one."""
    at = target(problem, radius)
    return at if left else at.mirrored


def _beyond(near: Target) -> tuple[arb, arb]:
    """Lengths of RL, the optimum, and of RS, the algorithm's answer, in the left circle; radii."""
    ((optimum,), _) = right_left_solutions(*near, inside=True)
    turn, straight = left_straight(near.mirrored)
    return optimum, turn + straight


def _rounded_up(value: arb) -> int:
    """The next larger whole number with only one digit other than zero."""

    def rule(exact: Decimal) -> int:
        unit: int = 10 ** exact.adjusted()
        return (int(exact) // unit + 1) * unit

    return decide(value, rule)


class Extremal(NamedTuple):
    """An LS or RS, with its multipliers nu0 = 1 and (nu1, nu2) = -(cos, sin) of `end`."""

    problem: Problem
    length: arb
    end: arb  # final heading, not wrapped
    arrives: bool  # it meets (4.10) and (4.11)
    qualifies: bool  # it meets H = 0 at the start and the control law


def _extremal(problem: Problem, word: str) -> Extremal:
    """A word of a scenario.

    H is (2.9) at the start, times R, with nu3 from (2.10) and nu3 = 0 on the straight. The control
    law (2.14) asks for nu3 and the turn rate of opposite sign; |turn| < 2 pi, so nu3 is not 0.
    """
    nil, z = ball(NIL), pieces(problem, word)
    start = heading(problem)
    end = start + (z[0] - z[1]) / problem.radius
    switch = 1 - (end - start).cos()
    hamiltonian = 1 + (start - end - arb.pi()).cos() - switch
    return Extremal(
        problem,
        z[0] + z[1] + z[2],
        end,
        arrives=all(abs(side) < nil for side in offset(problem, z)),
        qualifies=positive(switch) and abs(hamiltonian) < nil,
    )


def statements() -> list[Record]:
    """The paper's statements that its scenarios decide: records of where, says, holds, finding."""
    paths = [_extremal(problem, word) for problem in PROBLEMS.values() for word in _WORDS]
    crossings = algorithm()
    left = [crossing for crossing in crossings if crossing["circle"] == "left"]
    met = all(path.arrives for path in paths)
    radii = ", ".join(str(crossing["example_radius"]) for crossing in crossings)
    qualify = [path for path in paths if path.qualifies]
    longest = max(
        float(first.length / second.length)
        for first in qualify
        for second in paths
        if first.problem == second.problem
    )
    # phi = end + pi, and an arctangent lies where the cosine is positive
    off = [path for path in paths if positive(path.end.cos())]
    inside = [path for path in paths if positive(path.end) and positive(2 * arb.pi() - path.end)]
    table = (
        (
            "(4.10), (4.11)",
            "the end point of a turn left, a turn right and a straight",
            f"met to 60 digits by the exact LS and RS of all {len(PROBLEMS)} scenarios: "
            "no sign is off",
        ),
        (
            "(4.1), Algorithm 1",
            "the shortest path is LS or RS",
            "only outside the turning circles. Inside, RL or LR is shorter: the algorithm's path "
            f"is {_range(crossings, 'example_excess')} too long on its own five problems at the "
            f"radii {radii}",
        ),
        (
            "(4.12)",
            "a left turn, a right turn and a straight, in this order, hold the optimum",
            f"it holds LR but not RL: right for the {len(crossings) - len(left)} problems whose "
            f"target enters the right circle, {_range(left, 'model_excess')} too long just beyond "
            f"R* for the {len(left)} whose target enters the left one",
        ),
        (
            "(2.4)-(2.15)",
            "the conditions that an optimal path meets",
            "three are left out: nu0 >= 0, multipliers not all zero (zeros meet the rest on any "
            "path) and nu3 = 0 at the end, where the heading is free. With them they are still not "
            f"sufficient: {len(qualify)} of the {len(paths)} exact LS and RS qualify, "
            f"up to {longest:.2f} times as long as the optimum",
        ),
        (
            "after (2.8)",
            "tan phi = nu2 / nu1",
            f"phi taken from it is off by pi on {len(off)} of the {len(paths)} exact paths, where "
            "(2.15) then comes to 2 instead of 0",
        ),
        (
            "section 2, (4.7)",
            "theta in [0, 2 pi], and theta1 = theta0 + b z1, theta2 = theta1 - b z2",
            f"both cannot hold: {len(paths) - len(inside)} of the {len(paths)} exact paths end "
            "outside [0, 2 pi]",
        ),
    )
    return [
        {"where": where, "says": says, "holds": met and where == table[0][0], "finding": finding}
        for where, says, finding in table
    ]


def _range(crossings: list[Record], key: str) -> str:
    shares = [crossing[key] for crossing in crossings]
    return f"{100 * min(shares):.2g} % to {100 * max(shares):.2g} %"
