"""Compute what the paper's algorithm returns, and whether the paper's statements hold."""

from __future__ import annotations

from typing import Any

from flint import arb

from dubins_study.report.paper.exact import (
    NIL,
    Target,
    ball,
    heading,
    left_straight,
    miss,
    pieces,
    positive,
    target,
    text,
    truncated,
)
from dubins_study.report.paper.printed import PROBLEMS, WORDS, Problem
from dubins_study.study.check.enclosure import right_left_solutions

Record = dict[str, Any]


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
    at = target(problem, arb(1))
    left = positive(at.Y)
    circle = (at.X**2 + at.Y**2) / (2 * abs(at.Y))
    near = _beside(problem, circle)
    front = positive(near.X)
    arc = arb.atan2(near.X, 1 - near.Y)
    if not front:
        arc += 2 * arb.pi()
    optimum, returned = _beyond(near)
    example_radius = _rounded_up(circle)
    example_optimum, example_returned = _beyond(_beside(problem, arb(example_radius)))
    excess = float(returned / optimum - 1)
    return {
        "label": position,
        "circle": "left" if left else "right",
        "half": "front" if front else "rear",
        "radius": text(circle),
        "length_there": float(arc * circle),
        "word_beyond": "RL" if left else "LR",
        "length_beyond": float(optimum * circle),
        "algorithm_word": "RS" if left else "LS",
        "algorithm_length": float(returned * circle),
        "algorithm_excess": excess,
        "model_excess": excess if left else 0.0,
        "example_radius": example_radius,
        "example_length": float(example_optimum * example_radius),
        "example_algorithm_length": float(example_returned * example_radius),
        "example_excess": float(example_returned / example_optimum - 1),
    }


def _beside(problem: Problem, radius: arb) -> Target:
    """The target in radii; mirrored if it lies to the right, so that it enters the left circle."""
    at = target(problem, radius)
    return at if positive(at.Y) else at.mirrored


def _beyond(near: Target) -> tuple[arb, arb]:
    """Lengths of RL, the optimum, and of RS, the algorithm's answer, in the left circle; radii."""
    ((optimum,), _) = right_left_solutions(*near, inside=True)
    turn, straight = left_straight(near.mirrored)
    return optimum, turn + straight


def _rounded_up(value: arb) -> int:
    """The next larger whole number with only one digit other than zero."""
    whole = int(truncated(value, 0))
    unit = int(10 ** (len(str(whole)) - 1))
    return (whole // unit + 1) * unit


def statements() -> list[Record]:
    """The paper's statements that its scenarios decide: records of where, says, holds, finding."""
    met = True
    turns: list[arb] = []
    ends: list[arb] = []  # final headings, not wrapped
    ratios: list[float] = []  # the longer of LS and RS by the shorter
    for problem in PROBLEMS.values():
        both = [pieces(problem, word) for word in WORDS]
        met &= all(miss(problem, z) < ball(NIL) for z in both)
        lengths = [z[0] + z[1] + z[2] for z in both]
        ratios.append(float(max(lengths) / min(lengths)))
        turned = [(z[0] - z[1]) / problem.radius for z in both]
        turns += turned
        ends += [heading(problem) + turn for turn in turned]
    # With nu0 = 1, (nu1, nu2) = -(cos, sin) of the end, nu3 from (2.10) and zero on the straight, H
    # (2.9) is zero at the start of each LS and RS; the control law (2.14) asks for nu3 and the turn
    # rate of opposite sign.
    qualify = [turn for turn in turns if positive(1 - turn.cos())]
    # phi = end + pi, and an arctangent lies where the cosine is positive
    off = [end for end in ends if positive(end.cos())]
    inside = [end for end in ends if positive(end) and positive(2 * arb.pi() - end)]
    crossings = algorithm()
    left = [crossing for crossing in crossings if crossing["circle"] == "left"]
    radii = ", ".join(str(crossing["example_radius"]) for crossing in crossings)
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
            f"sufficient: {len(qualify)} of the {len(ends)} exact LS and RS qualify, "
            f"up to {max(ratios):.2f} times as long as the optimum",
        ),
        (
            "after (2.8)",
            "tan phi = nu2 / nu1",
            f"phi taken from it is off by pi on {len(off)} of the {len(ends)} exact paths, where "
            "(2.15) then comes to 2 instead of 0",
        ),
        (
            "section 2, (4.7)",
            "theta in [0, 2 pi], and theta1 = theta0 + b z1, theta2 = theta1 - b z2",
            f"both cannot hold: {len(ends) - len(inside)} of the {len(ends)} exact paths end "
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
