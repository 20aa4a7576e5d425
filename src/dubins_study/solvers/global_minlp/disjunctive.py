"""`disjunctive`: the shortest path as a disjunction of words.

Branch and bound proves that no path of any word is shorter than its bound. Its point meets the
target only to a tolerance, so the point is polished.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.arcs import RATES, Elements, close_enough, closed
from dubins_study.solvers.course import Course, body_course, path_of
from dubins_study.solvers.engines import (
    MINLP_ENGINES,
    EngineSolver,
    engine_or_program,
    others,
    packages,
)
from dubins_study.solvers.global_minlp.gdp_model import (
    TRANSFORMATIONS,
    Translated,
    gdp_model,
    pieces,
    steps_in_any_order,
    transformed,
    translated,
)
from dubins_study.solvers.minlp_engines.mixed_program import ProvenResult, Settings
from dubins_study.solvers.one_leg.model import SUBPROBLEMS, as_path
from dubins_study.solvers.one_leg.polish import meet_target
from dubins_study.solvers.presolve import WORDS, words
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.runs import Run, at_start, summed
from dubins_study.solvers.setting_checks import one_of, within
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import Path
from dubins_study.study.words import CLOSED, FREE_ORDER, IN_ORDER, PROVEN, TURN, Claim, Order

# The engine gets this share of the gap; its tolerance on constraints counts as well.
_SHARE = 0.1

# If the engine has no point or fails, it runs again with a tolerance larger by this factor.
_LOOSER = 100

# A point that misses by at most this many tolerances counts as feasible: each of the equations from
# an arc to its end may be off by one tolerance.
_SLACK = 10

# Radii of a straight. For farther targets the words' lengths differ by less than the tolerances.
# Bounds of SCIP above the shortest length were seen from 1e6 radii on, none up to 1e5.
_PROVABLE = 1e5

# Via points in any order. A model of twelve takes seconds to state; no model of five was solved.
_MOST_VIA = 8


class PosedDisjunction(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    course: Course
    words: tuple[str, ...]  # of a last leg to a free final heading
    pyomo: Any  # the transformed model, of a type that its package does not state
    translated: Translated


class Point(NamedTuple):
    """An engine's choice of words and lengths.

    `words` and `pieces` are leg by leg; a piece's length is in radii.
    """

    words: list[str]
    pieces: list[FloatArray]
    steps: FloatArray  # (radii), shape (n, 2)

    @property
    def length(self) -> float:
        return float(sum(each.sum() for each in self.pieces))


class Met(NamedTuple):
    """A path that was moved to meet the points.

    `length` and `miss` are in radii. `meets` says whether the miss is only rounding.
    """

    path: Path
    length: float
    miss: float
    meets: bool


@dataclass(frozen=True)
class Disjunctive(EngineSolver):
    """One disjunct for each word of each leg.

    An engine's branch and bound proves the answer.

    Args:
        engine: `scip`, `maingo`, or the name of an executable on PATH that reads NL files. An
            executable reports no bound, so that its answers are not called optimal.
        transformation: of the disjunctions into linear constraints: `bigm` or `hull`.
        quadrants: whether sines and cosines are of a quarter turn at most; without, they are of
            arcs up to 2 pi, as in the obvious model.
        gap: the largest relative difference of path and bound that counts as proven.
        feastol: the engine's tolerance on constraints (1e-6 by their own defaults).
        emphasis: SCIP's: `lean`, its bare spatial branch and bound, or `default`. The latter has
            heuristics and cutting planes, which take some seventy times as long on the paper's
            problems. It also has presolving and propagation, which work with tolerances of their
            own and now and then cut off the optimum (see docs/decisions.md). MAiNGO runs with its
            defaults.
        presolve: whether words that cannot exist are left out (`solvers.presolve`): the bound then
            holds for the others. Only of one leg with a free final heading.

    A feasible point of the engine may miss the target by the tolerance. Near the front of a turning
    circle such a miss saves up to a full turn, and no polishing closes it. The point is then
    returned as it is, claimed feasible and not optimal. The bound is low there, but still holds. In
    a tour every leg also chooses among the steps between two points, for up to 8 via points.
    `lower_bound` is the engine's bound for the branch that is asked, less its tolerance.
    """

    engine: str = engine_or_program("scip", MINLP_ENGINES)
    transformation: str = one_of("bigm", TRANSFORMATIONS)
    quadrants: bool = True
    # a gap of more than a hundredth proves nothing
    gap: float = within(1e-6, 1e-12, 1e-2)
    # engines take up to 1e-3; a problem that they call infeasible is asked again at 100 times this
    feastol: float = within(1e-8, 1e-12, 1e-5)
    emphasis: str = one_of("lean", ("lean", "default"))
    presolve: bool = False

    name = "disjunctive"
    program_kind = PROVEN
    guarantee = Guarantee.GLOBAL
    branches = ("best", *WORDS)
    takes = IN_ORDER | {FREE_ORDER, CLOSED}
    packages = ("pyomo", *packages(MINLP_ENGINES))
    summary = "one disjunct per word in Pyomo.GDP, proven by SCIP or another engine"
    variants = others("disjunctive", MINLP_ENGINES, "scip")
    profiles: ClassVar = {
        "fast": {"gap": 1e-4, "feastol": 1e-6},
        "accurate": {"gap": 1e-7, "feastol": 1e-9},
    }

    @property
    def method(self) -> Method:
        # the bound is lowered by up to twice the tolerance
        proves = None
        if self.runs is None:
            proves = max(self.gap, 2 * self.feastol)
        return Method(
            formulation="disjunction",
            engine=self.library.label,
            guess="none",
            tolerance=self.feastol,
            proves=proves,
        )

    def build(self, question: Question) -> PosedDisjunction | Solution:
        scenario = question.scenario
        course = body_course(scenario)
        disjuncts = WORDS
        if course.target is not None:
            disjuncts = words(question.branch, course.target, self.presolve)
        steps = None
        if scenario.order is Order.FREE:
            if len(scenario.via) > _MOST_VIA:
                return Solution(
                    Claim.FAILED, message=f"more than {_MOST_VIA} via points in any order"
                )
            steps = steps_in_any_order(course, scenario.target is not None)
        model = gdp_model(course, disjuncts, self.quadrants, steps)
        pyomo = transformed(model, self.transformation)
        return PosedDisjunction(question, course, disjuncts, pyomo, translated(pyomo))

    def solve(self, model: PosedDisjunction | Solution, limit: float) -> Solution:
        if isinstance(model, Solution):
            return model
        there = at_start(model.question.scenario, model.course.target)
        if there is not None:
            return replace(there, claim=Claim.OPTIMAL, lower_bound=0.0)
        until = perf_counter() + limit
        feastol = self.feastol
        runs = [self._run(model, feastol, limit)]
        if runs[0].claim in (Claim.INFEASIBLE, Claim.FAILED):
            # A looser tolerance admits more points: a problem that is infeasible to it too is more
            # surely infeasible. Linear programs that the engine failed to solve are then solved.
            feastol *= _LOOSER
            runs.append(self._run(model, feastol, until - perf_counter()))
        solution = self._answer(model, runs[-1], feastol)
        if not max(straight.ub for straight in model.pyomo.w.values()) <= _PROVABLE:
            solution = _unproven(solution)
        return replace(
            solution,
            efforts=summed(run.effort for run in runs),
            best_run=runs[-1].effort,
        )

    def _run(self, model: PosedDisjunction, feastol: float, seconds: float) -> Run[Point | None]:
        settings = Settings(gap=self.gap * _SHARE, feastol=feastol, lean=self.emphasis == "lean")
        began = perf_counter()
        proven: ProvenResult = self.library.load()(settings)(model.translated.program, seconds)
        seconds = perf_counter() - began
        point = None
        if proven.x is not None:
            point = _point(model, proven.x)
        result = proven.counted(iterations=proven.nodes)
        return Run("all words", seconds, result, point, bound=proven.bound)

    def _answer(self, model: PosedDisjunction, run: Run[Point | None], feastol: float) -> Solution:
        """The solution of a run with the tolerance `feastol`."""
        scenario = model.question.scenario
        # Node bounds come from linear programs solved to the tolerance, not exactly.
        bound = max(0.0, run.bound - feastol * (1 + abs(run.bound)))
        # only `_claim` makes the claim that a path is optimal
        claim = run.claim
        if claim is Claim.OPTIMAL:
            claim = Claim.FEASIBLE
        solution = Solution(
            claim,
            lower_bound=bound * scenario.radius,
            iterations=run.result.iterations,
            native_status=run.result.status,
            message=run.result.message,
        )
        if run.point is None:
            if run.claim is not Claim.INFEASIBLE:
                return solution
            solution = replace(solution, lower_bound=None)
            branch = model.question.branch
            if branch == "best":
                # Every target is reached by some word, so the engine has wrongly cut it off.
                return replace(solution, claim=Claim.FAILED, message="no word left")
            return replace(solution, message=f"{branch} does not reach the target")
        words, met = _met(model, run.point)
        stopped = run.claim is Claim.LIMIT
        claim, message = self._claim(stopped, feastol, bound, met)
        return replace(
            solution,
            claim=claim,
            path=met.path,
            claimed_length=run.point.length * scenario.radius,
            message=f"{words}: {message}",
        )

    def _claim(self, stopped: bool, feastol: float, bound: float, met: Met) -> tuple[Claim, str]:
        """The claim for a polished path, and its reason.

        The engine's own claim holds for the engine's own point only. A path that misses is
        `feasible` if it misses by `_SLACK` tolerances at most, else `failed`. A path that arrives
        is `optimal` if its length is within the gap of the bound. Otherwise its claim is `limit`
        for a run that was `stopped`, else `feasible`.
        """
        if not met.meets:
            message = f"meets the points only to {met.miss:.1e} radii"
            if met.miss <= _SLACK * feastol:
                return Claim.FEASIBLE, message
            return Claim.FAILED, message
        gap = (met.length - bound) / max(met.length, 1.0)
        message = f"within {gap:.1e} of the bound"
        if gap <= self.gap:
            return Claim.OPTIMAL, message
        if stopped:
            return Claim.LIMIT, message
        return Claim.FEASIBLE, message


def _unproven(solution: Solution) -> Solution:
    """The solution without its proof.

    The points are too far apart for the engine's tolerances.
    """
    weaker = {Claim.OPTIMAL: Claim.FEASIBLE, Claim.INFEASIBLE: Claim.FAILED}
    return replace(
        solution,
        claim=weaker.get(solution.claim, solution.claim),
        lower_bound=None,
        message=f"{solution.message}, which proves nothing beyond {_PROVABLE:g} radii",
    )


def _point(model: PosedDisjunction, x: FloatArray) -> Point:
    """The words and lengths of an engine's point."""
    pyomo = model.pyomo
    place = model.translated.place

    def value(variable: Any) -> float:
        return float(x[place[id(variable)]])

    words: list[str] = []
    for leg in pyomo.one_word:
        leg_words = [word for word_leg, word in pyomo.word if word_leg == leg]
        # 1 for the word that is chosen, and 0 for the others, up to the tolerance
        chosen = [value(pyomo.word[leg, word].binary_indicator_var) for word in leg_words]
        words.append(leg_words[int(np.argmax(chosen))])
    lengths = []
    for leg, word in enumerate(words):
        alpha = value(pyomo.z[leg, "alpha"])
        gamma = value(pyomo.z[leg, "gamma"])
        beta = 0.0
        if (leg, "beta") in pyomo.z:
            beta = value(pyomo.z[leg, "beta"])
        lengths.append(np.maximum(pieces(word, alpha, gamma, value(pyomo.w[leg]), beta), 0.0))
    steps = []
    for leg, leg_steps in enumerate(pyomo.steps):
        pairs = list(leg_steps)
        taken = pairs[0]
        if len(pairs) > 1:
            taken = max(pairs, key=lambda pair: value(pyomo.step[leg, pair].binary_indicator_var))
        steps.append(leg_steps[taken])
    return Point(words, lengths, np.array(steps))


