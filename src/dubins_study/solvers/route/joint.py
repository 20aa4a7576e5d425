"""`route-nlp`: the paper's model (4.12) for several legs, each with the arcs L R S L R.

They hold all six words of a leg, and two arcs. The heading after each leg is one more unknown,
which makes the Jacobian's blocks meet in one column: without it every equation would hold the arcs
of all legs before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.answers import Attempts, Run, at_start, best_of, costs, tried
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, EngineSolver, packages
from dubins_study.solvers.nlp_engines.program import (
    DeferredExpressions,
    Expressions,
    NlpCall,
    Program,
)
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.route.legs import Route, path_of, route_of
from dubins_study.solvers.setting_checks import one_of, positive, whole, within
from dubins_study.study.path import FloatArray
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import NEEDS, TURN, Claim

_LETTERS = "LRSLR"
_TURNS = tuple(TURN[letter] for letter in _LETTERS)
_ARCS = np.array([turn != 0.0 for turn in _TURNS])
_FULL_TURN = 2 * math.pi
_PER_LEG = len(_LETTERS) + 1  # unknowns: the arcs, and the heading after them
# where the three segments of each of `pose.WORDS6` stand among the arcs of a leg
_PLACES = ((0, 2, 3), (1, 2, 4), (0, 2, 4), (1, 2, 3), (1, 3, 4), (0, 1, 3))


class PosedRoute(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    route: Route
    program: Program


@dataclass(frozen=True)
class RouteNlp(EngineSolver):
    """All arcs of a route at once, by an NLP engine.

    Args:
        engine: a name in `solvers.engines` of an engine that reads any program.
        initial_guess: `bearing` (turn toward the next point, then go straight), `words` (the
            shortest legs between headings toward the next points, which tells the engine a word a
            leg) or `random` (arcs up to a full turn, straights up to twice the distance plus 2).
        seed: of random guesses; the number of the repeat is added to it.
        count: number of random guesses.
        tol, max_iter: as those of `nlp`.
    """

    engine: str = one_of("ipopt", NLP_ENGINES)
    initial_guess: str = one_of("bearing", ("bearing", "words", "random"))
    seed: int = whole(0, 0, 2**32)
    count: int = whole(10, 1, 10**9)
    tol: float = within(1e-9, 1e-14, 1e-2)
    max_iter: int = positive(200)

    name: ClassVar[str] = "route-nlp"
    takes: ClassVar[frozenset[str]] = frozenset(NEEDS)
    packages: ClassVar[tuple[str, ...]] = packages(NLP_ENGINES)
    summary: ClassVar[str] = "the paper's model (4.12) with the arcs L R S L R a leg"
    guarantee: ClassVar[Guarantee] = Guarantee.LOCAL
    variants: ClassVar[tuple[str, ...]] = tuple(
        f"route-nlp[engine={engine}]" for engine in NLP_ENGINES if engine != "ipopt"
    )
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        engine = ENGINES[self.engine]
        tol = engine.fixed_tol or self.tol
        return Method("joint NLP, LRSLR a leg", engine.label, self.initial_guess, tol)

    @property
    def keeps_limit(self) -> bool:
        # at 50 legs a dense engine's iteration takes up to 5 s, and so does compiling
        return False

    def build(self, question: Question) -> PosedRoute:
        route = route_of(question.scenario)
        return PosedRoute(question, route, program(route))

    def solve(self, model: PosedRoute, limit: float) -> Solution:
        question, route, program = model
        # at zero no constraint qualification holds, as in (4.12)
        if question.scenario.one_free_leg and (there := at_start(question)):
            return there
        engine: NlpCall = ENGINES[self.engine].load()(self.tol, self.max_iter)

        def run(guess: FloatArray, until: float) -> Run[FloatArray]:
            began = perf_counter()
            result = engine(program, guess, until - began)
            seconds, length = perf_counter() - began, float(_arcs(result.x).sum())
            return Run(_LETTERS, seconds, *result, length=length)

        guesses = self._guesses(route, question.repeat)
        attempts = Attempts(guesses, run, lambda run: False)  # every guess is tried
        return _answer(model, tried([attempts], perf_counter() + limit))

    def _guesses(self, route: Route, repeat: int) -> Iterator[FloatArray]:
        """Points x of the program, shape (6 n,)."""
        if self.initial_guess == "bearing":
            yield turned_guess(route)
        elif self.initial_guess == "words":
            yield words_guess(route)
        else:
            random = np.random.default_rng(self.seed + repeat)
            for _ in range(self.count):
                yield random_guess(route, random)


def _answer(model: PosedRoute, runs: list[Run[FloatArray]]) -> Solution:
    """The shortest point that the engine calls a solution, or the one that misses least."""
    if not runs:
        return Solution(Claim.LIMIT, message="no time to begin")
    question, route, program = model
    scenario, equations = question.scenario, program.functions.equations
    solved = [run for run in runs if run.claim is Claim.LOCAL]

    def with_miss(run: Run[FloatArray]) -> Run[FloatArray]:
        missed = float(np.abs(equations(run.point)).sum())
        return run._replace(miss=missed if math.isfinite(missed) else math.inf)

    best = best_of(solved, map(with_miss, runs))
    claims = {run.claim for run in runs}
    claim = Claim.LOCAL if solved else claims.pop() if len(claims) == 1 else Claim.FAILED
    if claim is Claim.INFEASIBLE or (claim is Claim.FEASIBLE and not best.miss <= ARRIVES):
        # A path always exists: infeasible is the engine's word of its own neighbourhood. What is
        # feasible to its tolerance may pass the points by.
        claim = Claim.FAILED
    n = len(route.steps)
    path = None
    if np.isfinite(best.point).all():
        path = path_of(scenario, _TURNS * n, _driven(_arcs(best.point)).ravel().tolist())
    return Solution(
        claim,
        path=path,
        claimed_length=best.length * scenario.radius if solved else None,
        # those of the last leg's end
        multipliers=None if best.duals is None else tuple(best.duals[3 * n - 3 : 3 * n - 1]),
        native_status=best.status,
        message=best.message,
        best_run=best.effort,
        **costs(runs),
    )


def program(route: Route) -> Program:
    """A route's program: 6 unknowns a leg, 3 equations, and one for a final heading."""
    ends = [route.first] if route.last is None else [route.first, route.last]
    lower = np.tile([*np.zeros(_ARCS.size), -math.inf], len(route.steps))
    upper = np.tile([*np.where(_ARCS, _FULL_TURN, math.inf), math.inf], len(route.steps))
    return Program(
        expressions(len(route.steps), route.last is not None),
        *(np.append(route.steps.ravel(), ends), lower, upper),
        magnitude=float(np.hypot(*route.steps.T).max()),
    )


