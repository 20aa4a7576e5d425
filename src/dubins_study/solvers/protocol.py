"""The interface of every solver."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from operator import index
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.solvers.setting_checks import check_settings
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import CLAIMS, Path, Paths, drivable
from dubins_study.study.rows.schema import Effort, Reported
from dubins_study.study.scenario import LARGEST_EXTENT, Pose, Scenario
from dubins_study.study.values import real_array, real_number, short
from dubins_study.study.words import BY_NAME, FREE_FINAL_HEADING, GUESSES, SEVERAL, Claim

if TYPE_CHECKING:
    import pandas as pd


class Guarantee(StrEnum):
    """The guarantee of a method for its solutions.

    It holds for an answer that the method calls a solution.
    """

    EXACT = "exact"
    LOCAL = "local"
    DISCRETISED = "discretised"
    GLOBAL = "global"
    STOCHASTIC = "stochastic"


@dataclass(frozen=True, slots=True)
class Question:
    """A scenario, a branch and an initial guess.

    The guess is a path when warm, and None when cold. `repeat` numbers the times that the question
    is put to a solver. A solver that draws random numbers adds `repeat` to its seed.
    """

    scenario: Scenario
    branch: str = "best"
    initial_guess: Path | None = None
    repeat: int = 0

    @property
    def guess_in_radii(self) -> Path | None:
        """The initial guess at unit radius.

        The path starts at (0, 0) with heading 0. None if the question is cold, or if its path
        cannot be driven in doubles.
        """
        guess = self.initial_guess
        radius = self.scenario.radius
        if guess is None or not drivable(guess):
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            path = Path(Pose(0.0, 0.0, 0.0), guess.curvatures * radius, guess.lengths / radius)
            extent = path.length + np.abs(path.curvatures * path.lengths).sum()
        if extent <= LARGEST_EXTENT:
            return path
        return None  # also where the extent is NaN


class Method(NamedTuple):
    """The columns that describe a solver's method.

    They are the same for all questions to a solver.

    Args:
        formulation: the problem that is handed over, one of `study.words.FORMULATIONS` if it fits.
        engine: the library that solves it, as its makers write it, e.g. `Ipopt`.
        guess: where the search begins: `bearing`, `one`, `words`, `straight`, `zero`, `random`,
            `given` or `none`.
        tolerance: the feasibility that the engine is asked for, in its own terms; None without.
        proves: the smallest relative gap that a bound of the solver's can prove with its settings;
            None if it gives no bound, or does not know.
        presolve: whether questions are presolved for the solver; its own attribute decides.
        knows: the solver's knowledge of the answer, beyond that in its formulation and guess.
    """

    formulation: str = "not stated"
    engine: str = "not stated"
    guess: str = "none"
    tolerance: float | None = None
    proves: float | None = None
    presolve: bool = False
    knows: str = ""

    def columns(self, question: Question | None = None) -> dict[str, Any]:
        """The columns of a row, by name.

        The columns are the fields and `guesses`, the knowledge in the initial guesses
        (`study.words.GUESSES`). `guess` is `warm` if the question hands a guess to a search.
        `knows` lists the knowledge of formulation, guesses and presolve too.
        """
        has_guess = question is not None and question.initial_guess is not None
        guess = self.guess
        if has_guess and guess != "none":
            guess = "warm"
        guesses = GUESSES.get(guess, guess)
        posed = BY_NAME.get(self.formulation)
        known = self.knows.split()
        if posed is not None:
            known += posed.knows.split()
        one_leg = question is None or question.scenario.one_free_leg
        if posed is not None and posed.several and guess == "bearing" and one_leg:
            guesses = SEVERAL
        if guesses in ("words", SEVERAL):
            known.append("words")
        if self.presolve:
            known.append("presolve")
        knows = " ".join(dict.fromkeys(known))
        return self._asdict() | {"guess": guess, "guesses": guesses, "knows": knows}


NOT_STATED = Method()


# The check has no time limit of its own, and a caller waits for it after the solver's limit. It
# takes 0.1 to 0.7 s of processor time for this many arcs (about 10 us an arc, spread evenly over
# its steps). They are a hundred times as many as those of the finest grid of an experiment.
MAX_ARCS = 2**16


@dataclass(frozen=True)
class Solution(Reported):
    """A solver's answer.

    The path is kept and judged whatever the claim.

    Args:
        claim: the solver's claim about its answer.
        path: controls of at most `MAX_ARCS` arcs, or None if there is no point to return.
        claimed_length: objective value as the solver reports it (length unit).
        lower_bound: a bound on the scenario's shortest length, if the method proves one.
        multipliers: duals of the end point's two equations, in the world frame (dimensionless).
        point: the numbers of a primal and dual point of a frozen convex problem.
        iterations, evaluations: the solver's own counts, summed over its subproblems.
        native_status, message: the status and message of the library that solved.
        presolved: whether the presolve answered (`solvers.presolve`), and no engine was asked.
        efforts: the cost of each subproblem, in the order in which they were solved.
        best_run: the cost of the run from which the answer comes.
        trace: paths on the way to the answer, each with the evaluations that were spent until then.

    Raises:
        TypeError: naming the field, its value and what was expected. It is raised inside the
            solver that makes the solution, and so counts as that solver's failure.
    """

    def __post_init__(self) -> None:
        values = vars(self)
        for name, (make_plain, expected) in _PLAIN.items():
            if (value := values[name]) is None and name in _OPTIONAL:
                continue
            try:
                values[name] = make_plain(value)
            except Exception:  # of a class of a plug-in
                raise TypeError(f"{name} is {short(value)}; expected {expected}") from None
        if self.path is not None and self.path.lengths.size > MAX_ARCS:
            arcs = self.path.lengths.size
            raise TypeError(f"path has {arcs} arcs; expected at most {MAX_ARCS}")


def _path(value: Any) -> Path:
    if not isinstance(value, Path):
        raise TypeError
    return value


# The largest count that a results folder holds: not all whole numbers above it are doubles.
_MAX_COUNT = 2**53


def _count(value: Any) -> int:
    if not 0 <= (count := int(index(value))) <= _MAX_COUNT:
        raise ValueError
    return count


def _text(value: Any) -> str:
    """The value as a plain str for a row.

    A subclass of str becomes a str too. Surrogates are replaced.
    """
    if type(value) is str and value.isascii():
        return value
    return str.encode(str(value), "utf-8", "replace").decode()


def _numbers(value: Any) -> FloatArray:
    return real_array("point", value, (np.size(value),))


def _pair(value: Any) -> tuple[float, float]:
    x, y = map(real_number, value)
    return x, y


def _effort(value: Any) -> Effort:
    subproblem, runs, evaluations, seconds = value
    if runs is None:
        runs = 0
    if evaluations is not None:
        evaluations = _count(evaluations)
    return Effort(_text(subproblem), _count(runs), evaluations, float(seconds))


def _efforts(value: Any) -> tuple[Effort, ...]:
    return tuple(map(_effort, value))


def _trace(value: Any) -> tuple[tuple[int, Path], ...]:
    return tuple((_count(evaluations), _path(path)) for evaluations, path in value)


# by the annotation of a field: the function that makes a plain value of the solver's value, and the
# name of the expected type in messages
_OF_TYPE: dict[str, tuple[Callable[[Any], Any], str]] = {
    "Claim": (Claim, f"one of: {', '.join(Claim)}"),
    "Path | None": (_path, "a Path or None"),
    "FloatArray | None": (_numbers, "an array of numbers or None"),
    "float | None": (real_number, "a number or None"),
    "tuple[float, float] | None": (_pair, "two numbers or None"),
    "int | None": (_count, "a count or None"),
    "str": (_text, "a text"),
    "bool": (bool, "a boolean"),
    "tuple[Effort, ...]": (_efforts, "Efforts"),
    "Effort | None": (_effort, "an Effort or None"),
    "tuple[tuple[int, Path], ...]": (_trace, "pairs of a count and a Path"),
}
_PLAIN = {each.name: _OF_TYPE[str(each.type)] for each in fields(Reported)}
_OPTIONAL = {each.name for each in fields(Reported) if str(each.type).endswith("| None")}


@dataclass(frozen=True, eq=False)
class FrameSolution:
    """A solver's answers to n scenarios, as arrays.

    A solver's `solve_frame(frame, branch)` returns this object. The frame that the solver gets has
    passed `study.scenario_frame.check_frame`. The frame has no via points. The final headings of
    all rows are free, or all are given if the solver takes them. `branch` is one of the solver's
    own. The caller times the call and judges the paths, as for `Solver.solve`. Values of another
    shape or type are a TypeError.
    """

    claim: Claim | ArrayLike  # one for all rows, or indices into `study.path.CLAIMS`, shape (n,)
    paths: Paths  # controls of n paths of two or three arcs, and which rows have one
    claimed_length: FloatArray | None = None  # length unit, shape (n,); NaN where there is none
    lower_bound: FloatArray | None = None  # proven (length unit), shape (n,)
    native_status: str = ""
    message: str | Sequence[str] = ""  # one for all rows, or n

    def __post_init__(self) -> None:
        values = vars(self)
        if not isinstance(self.paths, Paths):
            raise TypeError(f"paths is {short(self.paths)}; expected Paths")
        n = len(self.paths)
        for name in ("claimed_length", "lower_bound"):
            if values[name] is not None:
                values[name] = real_array(name, values[name], (n,))
        if not isinstance(self.claim, Claim):
            codes = np.asarray(self.claim)
            if codes.dtype.kind not in "iu" or not ((codes >= 0) & (codes < len(CLAIMS))).all():
                raise TypeError("claim is neither a Claim nor indices into CLAIMS")
            if codes.shape != (n,):
                raise TypeError(f"claim has shape {codes.shape}; expected {(n,)}")
            values["claim"] = codes.astype(codes.dtype.newbyteorder("="), copy=False)
        if not isinstance(self.native_status, str):
            raise TypeError(f"native_status is {short(self.native_status)}; expected a text")
        if isinstance(self.message, str):
            return
        if len(self.message) != n or not all(isinstance(each, str) for each in self.message):
            raise TypeError(f"message is {short(self.message)}; expected a text, or {n} texts")


class Solver:
    """The base class of every solver.

    A solver is one method with its settings. It is a frozen dataclass that extends this class; its
    fields are the settings. It must give `name` and either `solve(question, limit)`, or
    `build(question)` and `solve(model, limit)`, which are then timed apart. Everything else has the
    default that stands here.

    Class attributes:
        name: the name in the registry, e.g. `turn-rate-qp`.
        guarantee: the method's promise.
        branches: the branches that the solver can answer.
        takes: the needs that the solver can meet, of `study.words.NEEDS`: `free final heading`,
            `final heading`, `via points`. A scenario that needs more is `unsupported`, without a
            call.
        warm: whether the solver uses `Question.initial_guess`.
        packages: distributions whose versions belong to the solver's rows.
        summary: one line for `dubins-study solvers`.
        profiles: by the name of a profile, the settings that it changes.
        variants: specs of this solver that `dubins-study solvers` lists beside it.
        always_named: settings that rows name even where they have their defaults.
        solve_frame: a method `solve_frame(frame, branch) -> FrameSolution` that answers a whole
            frame of scenarios at once, or None.
        presolve: whether questions are presolved for the solver (`solvers.presolve`); one that
            declares a field of this name makes it a setting.
    """

    name: ClassVar[str] = ""
    guarantee: ClassVar[Guarantee] = Guarantee.LOCAL
    branches: ClassVar[tuple[str, ...]] = ("best",)
    takes: ClassVar[frozenset[str]] = frozenset({FREE_FINAL_HEADING})
    warm: ClassVar[bool] = False
    packages: ClassVar[tuple[str, ...]] = ()
    summary: ClassVar[str] = ""
    profiles: ClassVar[dict[str, dict[str, Any]]] = {}
    variants: ClassVar[tuple[str, ...]] = ()
    always_named: ClassVar[tuple[str, ...]] = ()
    solve_frame: Callable[[pd.DataFrame, str], FrameSolution] | None = None
    presolve: bool = False

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def method(self) -> Method:
        """The formulation, engine and initial guess.

        A plug-in may give a plain tuple.
        """
        return NOT_STATED

    @property
    def runs(self) -> str | None:
        """The program on PATH that the solver starts.

        None if it starts no program.
        """
        return None

    @property
    def keeps_limit(self) -> bool:
        """Whether the solver may run in the caller's process.

        True is a promise about `build` and `solve` together. Whatever the question, they return at
        most a second after the limit, and they print nothing. It supposes a machine that is not
        overloaded, and libraries that are loaded. Without this promise `dubins_study.solve` asks in
        a worker process, which is killed at the limit.
        """
        return False

    def unavailable(self) -> str | None:
        """The reason why the solver cannot run, or None.

        A package, a binary or a licence may be missing.
        """
        return None

    def library_versions(self) -> dict[str, str]:
        """Versions of the libraries inside the solver's packages.

        The keys are the libraries' names.
        """
        return {}

    def build(self, question: Question) -> Any:
        """The model that `solve` takes.

        The caller times this as build. By default the model is the question itself. A template that
        all questions share is compiled once and kept between calls.
        """
        return question

    def solve(self, model: Any, limit: float) -> Solution:
        """Optimise for about `limit` seconds.

        The caller times this as solve. A failure is a claim, no exception.

        Args:
            model: what `build` returned; the question, where `build` is the default.
            limit: seconds.
        """
        raise NotImplementedError(f"solver {self.name!r} has no method solve(model, limit)")
