"""The answer of `heading-milp`: the shortest path of all MILPs of a question."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.heading_milp.grid import Family
from dubins_study.solvers.heading_milp.legs import Legs, controls
from dubins_study.solvers.paper_nlp.polish import one_sided_only
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.vehicle_frame import in_world
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Effort
from dubins_study.study.words import Claim


class MilpResult(NamedTuple):
    """The result of one MILP.

    `length` and `bound` are in radii; the bound holds for paths on this grid only. Without a path
    that arrives, `legs` is None and `length` infinite.
    """

    family: Family
    status: str
    choice: int
    legs: Legs | None
    length: float
    bound: float
    nodes: int
    iterations: int
    seconds: float


def solution(
    question: Question, results: list[MilpResult], complete: bool, grid: str, engine: str
) -> Solution:
    """The shortest path of all MILPs, and the claim that follows from their statuses.

    Args:
        question: what is answered.
        results: of the MILPs that there was time for.
        complete: whether these are all.
        grid, engine: for messages.
    """
    scenario, R = question.scenario, question.scenario.radius
    counts: dict[str, Any] = {
        "iterations": sum(result.iterations for result in results),
        "evaluations": sum(result.nodes for result in results),
        "native_status": "; ".join(
            dict.fromkeys(f"{result.family.name} {result.status}" for result in results)
        ),
        "efforts": _efforts(results),
    }
    done = {result.status for result in results} <= {"optimal", "infeasible"}
    stopped = not complete or any(result.status == "user_limit" for result in results)
    best = min(results, key=lambda result: result.length, default=None)
    if best is None or best.legs is None:
        message = f"no path on {grid} was found"
        if not stopped and {result.status for result in results} == {"infeasible"}:
            message = f"{message}: {engine} proves that there is none, on this grid only"
        return Solution(Claim.LIMIT if stopped else Claim.FAILED, message=message, **counts)
    claim = Claim.LIMIT if stopped else Claim.LOCAL if done else Claim.FEASIBLE
    duals = best.legs.duals
    curvature, length = controls(best.family, best.choice, best.legs.length)
    path = Path(scenario.start, np.array(curvature) / R, np.array(length) * R)
    # "infeasible": the family has no path shorter than the best one, at whose length it is cut off
    bound = min(
        result.bound if result.status != "infeasible" else best.length for result in results
    )
    message = f"{best.family.name}; not all words were solved"
    if math.isfinite(bound):
        proven = f"{engine}'s bound {bound * R:.9g}"
        message = (
            f"{best.family.name}; {proven} holds for paths on {grid} only, not for the scenario"
        )
    if claim is not Claim.LIMIT and (reason := one_sided_only(question, path)):
        claim, message = Claim.FAILED, reason
    return Solution(
        claim,
        path=path,
        claimed_length=best.length * R,
        multipliers=None if duals is None else in_world(scenario, *map(float, duals)),
        message=message,
        best_run=_effort([best]),
        **counts,
    )


def _efforts(results: list[MilpResult]) -> tuple[Effort, ...]:
    """What each word cost; a word may have several MILPs."""
    by_word: dict[str, list[MilpResult]] = {}
    for result in results:
        by_word.setdefault(result.family.name, []).append(result)
    return tuple(_effort(of_one) for of_one in by_word.values())


def _effort(results: list[MilpResult]) -> Effort:
    nodes, seconds = sum(one.nodes for one in results), sum(one.seconds for one in results)
    return Effort(results[0].family.name, len(results), nodes, seconds)