@lru_cache(maxsize=64)
def expressions(legs: int, final_heading: bool) -> Expressions:
    """(4.12) for each leg, in the world's directions and units of the radius."""

    def write() -> Expressions:
        import casadi

        sin, cos = casadi.sin, casadi.cos
        x = casadi.SX.sym("x", _PER_LEG * legs)
        p = casadi.SX.sym("p", 2 * legs + 1 + final_heading)
        heading, equations, length = p[2 * legs], [], casadi.SX(0)
        for leg in range(legs):
            *arcs, end = casadi.vertsplit(x[_PER_LEG * leg : _PER_LEG * (leg + 1)])
            a, b, straight, c, d = arcs
            first = heading + a  # headings after each arc
            second = first - b
            third = second + c
            across = 2 * (sin(first) - sin(second) + sin(third)) - sin(heading) - sin(end)
            along = 2 * (cos(second) - cos(first) - cos(third)) + cos(heading) + cos(end)
            equations += [
                p[2 * leg] - across - straight * cos(second),
                p[2 * leg + 1] - along - straight * sin(second),
                third - d - end,
            ]
            length += sum(arcs)
            heading = end
        if final_heading:
            # Zero at the heading and whole turns from it, where its slope is 1 or -1: a difference
            # would fix the number of turns, sine and cosine as two equations have dependent
            # gradients, and the sine alone is zero at the opposite heading too.
            equations.append(2 * sin((heading - p[2 * legs + 1]) / 2))
        return Expressions(x, p, length, casadi.vertcat(*equations))

    return DeferredExpressions(write)


def turned_guess(route: Route) -> FloatArray:
    """At each point one turn toward the next, the shorter way round, and a straight line."""
    steps = route.steps
    bearings = np.arctan2(steps[:, 1], steps[:, 0])
    turns = _wrapped(np.diff(bearings, prepend=route.first))
    zeros = np.zeros(len(steps))
    last = zeros.copy()
    if route.last is not None:
        last[-1] = _wrapped(route.last - bearings[-1])
    left, right = np.maximum([turns, last], 0.0), np.maximum([-turns, -last], 0.0)
    return _point(route, np.array((left[0], right[0], np.hypot(*steps.T), left[1], right[1])).T)


def words_guess(route: Route) -> FloatArray:
    """The shortest legs between headings toward the next points."""
    segments, words = route.legs(route.headings(route.toward_next()))
    arcs = np.zeros((len(words), len(_LETTERS)))
    for leg, word in enumerate(words):
        arcs[leg, list(_PLACES[word])] = segments[:, leg]
    return _point(route, arcs)


def random_guess(route: Route, random: np.random.Generator) -> FloatArray:
    """Arcs up to a full turn, straights up to twice the distance plus 2."""
    most = np.tile(np.where(_ARCS, _FULL_TURN, 0.0), (len(route.steps), 1))
    most[:, ~_ARCS] = 2 * np.hypot(*route.steps.T)[:, None] + 2
    return _point(route, most * random.uniform(size=most.shape))


def _point(route: Route, arcs: FloatArray) -> FloatArray:
    """The point x of arcs, shape (n, 5): each leg's arcs, and the heading after them."""
    after = route.first + np.cumsum(arcs @ np.array(_TURNS))
    return np.column_stack((arcs, after)).ravel()


def _arcs(point: FloatArray) -> FloatArray:
    """The arcs of a point x, shape (n, 5)."""
    return point.reshape(-1, _PER_LEG)[:, :-1]


def _driven(arcs: FloatArray) -> FloatArray:
    """Arcs that a path can have, shape (n, 5), where an engine left some below zero.

    Such a turn is given to its neighbour the other way: cut off, it would turn all legs after it.
    """
    turns, others = [0, 1, 3, 4], [1, 0, 4, 3]
    driven = np.maximum(arcs, 0.0)
    driven[:, others] -= np.minimum(arcs[:, turns], 0.0)
    return driven


def _wrapped(angle: Any) -> Any:
    """An angle brought to [-pi, pi)."""
    return (angle + math.pi) % _FULL_TURN - math.pi
