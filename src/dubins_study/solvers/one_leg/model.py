"""The paper's model (4.12) at unit radius.

It is in body coordinates. Its variables are z = (z1, z2, z3) >= 0: a turn one way, a turn the other
way (rad), a straight (radii). In the order LRS the first turn is to the left. The order RLS is the
same model seen in a mirror.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.course import path_of
from dubins_study.solvers.presolve import words
from dubins_study.solvers.protocol import Question
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.body_coordinates import Local, local
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario


@dataclass(frozen=True)
class Subproblem:
    """The model with some lengths fixed at zero."""

    name: str  # the word, or the order of the turns
    mirrored: bool  # whether the order is RLS
    free: tuple[int, ...]  # indices into z of the lengths that are not fixed

    @cached_property
    def mask(self) -> BoolArray:
        """Which lengths are free, shape (3,)."""
        return np.isin(np.arange(3), self.free)

    @property
    def turns(self) -> tuple[float, float, float]:
        """Curvature of the three pieces at unit radius."""
        if self.mirrored:
            return (-1.0, 1.0, 0.0)
        return (1.0, -1.0, 0.0)


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
# the unit of the model's lengths: turning radii, or as in the paper the scenario's unit
UNITS = ("radius", "scenario")
ORDERS = {"LRS": ("LRS",), "RLS": ("RLS",), "both": ("LRS", "RLS")}


def formulation(model: str, order: str) -> str:
    """The formulation's name in rows.

    `model` is one of `MODELS`, `order` one of `ORDERS`: "joint" and "both" give the name
    "joint NLP, both orders".
    """
    if model != "joint":
        return "one NLP a word"
    if order == "both":
        return "joint NLP, both orders"
    return f"joint NLP, {order}"


class Case(NamedTuple):
    """A subproblem and its target.

    The target is in radii, and mirrored if the subproblem is. `unit` is the length of a radius in
    the unit in which the model is posed. With `capped`, no arc is longer than a full turn.
    """

    subproblem: Subproblem
    target: Local
    capped: bool = True
    unit: float = 1.0

    @property
    def upper(self) -> FloatArray:
        """Upper bounds of z, shape (3,), in radii."""
        # A path with a full turn in it is never shortest, so the cap, which the paper does not
        # have, removes local minima and no optimum (docs/derivation.md, section 7).
        arc = math.inf
        if self.capped:
            arc = TWO_PI
        return np.where(self.subproblem.mask, (arc, arc, math.inf), 0.0)


def case_of(name: str, target: Local) -> Case:
    """The case of a subproblem's name.

    `target` is in body coordinates.
    """
    subproblem = SUBPROBLEMS[name]
    if subproblem.mirrored:
        target = target.mirrored
    return Case(subproblem, target)


class PosedLeg(NamedTuple):
    """A question about one leg, with its cases.

    The target is in body coordinates.
    """

    question: Question
    target: Local
    cases: list[Case]


def posed_leg(question: Question, model: str, order: str, presolve: bool = False) -> PosedLeg:
    """The question with the cases to solve.

    The branch `best` has a case for each order that `order` names (one of `ORDERS`) if `model` is
    "joint", else a case for each word. Any other branch is a word, the only case. `presolve` leaves
    out words that cannot exist, but no order.
    """
    target = local(question.scenario)
    if model == "joint" and question.branch == "best":
        chosen = ORDERS[order]
    else:
        chosen = words(question.branch, target, presolve)
    return PosedLeg(question, target, [case_of(name, target) for name in chosen])


# z1, z2, z3 (radii)
Lengths = FloatArray | Sequence[float]


def end_point(z1: Any, th: Any, z3: Any, functions: Any, R: Any = 1.0) -> tuple[Any, Any]:
    """The end (x, y) of the model's path.

    The path turns left by z1, then right to the final heading th, and goes straight for z3. The
    values are numbers or variables of any interface; `functions` has its `sin` and `cos`.
    """
    sin = functions.sin
    cos = functions.cos
    x = R * (2 * sin(z1) - sin(th)) + z3 * cos(th)
    return x, R * (1 - 2 * cos(z1) + cos(th)) + z3 * sin(th)


def equations(z: Lengths, X: float, Y: float) -> FloatArray:
    """Target minus end point; (3,) -> (2,).

    Equations (4.10) and (4.11) with start (0, 0, 0) and b = 1.
    """
    z1, z2, z3 = z
    x, y = end_point(z1, z1 - z2, z3, math)
    return np.array((X - x, Y - y))


def jacobian(z: Lengths) -> FloatArray:
    """Derivative of `equations` by z.

    Shape (3,) -> (2, 3).
    """
    z1, z2, z3 = z
    th = z1 - z2
    cos = math.cos(th)
    sin = math.sin(th)
    return np.array(
        (
            (cos + z3 * sin - 2 * math.cos(z1), -cos - z3 * sin, -cos),
            (sin - z3 * cos - 2 * math.sin(z1), -sin + z3 * cos, -sin),
        )
    )


def hessian(z: Lengths, weights: FloatArray) -> FloatArray:
    """Second derivative of `weights` times `equations` by z.

    Shapes (3,), (2,) -> (3, 3).
    """
    z1, z2, z3 = z
    th = z1 - z2
    cos = math.cos(th)
    sin = math.sin(th)
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
    """The path of a point z.

    Lengths that a solver left below zero by rounding count as zero.
    """
    return path_of(scenario, subproblem.turns, z)
