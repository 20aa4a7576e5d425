"""`headings`: the heading at each point is an unknown.

The length is the sum of exact shortest legs. It has a kink where the shortest word of a leg
changes. It jumps where points are less than 4 radii apart. A path of any headings passes all
points, so that every set of headings is an answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.course import path_of
from dubins_study.solvers.engines import SearchSolver, names, others, packages
from dubins_study.solvers.legs import WORD_TURNS, Route, route_of
from dubins_study.solvers.nlp_engines.program import (
    Entries,
    Expressions,
    Functions,
    NlpCall,
    Program,
)
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.runs import EngineResult, Run, at_start, no_solution, spent, timed
from dubins_study.solvers.setting_checks import iterations, one_of, option_set, tolerance, whole
from dubins_study.solvers.stochastic.penalty_function import CountedFunction, Task
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.closed_form.pose import pose_curvatures, pose_gradient
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import DERIVATIVE_FREE, IN_ORDER, NLP, SAMPLING, Claim

# The engines of nonlinear programs that call functions. The others differentiate expressions, and
# the shortest of six words is none.
_CALLERS = (
    "slsqp",
    "trust-constr",
    "cobyqa",
    "nlopt-slsqp",
    "nlopt-auglag",
    "nlopt-cobyla",
    "uno-filtersqp",
)
# SHGO begins with all corners of the box: 2^k, which for 50 legs fills the memory
_ENGINES = (
    *(name for name in names(DERIVATIVE_FREE, SAMPLING) if name != "shgo"),
    *_CALLERS,
)
_DEFAULT = "differential-evolution"
_MOST_EVALUATIONS = 10**5  # of one search, if none are given: DIRECT takes memory for all at once
_HALF_TURN = math.pi
Trace = list[tuple[int, FloatArray]]  # evaluations until then, and the best point (k,)


@dataclass(frozen=True)
class Headings(SearchSolver):
    """The headings at the points of a route.

    Engines search for them or go downhill.

    Args:
        engine: a name in `solvers.engines` of a kind that searches, or of one of nonlinear programs
            that calls functions.
        initial_guess: where an engine that needs a guess begins: `bearing` (at each point toward
            the next one) or `random`. Engines that search the whole box take none.
        count: number of random guesses.
        seed: of all random numbers, together with the question's repeat.
        options, tol, max_iter: as those of `nlp`; searches take no limits but `evaluations`.
        evaluations: most evaluations of the length in a search; 0 for the engine's default
            (`solvers.engines`) times the number of unknown headings, at most 100 000.
        restarts: whether a search that ends earlier begins anew until the evaluations are spent.
        trace: whether the best headings so far are kept, with the evaluations that found them.
    """

    engine: str = one_of(_DEFAULT, _ENGINES)
    initial_guess: str = one_of("bearing", ("bearing", "random"))
    count: int = whole(10, 1, 10**9)
    seed: int = whole(0, 0, 10**9)
    options: str = option_set()
    tol: float = tolerance()
    max_iter: int = iterations()
    evaluations: int = whole(0, 0, 10**6)
    restarts: bool = False
    trace: bool = False

    name = "headings"
    guarantee = Guarantee.STOCHASTIC
    takes = IN_ORDER
    packages = packages(_ENGINES)
    summary = "headings at the points of a route, exact legs between them"
    variants = others("headings", _ENGINES, _DEFAULT)

    @property
    def method(self) -> Method:
        return Method("headings", self.library.label, self.guess)

    @property
    def keeps_limit(self) -> bool:
        # of an NLP engine an iteration on hundreds of headings may take seconds
        return super().keeps_limit and self.library.kind != NLP

    def build(self, question: Question) -> tuple[Question, Route]:
        route = route_of(question.scenario)
        route_length(route, route.toward_next())  # loads the compiled loops, for a second
        return question, route

    def solve(self, model: tuple[Question, Route], limit: float) -> Solution:
        question, route = model
        scenario = question.scenario
        if there := at_start(scenario, route.target):
            return there
        trace: Trace = []
        runs = list(self._runs(route, question.repeat, perf_counter() + limit, trace))
        runs_with_length = [run for run in runs if np.isfinite(run.length)]
        if not runs_with_length:
            return no_solution(runs)
        best = min(runs_with_length, key=lambda run: run.length)
        claim = Claim.FEASIBLE
        if best.claim is Claim.LOCAL:
            claim = Claim.LOCAL
        return Solution(
            claim,
            path=_path(scenario, route, best.point),
            trace=tuple((count, _path(scenario, route, point)) for count, point in _thinned(trace)),
            claimed_length=best.length * scenario.radius,
            message=best.result.message,
            **spent(runs, best),
        )

    def _runs(
        self, route: Route, repeat: int, until: float, trace: Trace
    ) -> Iterator[Run[FloatArray]]:
        """Runs of the engine, one for each guess.

        A run's point holds the unknown headings (k,). Each run extends `trace` in place if the
        setting `trace` is on.
        """
        random = np.random.default_rng(self.seed + repeat)
        solve = partial(self._solved, route, random, trace)
        run = timed("headings", solve, partial(route_length, route))
        is_random = self.initial_guess == "random" and route.unknowns > 0
        count = 1
        if is_random:
            count = self.count
        for _ in range(count):
            if perf_counter() > until:
                return
            guess = route.toward_next()
            if is_random:
                guess = random.uniform(0.0, TWO_PI, route.unknowns)
            yield run(guess, until)

    def _solved(
        self,
        route: Route,
        random: np.random.Generator,
        trace: Trace,
        guess: FloatArray,
        seconds: float,
    ) -> EngineResult:
        """Run the engine from a guess.

        The guess and the result hold the unknown headings, (k,).
        """
        if route.unknowns == 0:
            return EngineResult(
                guess, Claim.FEASIBLE, evaluations=1, message="no heading is unknown"
            )
        if self.library.kind == NLP:
            return self._descend(route, trace, guess, seconds)
        return self._search(route, random, trace, guess, seconds)

    def _descend(
        self, route: Route, trace: Trace, guess: FloatArray, seconds: float
    ) -> EngineResult:
        """Run an engine of nonlinear programs; extend the trace."""
        engine: NlpCall = self.library.load()(self.tol, self.max_iter, self.options)
        functions = _functions(route)
        if not self.trace:
            return engine(program(route, functions), guess, seconds)
        # no limits: the function is counted only to record the trace
        whole_plane = LengthInBox(route, np.zeros(route.unknowns))
        counted = CountedFunction(whole_plane, math.inf, math.inf)
        functions = functions._replace(objective=counted)
        result = engine(program(route, functions), guess, seconds)
        _add(trace, counted, 0.0)
        return result

    def _search(
        self,
        route: Route,
        random: np.random.Generator,
        trace: Trace,
        guess: FloatArray,
        seconds: float,
    ) -> EngineResult:
        """Run a search of a box; extend the trace.

        The box has a full turn for each heading. The guess is in its middle if the engine takes
        one.
        """
        k = route.unknowns
        until = perf_counter() + seconds
        low = np.full(k, route.first)  # the box's corner; the search sees headings minus `low`
        begin = None
        if self.guided:
            low = guess - _HALF_TURN
            begin = np.full(k, _HALF_TURN)
        budget = self.evaluations or min(self.library.evaluations * k, _MOST_EVALUATIONS)
        function = CountedFunction(LengthInBox(route, low), budget, until)
        result = Task(function, begin, random).search(self.engine, self.options, self.restarts)
        if self.trace:
            _add(trace, function, low)
        return result._replace(x=low + result.x)


class LengthInBox:
    """A route's length as a function in a box.

    The headings are `low` + x, with each x in a full turn.
    """

    def __init__(self, route: Route, low: FloatArray) -> None:
        self._route = route
        self._low = low
        self.upper: FloatArray = np.full(low.size, TWO_PI)

    def at(self, free: FloatArray) -> float:
        """The length at one point, shape (k,)."""
        return route_length(self._route, self._low + free)

    def at_each(self, free: FloatArray) -> FloatArray:
        """The lengths at several points.

        Shape (k, points) -> (points,).
        """
        segments, _ = self._route.shortest(self._route.headings(self._low[:, None] + free))
        lengths: FloatArray = segments.sum(axis=(0, 1))
        return lengths


def route_length(route: Route, unknown: FloatArray) -> float:
    """The length (radii) of a route.

    It is the sum of the shortest legs between the headings. `unknown` has shape (k,).
    """
    segments, _ = route.shortest(route.headings(unknown))
    return float(segments.sum())


def _path(scenario: Scenario, route: Route, unknown: FloatArray) -> Path:
    segments, words = route.shortest(route.headings(unknown))
    return path_of(scenario, WORD_TURNS[words].ravel(), segments.T.ravel())


def _add(trace: Trace, run: CountedFunction, low: FloatArray | float) -> None:
    """Extend a trace in place by a run's trace.

    The run's evaluations count on from those of the trace. The run's points are headings minus
    `low`. A last entry repeats the run's best point with all of the run's evaluations.
    """
    if run.trace:
        before = 0
        if trace:
            before = trace[-1][0]
        trace += [(before + count, low + point) for count, point in run.trace]
        trace.append((before + run.evaluations, trace[-1][1]))


def _thinned(trace: Trace) -> Trace:
    """The trace with fewer points.

    Of points within a tenth more evaluations than the point before them, only the last stays. The
    very last point of the trace always stays.
    """
    thinned: Trace = []
    for count, point in trace:
        if len(thinned) > 1 and count < 1.1 * thinned[-2][0]:
            thinned.pop()
        thinned.append((count, point))
    return thinned


def program(route: Route, functions: Functions | None = None) -> Program:
    """The unknown headings as a program without equations.

    They have no bounds.
    """
    free = np.full(route.unknowns, np.inf)
    return Program(
        _no_expressions,
        p=free[:0],
        lower=-free,
        upper=free,
        written=functions or _functions(route),
    )


def _no_expressions() -> Expressions:
    raise NotImplementedError("the shortest of six words is no expression of casadi's")


def _functions(route: Route) -> Functions:
    """A route's length and its derivatives, without equations."""
    k = route.unknowns

    def derivatives(unknown: FloatArray, function: Any) -> FloatArray:
        """A function's values for all legs, shape (n, ...).

        The function takes the index of a leg's word, and the leg's three segments.
        """
        segments, words = route.shortest(route.headings(unknown))
        legs = zip(words.tolist(), *segments.tolist(), strict=True)
        return np.array([function(*leg) for leg in legs])

    def gradient(unknown: FloatArray) -> FloatArray:
        slopes = derivatives(unknown, pose_gradient)  # by the leg's first and last heading
        # a heading is the last one of a leg and the first one of the next
        behind = np.append(slopes[1:, 0], 0.0)
        total: FloatArray = slopes[:, 1] + behind
        return total[:k]

    def bands(unknown: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The Hessian's diagonal and the one below.

        No other entry differs from zero, since a heading is in two legs only.
        """
        curved = derivatives(unknown, pose_curvatures)  # 11, 12 and 22 of each leg
        diagonal: FloatArray = curved[:, 2] + np.append(curved[1:, 0], 0.0)
        return diagonal[:k], curved[1:k, 1]

    def hessian(unknown: FloatArray, weights: FloatArray) -> FloatArray:
        diagonal, below = bands(unknown)
        total: FloatArray = np.diag(diagonal) + np.diag(below, 1) + np.diag(below, -1)
        return total

    none = np.empty(0)
    slope_of_none = np.empty((0, k))
    places = np.arange(k)
    return Functions(
        objective=lambda unknown: route_length(route, unknown),
        gradient=gradient,
        equations=lambda unknown: none,
        jacobian=lambda unknown: slope_of_none,
        hessian=hessian,
        entries=Entries(
            np.empty((2, 0), dtype=np.intp),
            lambda unknown: none,
            np.array((np.append(places, places[1:]), np.append(places, places[:-1]))),
            lambda unknown, weight, weights: weight * np.concatenate(bands(unknown)),
        ),
    )
