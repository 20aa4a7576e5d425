"""The promise that every solver keeps, written once."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, Protocol, TypeVar

from study.path import Path
from study.scenario import Scenario
from study.verify import Claim

Model = TypeVar("Model")


class Guarantee(StrEnum):
    """What the method promises of an answer, if it works as it should."""

    EXACT = "exact"
    LOCAL = "local"
    DISCRETISED = "discretised"
    GLOBAL = "global"


class Outcome(StrEnum):
    """What happened to the process that was asked."""

    RETURNED = "returned"
    TIMEOUT = "timeout"
    CRASHED = "crashed"
    RAISED = "raised"
    OUT_OF_MEMORY = "out_of_memory"
    UNSUPPORTED = "unsupported"
    UNAVAILABLE = "unavailable"


@dataclass(frozen=True, slots=True)
class Question:
    """A scenario, the branch asked of it, and a path to start from (None when cold)."""

    scenario: Scenario
    branch: str = "best"
    start: Path | None = None


@dataclass(frozen=True, slots=True)
class Solution:
    """What a solver answers. The point is kept whatever the claim, unless that is `infeasible`.

    Args:
        claim: what the solver says of its answer.
        path: controls, or None if there is no point to return.
        claimed_length: objective value as the solver reports it (length unit).
        lower_bound: a bound on the scenario's shortest length, if the method proves one.
        multipliers: duals of the end point's two equations, in the world frame (dimensionless).
        iterations, evaluations: the solver's own counts, summed over its subproblems.
        native_status, message: the backend's own words.
    """

    claim: Claim
    path: Path | None = None
    claimed_length: float | None = None
    lower_bound: float | None = None
    multipliers: tuple[float, float] | None = None
    iterations: int | None = None
    evaluations: int | None = None
    native_status: str = ""
    message: str = ""


class Solver(Protocol[Model]):
    """One method with its settings: a frozen dataclass whose fields are the settings.

    Class attributes:
        name: the name in the registry, e.g. `turn-rate-qp`.
        method: closed form, local NLP, transcription, sequential convex, MILP, global MINLP
            or indirect.
        guarantee: what the method promises.
        branches: the branches that it can be asked.
        warm: whether `Question.start` is used.
        packages: distributions whose versions belong to its rows.
        summary: one line for `dubins-study solvers`.

    A backend may also have `solve_frame(frame, branch) -> FrameSolution` (see `solvers.frame`)
    and `profiles: dict[str, dict]`, settings that a named profile changes.
    """

    name: ClassVar[str]
    method: ClassVar[str]
    guarantee: ClassVar[Guarantee]
    branches: ClassVar[tuple[str, ...]]
    warm: ClassVar[bool]
    packages: ClassVar[tuple[str, ...]]
    summary: ClassVar[str]

    def unavailable(self) -> str | None:
        """Why the solver cannot run here (a missing package, binary or licence), or None."""

    def build(self, question: Question) -> Model:
        """Translate the question; timed as build.

        A template that all questions share is compiled once and kept between calls.
        """

    def solve(self, model: Model, limit: float) -> Solution:
        """Optimise for about `limit` seconds; timed as solve. Failure is a claim, no exception."""


AnySolver = Solver[Any]
