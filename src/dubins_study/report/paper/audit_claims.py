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
from dubins_study.report.paper.printed import NUMBERS, PROBLEMS, WORDS, Problem
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
    numbers = {
        "scenarios": len(PROBLEMS),
        "paths": len(ends),
        "algorithm_excess": _range(crossings, "example_excess"),
        "radii": ", ".join(str(crossing["example_radius"]) for crossing in crossings),
        "right": len(crossings) - len(left),
        "left": len(left),
        "model_excess": _range(left, "model_excess"),
        "qualify": len(qualify),
        "longest": max(ratios),
        "off": len(off),
        "outside": len(ends) - len(inside),
    }
    return [
        {
            "where": statement["where"],
            "says": statement["says"],
            "holds": met and statement["holds"],
            "finding": statement["finding"].format(**numbers),
        }
        for statement in NUMBERS["statements"]
    ]


def _range(crossings: list[Record], key: str) -> str:
    shares = [crossing[key] for crossing in crossings]
    return f"{100 * min(shares):.2g} % to {100 * max(shares):.2g} %"
