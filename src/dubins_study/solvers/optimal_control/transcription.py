"""The common part of all transcriptions of problem (2.2).

It has their settings, initial guesses, search and answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice, pairwise
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.arcs import (
    HERE,
    RATES,
    Elements,
    Rates,
    closed,
    cut,
    miss,
)
from dubins_study.solvers.course import Course, body_course, coordinate_rounding, in_world
from dubins_study.solvers.engines import NLP_ENGINES, EngineSolver, engine_or_program
from dubins_study.solvers.one_leg.initial_guesses import INITIAL_GUESSES, bearing_guesses
from dubins_study.solvers.one_leg.model import case_of
from dubins_study.solvers.one_leg.polish import one_sided_only
from dubins_study.solvers.presolve import presolved, words
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.runs import (
    Attempts,
    EngineResult,
    Run,
    at_start,
    no_solution,
    run_attempts,
    spent,
    total,
)
from dubins_study.solvers.setting_checks import iterations, one_of, option_set, tolerance, whole
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose
from dubins_study.study.words import IN_ORDER, Claim

_ARRIVED = 1e-8  # radii; a hundredth of the miss that the check allows
_ROUNDED = 32 * math.ulp(1.0)  # of the target's distance
_SAME = 1e-6  # relative; among answers this close, one that its engine calls a solution is taken


class Guess(NamedTuple):
    """An initial guess and its name.

    `subproblem` is the word if the guess has a word's shape, `warm` if it is the question's own
    path, and else the guess's kind.
    """

    subproblem: str
    elements: Elements
    begins: FloatArray | None = None  # poses where legs begin, shape (legs, 3); None: at their ends

    def states(self, legs: int, fraction: FloatArray) -> FloatArray:
        """Poses within the N elements, shape (N k, 3).

        In each element they lie at `fraction` (k,) of its length.
        """
        rate = self.elements.rate.reshape(legs, -1)
        length = self.elements.length.reshape(legs, -1)
        start = HERE
        poses = []
        for leg in range(legs):
            if self.begins is not None:
                start = Pose(*self.begins[leg])
            path = Path(start, rate[leg], length[leg])
            before = np.cumsum(length[leg]) - length[leg]
            poses.append(path.at((before[:, None] + fraction * length[leg][:, None]).ravel()))
            start = path.end
        return np.concatenate(poses)


class Transcribed(NamedTuple):
    """An engine's solution of a transcription.

    The duals in `native`, shape (2,), are those of the end point.
    """

    elements: Elements
    native: EngineResult


def transcribed(elements: Elements, result: EngineResult) -> Transcribed:
    """The solution, with the end point's duals only.

    The program's last two equations must be those of the end point.
    """
    duals = result.duals
    if duals is not None:
        duals = duals[-2:]
    return Transcribed(elements, result._replace(duals=duals))


class Template(NamedTuple):
    """A compiled transcription of a course.

    The course is in body coordinates.
    """

    # of the leg's length, one for each of its n elements, shape (legs, n); None if free
    shares: FloatArray | None
    # from a guess, within the rates, until a time (s, on `perf_counter`)
    solve: Callable[[Guess, Rates, float], Transcribed]


class PosedCourse(NamedTuple):
    """A question in body coordinates, in radii."""

    question: Question
    course: Course
    rates: Rates
    template: Template


@dataclass(frozen=True)
class Transcription(EngineSolver):
    """Problem (2.2) over n elements a leg.

    Each element has one turn rate, and each leg is a phase.

    The engine's controls are integrated exactly. The path may miss by the transcription's own error
    or the engine's tolerance; a last correction removes this miss. `LS` and `RS` forbid turning the
    other way. For `best` of one leg with a free final heading, the engine starts from the shape of
    every word, and the shortest path is the answer. A route, or a leg with a final heading, has one
    guess that knows no word.

    Args:
        n: number of elements of a leg.
        initial_guess, seed, count: where the search begins (`trials`).
        correct: whether a last correction removes the miss.
        presolve: whether no guess is shaped like a word that cannot exist (`solvers.presolve`).
    """

    # Three elements hold every word: an arc of up to a full turn takes two free elements. A
    # thousand take minutes.
    n: int = whole(5, 3, 1000)
    initial_guess: str = one_of("bearing", INITIAL_GUESSES)
    seed: int = whole(0, 0, 2**32)
    count: int = whole(10, 1, 10**6)
    correct: bool = True
    presolve: bool = False

    formulation: ClassVar[str]
    guarantee = Guarantee.DISCRETISED
    branches = tuple(RATES)
    takes = IN_ORDER
    warm = True
    keeps_limit = False  # compiling takes seconds for hundreds of legs

    def template(self, course: Course) -> Template:
        """Compile the transcription of a course."""
        raise NotImplementedError

    def build(self, question: Question) -> PosedCourse:
        course = body_course(question.scenario)
        return PosedCourse(question, course, RATES[question.branch], self.template(course))

    def solve(self, model: PosedCourse, limit: float) -> Solution:
        question = model.question
        course = model.course
        rounding = coordinate_rounding(question.scenario)
        if there := at_start(question.scenario, course.target, rounding):
            return there
        if self.presolve and course.target is not None and (excluded := presolved(question)):
            return excluded  # there would be no guess
        if self.initial_guess == "words" and course.target is None:
            # only the closed form knows the words of a route's legs
            return Solution(
                Claim.FAILED, message="the guess `words` is of one leg with a free final heading"
            )
        until = perf_counter() + limit
        enough = self.initial_guess != "random"  # one solution of a subproblem
        run = partial(self._run, model)
        attempts = (Attempts(guesses, run, lambda _: enough) for guesses in trials(model, self))
        runs = run_attempts(attempts, until)
        return _answer(model, runs, in_time=perf_counter() <= until)

    def _run(self, model: PosedCourse, guess: Guess, until: float) -> Run[Elements]:
        """Solve from one guess, then correct the path."""
        began = perf_counter()
        course = model.course
        elements, native = model.template.solve(guess, model.rates, until)
        # a path that is optimal for a transcription is not proven for the problem itself
        claim = native.claim
        if claim is Claim.OPTIMAL:
            claim = Claim.LOCAL
        missed = math.inf
        off = math.inf
        rollouts = 0
        if not (np.isfinite(elements.turn).all() and np.isfinite(elements.length).all()):
            claim = Claim.FAILED
        else:
            missed = miss(elements, course)
            rollouts = 1
            off = missed
            if self.correct:
                equal = model.template.shares is not None
                correction = closed(elements, model.rates, course, equal)
                elements = correction.elements
                off = correction.miss
                rollouts = correction.rollouts
                if claim is Claim.LOCAL and not _arrives(off, course):
                    claim = Claim.FAILED
        result = native._replace(
            claim=claim,
            evaluations=total((native.evaluations, rollouts)),
            message=f"{native.message}; missed by {missed:.1e} radii before the correction",
        )
        seconds = perf_counter() - began
        return Run(guess.subproblem, seconds, result, elements, length=elements.total, miss=off)


@dataclass(frozen=True)
class NlpTranscription(Transcription):
    """A transcription into one nonlinear program.

    Other settings: `Transcription`.

    Args:
        engine: a name in `solvers.engines` of the kind `local NLP`, or the name of an executable
            on PATH that reads NL files.
        mesh: `free` elements, whose lengths are variables, so that a switch falls between two of
            them and the gap is the engine's tolerance; or `equal` ones, whose gap falls like
            1 / n^2.
        options, tol, max_iter: as those of `nlp`.
    """

    engine: str = engine_or_program("ipopt", NLP_ENGINES)
    mesh: str = one_of("free", ("free", "equal"))
    options: str = option_set()
    tol: float = tolerance()
    max_iter: int = iterations()

    profiles: ClassVar = {
        "fast": {"tol": 1e-7},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        guess = self.initial_guess
        return self.library.method(self.formulation, guess, self.options, self.tol)


def _arrives(off: float, course: Course) -> bool:
    return off <= max(_ARRIVED, _ROUNDED * (course.magnitude - 1.0))


def _answer(model: PosedCourse, runs: list[Run[Elements]], in_time: bool) -> Solution:
    """The answer of all runs.

    It is the shortest run that arrives, or else the one that misses least. Among equally short runs
    one that the engine calls a solution goes first.
    """
    if not runs:
        return no_solution(runs)
    scenario = model.question.scenario
    rates = model.rates
    course = model.course
    arrived = [run for run in runs if run.claim is Claim.LOCAL or _arrives(run.miss, course)]
    most = min((run.length for run in arrived), default=math.inf) * (1 + _SAME)

    def rank(run: Run[Elements]) -> tuple[bool, bool, float]:
        return run.length > most, run.claim is not Claim.LOCAL, run.length

    best = min(runs, key=lambda run: run.miss)
    if arrived:
        best = min(arrived, key=rank)
    claim = best.claim
    message = best.result.message
    if not in_time:
        claim = Claim.LIMIT
    elif claim is not Claim.LOCAL and _arrives(best.miss, course):
        # the engine gave up, or wrongly called it infeasible, but the corrected path arrives
        claim = Claim.FEASIBLE
    elif claim is not Claim.LOCAL:
        claim = Claim.FAILED
        if {run.claim for run in runs} == {Claim.LOCALLY_INFEASIBLE}:
            claim = Claim.LOCALLY_INFEASIBLE
    path = None
    claimed_length = None
    if math.isfinite(best.miss) and claim is not Claim.LOCALLY_INFEASIBLE:
        rate = np.clip(best.point.rate, rates.lower, rates.upper)
        path = Path(scenario.start, rate / scenario.radius, best.point.length * scenario.radius)
        claimed_length = best.length * scenario.radius
        if claim in (Claim.LOCAL, Claim.FEASIBLE) and course.target is not None:
            reason = one_sided_only(model.question, course.target, path)
            if reason is not None:
                claim = Claim.FAILED
                message = reason
    multipliers = None
    if claim is Claim.LOCAL and best.result.duals is not None:
        multipliers = in_world(scenario, best.result.duals)
    return Solution(
        claim,
        path=path,
        claimed_length=claimed_length,
        multipliers=multipliers,
        message=message,
        **spent(runs, best),
    )


_SAMPLES = 200  # a leg, of a path that is cut where it is nearest to the points


def trials(model: PosedCourse, solver: Transcription) -> Iterator[Iterator[Guess]]:
    """The initial guesses that a solver's settings ask for.

    Yields one iterator of guesses for each subproblem. The question's own path goes first if it can
    be driven. For a word it is the first guess; for `best` it is a subproblem of its own. The other
    guesses, by kind (`initial_guesses.INITIAL_GUESSES`):

    - `bearing`: for one leg with a free final heading, shaped like each of the words; elsewhere as
      `one`.
    - `one`: at each point one turn toward the next, and a straight.
    - `words`: the first guess of `bearing` for each word.
    - `straight`: poses on the lines between the points.
    - `zero`: no turn and no length (AMPL's default).
    - `random`: within the rates; each leg is up to twice its points' distance, a turning circle's
      length and its diameter long.
    - `given`: the question's own path only, if there is one.
    """
    question = model.question
    course = model.course
    shares = model.template.shares
    kind = solver.initial_guess
    n = solver.n
    warm = _given(question, course, n, shares)
    if kind == "given" and warm:
        yield iter(warm)
        return
    if kind == "zero":
        zeros = np.zeros(n * course.legs)
        cold = [iter([Guess("zero", Elements(zeros, zeros))])]
    elif kind == "random":
        cold = [_random(model, solver)]
    elif kind == "straight":
        cold = [iter([_straight(course, n, shares)])]
    elif course.target is not None and kind != "one":
        target = course.target
        most = None
        if kind == "words":
            most = 1

        def shaped(word: str) -> Iterator[Guess]:
            case = case_of(word, target)
            for z in islice(bearing_guesses(case, prescribed=False), most):
                lengths = np.array(z) * case.subproblem.mask
                path = Path(HERE, case.subproblem.turns, lengths)
                yield Guess(word, _cut_legs([path], n, shares))

        cold = [shaped(word) for word in words(question.branch, target, solver.presolve)]
    else:
        paths = []
        for leg in course.turned():
            turn, _, last = np.sign(leg)
            paths.append(Path(HERE, (turn, 0.0, last), np.abs(leg)))
        cold = [iter([Guess("one", _cut_legs(paths, n, shares))])]
    if question.branch == "best":
        if warm:
            yield iter(warm)
        yield from cold
        return
    (only,) = cold  # a word as branch is the only subproblem
    yield chain(warm, only)


def _cut_legs(paths: Sequence[Path], n: int, shares: FloatArray | None) -> Elements:
    """The legs' paths, cut into n elements each.

    Each path begins at heading 0.
    """
    of_legs: Any = shares
    if shares is None:
        of_legs = [None] * len(paths)
    legs = [cut(path, n, share) for path, share in zip(paths, of_legs, strict=True)]
    return Elements(*map(np.concatenate, zip(*legs, strict=True)))


def _straight(course: Course, n: int, shares: FloatArray | None) -> Guess:
    """The guess of straights from point to point.

    The vehicle turns on the spot at the points.
    """
    ends = np.cumsum(course.steps, axis=0)
    if shares is None:
        shares = np.full((course.legs, n), 1 / n)
    length = (shares * np.hypot(*course.steps.T)[:, None]).ravel()
    begins = np.column_stack((ends - course.steps, np.unwrap(course.bearings())))
    return Guess("straight", Elements(np.zeros(length.size), length), begins)


def _random(model: PosedCourse, solver: Transcription) -> Iterator[Guess]:
    """Random guesses, as `trials` describes them."""
    course = model.course
    rates = model.rates
    n = solver.n
    shares = model.template.shares
    repeat = model.question.repeat
    random = np.random.default_rng((solver.seed + repeat, repeat))
    longest = (2 * np.hypot(*course.steps.T) + 2 + TWO_PI)[:, None]
    for _ in range(solver.count):  # one by one: time may be up long before the last
        if shares is None:
            length = (random.uniform(0.0, 2 / n, (course.legs, n)) * longest).ravel()
        else:
            length = (shares * random.uniform(0.0, 1.0, (course.legs, 1)) * longest).ravel()
        turn = random.uniform(rates.lower, rates.upper, length.size) * length
        yield Guess("random", Elements(turn, length))


def _given(question: Question, course: Course, n: int, shares: FloatArray | None) -> list[Guess]:
    """The question's own path as a guess.

    It is cut where it is nearest to the points in turn. The list is empty if there is no path, or
    if it cannot be driven.
    """
    path = question.guess_in_radii
    if path is None:
        return []
    places = np.linspace(0.0, path.length, _SAMPLES * course.legs + 1)
    points = np.cumsum(course.steps, axis=0)[:-1, None]
    away = np.hypot(*(path.at(places)[:, :2] - points).T)
    ends = places[:0]
    if len(points):
        # a leg ends where the path is nearest to the leg's point, but not before its own beginning
        ends = np.maximum.accumulate(places[away.argmin(axis=0)])
    bounds = np.concatenate(([0.0], ends, [path.length]))
    begins = np.cumsum(path.lengths) - path.lengths
    legs = []
    for a, b in pairwise(bounds):
        # the length that each arc has between a and b
        lengths = np.clip(path.lengths + begins, a, b) - np.clip(begins, a, b)
        legs.append(Path(HERE, path.curvatures, lengths))
    return [Guess("warm", _cut_legs(legs, n, shares))]