def _met(model: PosedDisjunction, point: Point) -> tuple[str, Met]:
    """The words and the polished path of a point.

    The engine's point is moved until it meets the points of the course. Returns two values: the
    words as text, such as `LSR RS`, and the path.
    """
    scenario = model.question.scenario
    course = replace(model.course, steps=point.steps)
    if course.target is not None:
        z = np.zeros(3)  # the turn to the left, the turn to the right, the straight
        for letter, length in zip(point.words[0], point.pieces[0], strict=True):
            z["LRS".index(letter)] = length
        word, polished = meet_target(scenario, course.target, model.words, point.words[0], z)
        path = as_path(scenario, SUBPROBLEMS[word], polished.z)
        return word, Met(
            path, length=float(polished.z.sum()), miss=polished.miss, meets=polished.meets
        )
    # three pieces a leg: a word of two letters gets a straight of no length
    turns = [[TURN[letter] for letter in word.ljust(3, "S")] for word in point.words]
    length = np.concatenate([np.resize([*each, 0.0], 3) for each in point.pieces])
    engine_elements = Elements(np.ravel(turns) * length, length)
    correction = closed(engine_elements, RATES["best"], course, equal=False)
    elements = correction.elements
    miss = correction.miss
    path = path_of(scenario, elements.rate.tolist(), elements.length.tolist())
    return " ".join(point.words), Met(
        path, length=elements.total, miss=miss, meets=miss <= close_enough(course)
    )
