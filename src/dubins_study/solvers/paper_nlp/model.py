"""The paper's model (4.12), shared by the NLP backends: three lengths, two equations.

A subproblem lives in the vehicle's frame at unit radius. Its variables are z = (z1, z2, z3): a turn
one way, a turn the other way, a straight (arcs in rad, straight in radii), all z >= 0. In the
order LRS the first turn is to the left; the order RLS is the same model seen in a mirror.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.check.verdict import Claim
from dubins_study.study.path import FloatArray, Path
from dubins_study.study.scenario import Scenario

# The paper leaves arcs unbounded; a path with a full turn in it is never shortest, so this cap
# takes away local minima and no optimum (THEORY section 5).
FULL_TURN = 2 * math.pi


@dataclass(frozen=True)
class Subproblem:
    """The model with some lengths fixed at zero.

    Args:
        name: the word, for messages.
        mirrored: whether the order is RLS.
        free: indices into z of the lengths that are not fixed.
    """

    name: str
    mirrored: bool
    free: tuple[int, ...]

    @cached_property
    def mask(self) -> NDArray[np.bool_]:
        """Which lengths are free, shape (3,)."""
        return np.isin(np.arange(3), self.free)

    @property
    def turns(self) -> tuple[float, float, float]:
        """Curvature of the three pieces at unit radius."""
        return (-1.0, 1.0, 0.0) if self.mirrored else (1.0, -1.0, 0.0)


# The paper's Algorithm 1, step 3, fixes z2 = 0 for LS and z1 = 0 for RS.
SUBPROBLEMS = {
    "LS": Subproblem("LS", False, (0, 2)),
    "RS": Subproblem("RS", False, (1, 2)),
    "LR": Subproblem("LR", False, (0, 1)),
    "RL": Subproblem("RL", True, (0, 1)),
    "LRS": Subproblem("LRS", False, (0, 1, 2)),
    "RLS": Subproblem("RLS", True, (0, 1, 2)),
}
MODELS = ("words", "joint")
# what the model measures lengths in: turning radii, or as in the paper the scenario's own unit
UNITS = ("radius", "scenario")
ORDERS = {"LRS": ("LRS",), "RLS": ("RLS",), "both": ("LRS", "RLS")}


def subproblems(question: Question, model: str, order: str) -> list[Subproblem]:
    """What must be solved to answer a question.

    Args:
        question: its branch is `best` or a word, which is then the subproblem.
        model: `words` takes one two-variable problem per word, `joint` the paper's model unsplit.
        order: of the joint model: `LRS` (the paper's), `RLS` or `both`.
    """
    if question.branch != "best":
        chosen: tuple[str, ...] = (question.branch,)
    elif model == "joint":
        chosen = ORDERS[order]
    else:
        # an arc's chord is at most 2 radii long, so two arcs end within 4
        near = math.hypot(*question.scenario.local()) <= 4
        chosen = ("LS", "RS", "LR", "RL") if near else ("LS", "RS")
    return [SUBPROBLEMS[name] for name in chosen]


def target(scenario: Scenario, mirrored: bool) -> tuple[float, float]:
    """Target of a subproblem: in the vehicle's frame, unit radius, mirrored if the order is RLS."""
    X, Y = scenario.local()
    return (X, -Y) if mirrored else (X, Y)


def equations(z: FloatArray, X: float, Y: float) -> FloatArray:
    """Left-hand sides of (4.10) and (4.11) with start (0, 0, 0) and b = 1; shape (3,) -> (2,).

    Target minus end point, so a solution is a zero.
    """
    z1, z2, z3 = z
    th = z1 - z2
    return np.array(
        (
            X - (2 * math.sin(z1) - math.sin(th)) - z3 * math.cos(th),
            Y - (1 - 2 * math.cos(z1) + math.cos(th)) - z3 * math.sin(th),
        )
    )


def jacobian(z: FloatArray) -> FloatArray:
    """Derivative of `equations` by z; shape (3,) -> (2, 3)."""
    z1, z2, z3 = z
    th = z1 - z2
    cos, sin = math.cos(th), math.sin(th)
    return np.array(
        (
            (cos + z3 * sin - 2 * math.cos(z1), -cos - z3 * sin, -cos),
            (sin - z3 * cos - 2 * math.sin(z1), -sin + z3 * cos, -sin),
        )
    )


def hessian(z: FloatArray, weights: FloatArray) -> FloatArray:
    """Second derivative by z of `weights` times `equations`; shapes (3,), (2,) -> (3, 3)."""
    z1, z2, z3 = z
    th = z1 - z2
    cos, sin = math.cos(th), math.sin(th)
    wx, wy = weights
    bend = wx * (z3 * cos - sin) + wy * (z3 * sin + cos)
    slide = wx * sin - wy * cos
    first = 2 * (wx * math.sin(z1) - wy * math.cos(z1))
    return np.array(
        (
            (first + bend, -bend, slide),
            (-bend, bend, -slide),
            (slide, -slide, 0.0),
        )
    )


def as_path(scenario: Scenario, subproblem: Subproblem, z: FloatArray) -> Path:
    """Controls of a point; lengths that a solver left below zero by rounding count as zero."""
    pieces = [
        (turn / scenario.radius, length * scenario.radius)
        for turn, length in zip(subproblem.turns, z, strict=True)
        if not length <= 0  # so that NaN stays and is seen by the check
    ]
    return Path(scenario.start, [k for k, _ in pieces], [length for _, length in pieces])


def in_world(
    scenario: Scenario, subproblem: Subproblem, multipliers: tuple[float, float]
) -> tuple[float, float]:
    """The duals of the two equations turned from the vehicle's frame to the world's."""
    mx, my = multipliers
    if subproblem.mirrored:
        my = -my
    cos, sin = math.cos(scenario.heading), math.sin(scenario.heading)
    return mx * cos - my * sin, mx * sin + my * cos


def already_there(question: Question) -> Solution | None:
    """The answer to a question whose target is its start: nothing to drive, nothing to solve.

    At z = 0 no constraint qualification holds, so no NLP method can certify this point.
    """
    if question.scenario.local() != (0.0, 0.0):
        return None
    path = Path(question.scenario.start, [], [])
    return Solution(Claim.LOCAL, path=path, claimed_length=0.0, message="the target is the start")


class Point(NamedTuple):
    """What an NLP solver found for one subproblem from one start; z has shape (3,)."""

    subproblem: Subproblem
    z: FloatArray
    claim: Claim
    multipliers: tuple[float, float] | None
    iterations: int | None
    evaluations: int | None
    status: str
    message: str


class Attempts(NamedTuple):
    """How one subproblem is solved.

    Args:
        solve: solves it from a starting point z, shape (3,).
        starts: the points, made one after another since mostly the first one does.
        every: whether all are solved from, or those after the first success are left out.
    """

    solve: Callable[[FloatArray], Point]
    starts: Iterable[FloatArray]
    every: bool


def answer(question: Question, attempts: list[Attempts], limit: float) -> Solution:
    """The answer to a question: each subproblem attempted in turn, the best point chosen.

    No attempt is begun after `limit` seconds.
    """
    return already_there(question) or choose(question, _solve_all(attempts, limit))


def _solve_all(attempts: list[Attempts], limit: float) -> list[Point]:
    began = perf_counter()
    points: list[Point] = []
    for solve, starts, every in attempts:
        for start in starts:
            if perf_counter() - began > limit:
                return points
            points.append(solve(start))
            if points[-1].claim is Claim.LOCAL and not every:
                break
    return points


def choose(question: Question, points: list[Point]) -> Solution:
    """The answer to a question from the points of all its subproblems and starts.

    The shortest of those that the solver calls solutions; if it calls none one, the point that
    ends nearest to the target, with a claim as weak as the strongest among them.
    """
    scenario = question.scenario
    solved = [point for point in points if point.claim is Claim.LOCAL]
    if solved:
        best = min(solved, key=lambda point: float(point.z.sum()))
        claim = Claim.LOCAL
    elif points:
        best = min(points, key=lambda point: _residual(scenario, point))
        claims = {point.claim for point in points}
        claim = claims.pop() if len(claims) == 1 else Claim.FAILED
        if claim is Claim.FEASIBLE and not _residual(scenario, best) <= _ARRIVES:
            claim = Claim.FAILED  # feasible to a tolerance of its own, and no path to the target
    else:
        return Solution(Claim.LIMIT, message="no time to begin")
    duals = best.multipliers
    # a point that its solver calls infeasible is no answer to keep apart from "no path", and some
    # solvers return no numbers when they fail
    pathless = claim is Claim.INFEASIBLE or bool(np.isnan(best.z).all())
    return Solution(
        claim,
        path=None if pathless else as_path(scenario, best.subproblem, best.z),
        claimed_length=float(best.z.sum()) * scenario.radius if solved else None,
        multipliers=None if duals is None else in_world(scenario, best.subproblem, duals),
        iterations=total([point.iterations for point in points]),
        evaluations=total([point.evaluations for point in points]),
        native_status=best.status,
        message=f"{best.subproblem.name}: {best.message}",
    )


def total(counts: Iterable[int | None]) -> int | None:
    """The sum, or None if a backend does not count."""
    known = list(counts)
    return None if None in known else sum(count for count in known if count is not None)


_ARRIVES = 1e-6  # radii, as the check has it


def _residual(scenario: Scenario, point: Point) -> float:
    residual = np.abs(equations(point.z, *target(scenario, point.subproblem.mirrored))).sum()
    return float(residual) if np.isfinite(residual) else math.inf
