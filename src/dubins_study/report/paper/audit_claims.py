"""Compute what the paper's algorithm returns, and whether the paper's statements hold."""

from __future__ import annotations

from fractions import Fraction
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
    right_left,
    target,
    text,
)
from dubins_study.report.paper.printed import PROBLEMS, Problem

Record = dict[str, Any]
_WORDS = ("LS", "RS")


class Beyond(NamedTuple):
    """For a target in or on a turning circle: the optimum and Algorithm 1's answer, in radii."""

    word: str
    optimum: arb
    algorithm_word: str
    algorithm: arb

    @property
    def excess(self) -> arb:
        return self.algorithm / self.optimum - 1


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
    at = target(problem, circle)
    near = at if left else at.mirrored
    arc = arb.atan2(near.X, 1 - near.Y)
    front = positive(near.X)
    edge = beyond(near, left)
    round_radius = _rounded_up(circle)
    example = target(problem, ball(round_radius))
    there = beyond(example if left else example.mirrored, left)
    return {
        "label": position,
        "circle": "left" if left else "right",
        "half": "front" if front else "rear",
        "radius": text(circle),
        "length_there": float((arc if front else arc + 2 * arb.pi()) * circle),
        "word_beyond": edge.word,
        "length_beyond": float(edge.optimum * circle),
        "algorithm_word": edge.algorithm_word,
        "algorithm_length": float(edge.algorithm * circle),
        "algorithm_excess": float(edge.excess),
        "model_excess": float(edge.excess) if left else 0.0,
        "example_radius": round_radius,
        "example_length": float(there.optimum * round_radius),
        "example_algorithm_length": float(there.algorithm * round_radius),
        "example_excess": float(there.excess),
    }


def beyond(near: Target, left: bool) -> Beyond:
    """The optimum and the algorithm's answer inside a circle; `near` is mirrored if not `left`."""
    first, second = right_left(near)
    other = left_straight(near.mirrored)
    words = ("RL", "RS") if left else ("LR", "LS")
    return Beyond(words[0], first + second, words[1], other[0] + other[1])


def _rounded_up(value: arb) -> int:
    """The next larger whole number with only one digit other than zero."""

    def rule(exact: Fraction) -> int:
        unit: int = 10 ** (len(str(int(exact))) - 1)
        return (int(exact / unit) + 1) * unit

    return decide(value, rule)


class Extremal(NamedTuple):
    """A word of a scenario with its multipliers: nu0 = 1, (nu1, nu2) = -(cos, sin) of `end`.

    `offset` holds the residuals of (4.10) and (4.11).
    """

    problem: Problem
    word: str
    length: arb
    end: arb  # final heading, not wrapped
    offset: tuple[arb, arb]

    @property
    def turn_rate(self) -> int:
        return 1 if self.word == "LS" else -1

    @property
    def hamiltonian(self) -> arb:
        """H at the start, eq. (2.9), with nu3 from (2.10) and nu3 = 0 on the straight; times R."""
        start = heading(self.problem)
        phi = self.end + arb.pi()
        switch = -self.turn_rate * (1 - (self.end - start).cos())
        return 1 + (start - phi).cos() + switch * self.turn_rate

    @property
    def obeys_control_law(self) -> bool:
        """(2.14): nu3 and the turn rate are of opposite sign; |turn| < 2 pi, so nu3 is not 0."""
        return positive(1 - (self.end - heading(self.problem)).cos())


def _extremals() -> list[Extremal]:
    extremals = []
    for problem in PROBLEMS.values():
        for word in _WORDS:
            z = pieces(problem, word)
            end = heading(problem) + (z[0] - z[1]) / problem.radius
            extremals.append(Extremal(problem, word, z[0] + z[1] + z[2], end, offset(problem, z)))
    return extremals


def statements() -> list[Record]:
    """The paper's statements that its scenarios decide: records of where, says, holds, finding."""
    paths, crossings = _extremals(), algorithm()
    left = [crossing for crossing in crossings if crossing["circle"] == "left"]
    nil = ball(NIL)
    met = all(abs(side) < nil for path in paths for side in path.offset)
    radii = ", ".join(str(crossing["example_radius"]) for crossing in crossings)
    qualify = [path for path in paths if path.obeys_control_law and abs(path.hamiltonian) < nil]
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
