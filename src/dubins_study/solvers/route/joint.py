"""`route-nlp`: the paper's model (4.12) for several legs.

Each leg has the arcs L R S L R. They hold all six words of a leg, and words of two arcs. With the
words known, only their arcs stay: there is one NLP for each sequence of words. For one leg with a
free final heading it is the NLP of a word. The heading after each leg is one more unknown. It makes
the Jacobian's blocks meet in one column; without it every equation would hold the arcs of all legs
before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.course import heading_gap, path_of
from dubins_study.solvers.engines import (
    NLP_ENGINES,
    EngineSolver,
    engine_or_program,
    others,
    packages,
)
from dubins_study.solvers.legs import Route, route_of
from dubins_study.solvers.nlp_engines.program import (
    Expressions,
    NlpCall,
    Program,
    Stages,
)
from dubins_study.solvers.protocol import Method, Question, Solution
from dubins_study.solvers.runs import (
    Attempts,
    EngineResult,
    Run,
    at_start,
    best_run_and_claim,
    no_solution,
    run_attempts,
    spent,
    timed,
)
from dubins_study.solvers.setting_checks import iterations, one_of, option_set, tolerance, whole
from dubins_study.solvers.tour.order_headings import headings_on_grid
from dubins_study.solvers.tour.places import places_of
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import IN_ORDER, TURN, Claim

_LETTERS = "LRSLR"
_TURNS = tuple(TURN[letter] for letter in _LETTERS)
_ARCS = np.array([turn != 0.0 for turn in _TURNS])
_GUESSES = ("bearing", "one", "words", "straight", "zero", "random")
_PER_LEG = len(_LETTERS) + 1  # unknowns: the arcs, and the heading after them
# where the three segments of each of `pose.WORDS6` stand among the arcs of a leg
_PLACES = ((0, 2, 3), (1, 2, 4), (0, 2, 4), (1, 2, 3), (1, 3, 4), (0, 1, 3))


_ALL = tuple(range(len(_LETTERS)))

# For each leg, which of the arcs L R S L R are unknown.
Places = tuple[tuple[int, ...], ...]


class PosedRoute(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    route: Route
    places: Places
    program: Program
    grid_headings: FloatArray | None  # of model `words`: those to which its words belong


@dataclass(frozen=True)
class RouteNlp(EngineSolver):
    """All arcs of a route, by an NLP engine.

    Args:
        engine: a name in `solvers.engines` of an engine that reads any program, or the name of an
            executable on PATH that reads NL files.
        model: `joint` leaves all five arcs of a leg open; `words` leaves only the arcs of one word.
            A dynamic program over a grid of headings finds this word beforehand, with the closed
            form of a leg.
        headings: number of headings of that grid at each point.
        initial_guess: the kind of guess. `one`: turn toward the next point, then go straight.
            `bearing`: `one`, and if it fails for one leg with a free final heading, `words`.
            `words`: for the model `joint` the shortest legs between headings toward the next
            points, which give the engine a word for each leg; for the model `words` the path on
            the grid. `straight`: the lines between the points, with their headings. `zero`: all
            unknowns zero. `random`: arcs up to a full turn, straights up to twice the distance
            plus 2.
        seed: of random guesses; the number of the repeat is added to it.
        count: number of random guesses.
        options, tol, max_iter: as those of `nlp`.
    """

    engine: str = engine_or_program("ipopt", NLP_ENGINES)
    model: str = one_of("joint", ("joint", "words"))
    headings: int = whole(24, 4, 1000)
    initial_guess: str = one_of("bearing", _GUESSES)
    seed: int = whole(0, 0, 2**32)
    count: int = whole(10, 1, 10**9)
    options: str = option_set()
    tol: float = tolerance()
    max_iter: int = iterations()

    name = "route-nlp"
    takes = IN_ORDER
    packages = packages(NLP_ENGINES)
    summary = "the paper's model (4.12) with the arcs L R S L R a leg"
    keeps_limit = False  # at 50 legs compiling or a dense engine's iteration takes up to 5 s
    variants = others("route-nlp", NLP_ENGINES, "ipopt")
    profiles: ClassVar = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        posed = "joint NLP, LRSLR a leg"
        knows = ""
        if self.model == "words":
            posed = "one NLP a word"
            knows = "formula"  # the words come from the closed form, by a dynamic program
        method = self.library.method(posed, self.initial_guess, self.options, self.tol)
        return method._replace(knows=knows)

    def build(self, question: Question) -> PosedRoute:
        route = route_of(question.scenario)
        places = (_ALL,) * route.legs
        grid_headings = None
        if self.model == "words":
            tour = places_of(question.scenario)
            grid_headings = headings_on_grid(tour, list(range(tour.count)), self.headings)
            places = word_places(route, grid_headings)
        return PosedRoute(question, route, places, program(route, places), grid_headings)

    def solve(self, model: PosedRoute, limit: float) -> Solution:
        places = model.places
        # at zero no constraint qualification holds, as in (4.12)
        if there := at_start(model.question.scenario, model.route.target):
            return there
        engine: NlpCall = self.library.load()(self.tol, self.max_iter, self.options)

        def solve(guess: FloatArray, seconds: float) -> EngineResult:
            return engine(model.program, _unknowns_of(guess, places), seconds)

        def length(x: FloatArray) -> float:
            return float(_arcs(x, places).sum())

        run = timed(self.model, solve, length)
        enough = self.initial_guess == "bearing"  # of the other kinds every guess is tried
        attempts = Attempts(self._guesses(model), run, lambda _: enough)
        return _answer(model, run_attempts([attempts], perf_counter() + limit))

    def first_guess(self, model: PosedRoute) -> FloatArray:
        """The first initial guess.

        It is a point of the question's own program.
        """
        return _unknowns_of(next(self._guesses(model)), model.places)

    def _guesses(self, model: PosedRoute) -> Iterator[FloatArray]:
        """Points x of the joint program, shape (6 n,)."""
        route = model.route
        if self.initial_guess in ("bearing", "one"):
            yield turned_guess(route)
            if self.initial_guess == "bearing" and route.target is not None:
                yield words_guess(route, model.grid_headings)
        elif self.initial_guess == "words":
            yield words_guess(route, model.grid_headings)
        elif self.initial_guess == "straight":
            yield straight_guess(route)
        elif self.initial_guess == "zero":
            yield np.zeros(_PER_LEG * route.legs)
        else:
            random = np.random.default_rng(self.seed + model.question.repeat)
            for _ in range(self.count):
                yield random_guess(route, random)


def _answer(model: PosedRoute, runs: list[Run[FloatArray]]) -> Solution:
    """The answer of all runs.

    It is the shortest point that the engine calls a solution, or else the one that misses least.
    """
    if not runs:
        return no_solution(runs)
    scenario = model.question.scenario
    equations = model.program.functions.equations
    best, claim = best_run_and_claim(runs, lambda run: float(np.abs(equations(run.point)).sum()))
    n = model.route.legs
    duals = best.result.duals
    path = None
    if claim is not Claim.LOCALLY_INFEASIBLE and np.isfinite(best.point).all():
        arcs = _driven(_arcs(best.point, model.places))
        path = path_of(scenario, _TURNS * n, arcs.ravel().tolist())
    claimed_length = None
    if claim is Claim.LOCAL:
        claimed_length = best.length * scenario.radius
    multipliers = None
    if duals is not None:
        multipliers = tuple(duals[3 * n - 2 : 3 * n])  # those of the last leg's end
    return Solution(
        claim,
        path=path,
        claimed_length=claimed_length,
        multipliers=multipliers,
        message=best.result.message,
        **spent(runs, best),
    )


def program(route: Route, places: Places = ()) -> Program:
    """A route's program.

    Each arc is an unknown, and so is the heading after each leg. There are 3 equations a leg, and
    one for a final heading. Without `places` all arcs are unknown.
    """
    places = places or (_ALL,) * route.legs
    upper = np.where(_ARCS, TWO_PI, math.inf)
    highest = np.tile([*upper, math.inf], route.legs)
    lowest = np.tile([*np.zeros(_ARCS.size), -math.inf], route.legs)
    words_known = any(leg != _ALL for leg in places)
    turns = [_TURNS[place] for leg in places for place in leg]
    if not words_known:
        turns = []
    return Program(
        expressions(tuple(map(len, places)), route.last is not None, words_known),
        p=np.concatenate((route.steps.ravel(), route.given_headings, turns)),
        lower=_unknowns_of(lowest, places),
        upper=_unknowns_of(highest, places),
        magnitude=float(np.hypot(*route.steps.T).max()),
    )


@lru_cache(maxsize=64)
def expressions(arcs: tuple[int, ...], final_heading: bool, known: bool) -> Expressions:
    """(4.12) for legs with given numbers of arcs.

    The program is in the world's directions and units of the radius. If the words are `known`, the
    turns 1, 0 or -1 of their arcs are parameters: all sequences share a program. Otherwise the arcs
    are L R S L R. The parameters p are the steps (2 legs,), the first heading, the final heading if
    given, and the turns if known.
    """

    import casadi

    legs = len(arcs)
    n = sum(arcs)
    x = casadi.SX.sym("x", n + legs)
    p = casadi.SX.sym("p", 2 * legs + 1 + final_heading + n * known)
    turns: Any = _TURNS * legs
    if known:
        turns = casadi.vertsplit(p[p.numel() - n :])
    unknown = iter(casadi.vertsplit(x))
    turned = iter(turns)
    heading = p[2 * legs]
    length = casadi.SX(0)
    equations = []
    for leg, count in enumerate(arcs):
        along = 0
        across = 0
        after = heading
        for _ in range(count):
            arc = next(unknown)
            turn = next(turned)
            # an arc's chord, 2 sin(arc / 2), or a straight, along the mean heading
            half = turn * arc / 2
            chord = (1 - turn * turn) * arc + 2 * turn * casadi.sin(half)
            along += chord * casadi.cos(after + half)
            across += chord * casadi.sin(after + half)
            after += turn * arc
            length += arc
        heading = next(unknown)
        equations += [heading - after, p[2 * leg] - along, p[2 * leg + 1] - across]
    if final_heading:
        equations.append(heading_gap(heading, p[2 * legs + 1]))
    # a control problem: the heading is its state, the arcs of a leg are its controls
    stages = Stages(
        nx=(0, *(1,) * legs),
        nu=(*arcs, 0),
        ng=(*(2,) * legs, int(final_heading)),
    )
    return Expressions(x, p, f=length, g=casadi.vertcat(*equations), stages=stages)


def word_places(route: Route, headings: FloatArray) -> Places:
    """The arcs of the shortest legs between headings.

    The headings have shape (n + 1,). Returns for each leg the places of its arcs among L R S L R:
    (0, 2, 4) for LSR.

    A path to a free final heading has a turn and a straight, or two turns. So one of the last leg's
    three pieces is left out: the shortest one that leaves such a word.
    """
    segments, words = route.shortest(headings)
    places: list[tuple[int, ...]] = [_PLACES[word] for word in words]
    if route.last is None:
        pieces = places[-1]
        candidates = {}
        for drop in range(3):
            pair = pieces[:drop] + pieces[drop + 1 :]
            first, last = pair
            is_word = _ARCS[first] and _TURNS[first] != _TURNS[last]
            if is_word:  # a turn, and then another letter
                candidates[drop] = pair
        places[-1] = candidates[min(candidates, key=lambda drop: float(segments[drop, -1]))]
    return tuple(places)


def turned_guess(route: Route) -> FloatArray:
    """The guess of one turn, then one straight.

    The turn at each point goes the shorter way round toward the next point.
    """
    first, straight, last = route.turned().T
    # L R S L R: a turn to the right is one to the left with the other sign
    arcs = (np.maximum(turn, 0.0) for turn in (first, -first, straight, last, -last))
    return _point(route, np.column_stack(list(arcs)))


def words_guess(route: Route, headings: FloatArray | None = None) -> FloatArray:
    """The guess of the shortest legs between headings.

    Without `headings` they are those toward the next points.
    """
    if headings is None:
        headings = route.headings(route.toward_next())
    segments, words = route.shortest(headings)
    arcs = np.zeros((len(words), len(_LETTERS)))
    for leg, word in enumerate(words):
        arcs[leg, list(_PLACES[word])] = segments[:, leg]
    return _point(route, arcs)


def straight_guess(route: Route) -> FloatArray:
    """The guess of the lines between the points.

    The headings are those of the lines.
    """
    arcs = np.zeros((route.legs, _PER_LEG))
    arcs[:, _LETTERS.index("S")] = np.hypot(*route.steps.T)
    arcs[:, -1] = route.bearings()
    return arcs.ravel()


def random_guess(route: Route, random: np.random.Generator) -> FloatArray:
    """A random guess.

    Arcs go up to a full turn, straights up to twice the distance plus 2.
    """
    most = np.tile(np.where(_ARCS, TWO_PI, 0.0), (len(route.steps), 1))
    most[:, ~_ARCS] = 2 * np.hypot(*route.steps.T)[:, None] + 2
    return _point(route, most * random.uniform(size=most.shape))


def _point(route: Route, arcs: FloatArray) -> FloatArray:
    """The point x of arcs, shape (n, 5).

    It holds the arcs of each leg, and the heading after them.
    """
    after = route.first + np.cumsum(arcs @ np.array(_TURNS))
    return np.column_stack((arcs, after)).ravel()


def _unknowns_of(point: FloatArray, places: Places) -> FloatArray:
    """A joint point, reduced to the program's unknowns.

    The joint point has shape (6 n,). The unknowns of a leg are the arcs at its places, and the
    heading after the leg.
    """
    legs = zip(point.reshape(-1, _PER_LEG), places, strict=True)
    return np.concatenate([[*leg[list(leg_places)], leg[-1]] for leg, leg_places in legs])


def _arcs(point: FloatArray, places: Places) -> FloatArray:
    """All arcs of a program's point, shape (n, 5).

    Arcs that the program does not have are 0.
    """
    arcs = np.zeros((len(places), len(_LETTERS)))
    position = 0
    for leg, leg_places in enumerate(places):
        arcs[leg, list(leg_places)] = point[position : position + len(leg_places)]
        position += len(leg_places) + 1
    return arcs


def _driven(arcs: FloatArray) -> FloatArray:
    """Arcs that a path can have, shape (n, 5).

    An engine may leave some arcs below zero. A turn of -a one way is a turn of +a the other way,
    so it is added to the neighbouring arc. Setting it to zero would rotate all later legs.
    """
    turns = [0, 1, 3, 4]
    others = [1, 0, 4, 3]  # the neighbour of each: 0 <-> 1, 3 <-> 4
    driven = np.maximum(arcs, 0.0)
    driven[:, others] -= np.minimum(arcs[:, turns], 0.0)
    return driven
