"""The promise that every solver keeps, written once."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from operator import index
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from dubins_study.study.check.verdict import Claim
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

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
    """A scenario, the branch asked of it, and an initial guess (None when cold, a path when warm)."""

    scenario: Scenario
    branch: str = "best"
    initial_guess: Path | None = None


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

    Raises:
        TypeError: naming the field, its value and what was expected; raised where a plug-in makes
            its solution, so that it is the plug-in's failure.
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

    def __post_init__(self) -> None:
        path = self.path
        if path is not None and type(path) is not Path:
            if not isinstance(path, Path):
                raise TypeError(f"path is {_short(path)}; expected a Path or None")
            # its controls are believed, not what a subclass makes of them
            path = Path(path.start, path.curvature, path.length)
        object.__setattr__(self, "path", path)
        object.__setattr__(self, "claim", _claim(self.claim))
        for name in ("claimed_length", "lower_bound"):
            object.__setattr__(self, name, _number(name, getattr(self, name)))
        for name in ("iterations", "evaluations"):
            object.__setattr__(self, name, _count(name, getattr(self, name)))
        object.__setattr__(self, "multipliers", _pair(self.multipliers))
        for name in ("native_status", "message"):
            object.__setattr__(self, name, str(getattr(self, name)))


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _claim(value: Any) -> Claim:
    try:
        return Claim(value)
    except ValueError:
        raise TypeError(f"claim is {_short(value)}; expected one of: {', '.join(Claim)}") from None


def _number(name: str, value: Any) -> float | None:
    if value is None:
        return None
    try:
        # what `float` takes for a number and is none
        if isinstance(value, str | bytes | bytearray | bool | np.bool_):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} is {_short(value)}; expected a number or None") from None


def _count(name: str, value: Any) -> int | None:
    try:
        found = None if value is None else index(value)
    except TypeError:
        found = -1
    if found is not None and not 0 <= found < 2**63:
        raise TypeError(f"{name} is {_short(value)}; expected a count or None")
    return found


def _pair(value: Any) -> tuple[float, float] | None:
    if value is None:
        return None
    try:
        x, y = (_number("multipliers", one) for one in value)
    except (TypeError, ValueError):
        x = y = None
    if x is None or y is None:
        raise TypeError(f"multipliers is {_short(value)}; expected two numbers or None")
    return x, y


class Solver(Protocol[Model]):
    """One method with its settings: a frozen dataclass whose fields are the settings.

    Class attributes:
        name: the name in the registry, e.g. `turn-rate-qp`.
        method: closed form, local NLP, transcription, sequential convex, MILP, global MINLP
            or indirect.
        guarantee: what the method promises.
        branches: the branches that it can be asked.
        warm: whether `Question.initial_guess` is used.
        packages: distributions whose versions belong to its rows.
        summary: one line for `dubins-study solvers`.

    A backend may also have `solve_frame(frame, branch) -> FrameSolution` (see `solvers.frame`),
    `profiles: dict[str, dict]`, settings that a named profile changes, `variants`, specs of its own
    that `dubins-study solvers` lists beside it, and `library_versions() -> dict[str, str]`, of the
    libraries inside its packages that have versions of their own. `runs` is the name of the
    program on PATH that it starts, if any.
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
