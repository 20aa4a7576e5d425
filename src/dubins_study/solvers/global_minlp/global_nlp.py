"""`global-nlp`: the paper's model (4.12), solved with a proof.

The equations stand as in the paper, with their sines and cosines. `disjunctive` states the problem
in a form that suits the engines better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from time import perf_counter
from typing import ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.engines import MINLP_ENGINES, EngineSolver, others, packages
from dubins_study.solvers.minlp_engines.mixed_program import (
    MinlpCall,
    MixedProgram,
    Settings,
)
from dubins_study.solvers.nlp_engines.expressions import mixed_program
from dubins_study.solvers.nlp_engines.program import Expressions, Program
from dubins_study.solvers.one_leg.model import (
    MODELS,
    ORDERS,
    Case,
    PosedLeg,
    as_path,
    case_of,
    end_point,
    formulation,
    posed_leg,
)
from dubins_study.solvers.one_leg.polish import meet_target
from dubins_study.solvers.paper_nlp.case_program import program
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.runs import Run, at_start, spent
from dubins_study.solvers.setting_checks import one_of, within
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import Path
from dubins_study.study.words import BRANCHES, Claim


class PosedPrograms(NamedTuple):
    """A question, translated for `solve`.

    There is one program for each case.
    """

    leg: PosedLeg
    programs: list[MixedProgram]


@dataclass(frozen=True)
class GlobalNlp(EngineSolver):
    """Model (4.12) by an engine that proves a bound.

    There is one program for each word or each order of turns:

        minimise  z1 + z2 + z3  subject to  (4.10), (4.11),  0 <= z1, z2 <= 2 pi,  0 <= z3 <= d + 2

    in body coordinates and in radii, d the target's distance: no optimum has a full turn in it,
    and the one turn of an optimum with a straight moves the vehicle by at most 2 radii.

    Args:
        engine: `scip` or `maingo`.
        model: `words` takes one two-variable program per word, `joint` the paper's model unsplit.
        order: of the joint model: `LRS` (the paper's), `RLS` or `both`.
        heading: the form of the final heading z1 - z2 in the joint model. `variable`: it has an
            equation of its own, as theta2 has in the paper. `expression`: it stands inside its
            sines and cosines, which makes every engine branch more.
        gap: relative difference of point and bound at which the engine may stop.
        feastol: the engine's tolerance on the two equations, in radii.
        emphasis: SCIP's `default`, or `lean`, its branch and bound without heuristics, cutting
            planes, presolving and propagation. MAiNGO has no such setting.
        polish: whether the engine's point is moved until it meets the target to rounding, where
            that is possible near by; else it is returned as it is.
        presolve: whether words that cannot exist are left out (`solvers.presolve`).

    The claim is the engine's own, of all programs together: `optimal` if each is solved to its
    optimum or proved to have no point. `lower_bound` is the least of the engine's bounds, as the
    engine gives them. There is a bound only if the programs cover the question: the order LRS alone
    lacks the word RL, so its optimum is a local claim without a bound. Engines work to `feastol`,
    so that a bound may lie above the shortest length by about as much. Near the front of a turning
    circle it may lie a whole turn below that length. The tolerance stands in every row.
    """

    engine: str = one_of("scip", MINLP_ENGINES)
    model: str = one_of("joint", MODELS)
    order: str = one_of("both", ORDERS)
    heading: str = one_of("variable", ("variable", "expression"))
    gap: float = within(1e-6, 1e-12, 1e-2)
    feastol: float = within(1e-8, 1e-9, 1e-3)
    emphasis: str = one_of("default", ("default", "lean"))
    polish: bool = True
    presolve: bool = False

    name = "global-nlp"
    guarantee = Guarantee.GLOBAL
    branches = BRANCHES
    packages = ("casadi", *packages(MINLP_ENGINES))
    summary = "the paper's model (4.12), proven by SCIP or MAiNGO"
    variants = others("global-nlp", MINLP_ENGINES, "scip")
    profiles: ClassVar = {
        "fast": {"gap": 1e-4, "feastol": 1e-6},
        "accurate": {"gap": 1e-7, "feastol": 1e-9},
    }

    @property
    def method(self) -> Method:
        return Method(
            formulation=formulation(self.model, self.order),
            engine=self.library.label,
            guess="none",
            tolerance=self.feastol,
            proves=max(self.gap, self.feastol),  # a bound may be too high by the tolerance
        )

    def build(self, question: Question) -> PosedPrograms:
        leg = posed_leg(question, self.model, self.order, self.presolve)
        lifted = self.heading == "variable"
        return PosedPrograms(leg, [_program(case, lifted) for case in leg.cases])

    def solve(self, model: PosedPrograms, limit: float) -> Solution:
        deadline = perf_counter() + limit
        question, target, cases = model.leg
        # whether the programs hold every word of the question: one order alone lacks a word
        covers = self.model == "words" or self.order == "both" or question.branch != "best"
        if there := at_start(question.scenario, target):
            if covers:
                return replace(there, claim=Claim.OPTIMAL, lower_bound=0.0)
            return there
        solve: MinlpCall = self.library.load()(
            Settings(gap=self.gap, feastol=self.feastol, lean=self.emphasis == "lean")
        )
        runs: list[Run[FloatArray]] = []
        for case, posed in zip(cases, model.programs, strict=True):
            began = perf_counter()
            if began > deadline:
                break
            proven = solve(posed, deadline - began)
            z = np.zeros(3)
            length = math.inf
            if proven.x is not None:
                free = list(case.subproblem.free)
                z[free] = proven.x[: len(free)]  # a final heading may follow
                length = float(z.sum())
            seconds = perf_counter() - began
            result = proven.counted(iterations=proven.nodes)
            runs.append(
                Run(case.subproblem.name, seconds, result, z, length=length, bound=proven.bound)
            )
        return self._answer(model.leg, runs, covers)

    def _answer(self, leg: PosedLeg, runs: list[Run[FloatArray]], covers: bool) -> Solution:
        """The best point of all runs.

        Its claim and its bound are those of all runs together.
        """
        R = leg.question.scenario.radius
        bound = min((run.bound for run in runs), default=-math.inf)
        statuses = (f"{run.subproblem} {run.result.status}" for run in runs)
        messages = (f"{run.subproblem}: {run.result.message}" for run in runs)
        claim = Claim.LIMIT
        lower_bound = None
        if len(runs) == len(leg.cases):
            claim = _claim(runs, covers)
            if covers and math.isfinite(bound):
                lower_bound = bound * R
        solution = Solution(
            claim,
            lower_bound=lower_bound,
            native_status="; ".join(statuses),
            message="; ".join(messages),
            **spent(runs),
        )
        best = min(runs, key=lambda run: run.length, default=None)
        if best is None or best.length == math.inf:
            return solution
        return replace(
            solution,
            path=_path(leg, case_of(best.subproblem, leg.target), best.point, self.polish),
            claimed_length=best.length * R,
            best_run=best.effort,
        )


def _program(case: Case, lifted: bool) -> MixedProgram:
    """The program of a case.

    If `lifted`, a joint program has the final heading as a variable.
    """
    subproblem = case.subproblem
    target = case.target
    upper = np.array((TWO_PI, TWO_PI, math.hypot(target.X, target.Y) + 2))
    posed = replace(program(case), upper=upper[subproblem.mask])
    if lifted and len(subproblem.free) == 3:
        lower = np.append(posed.lower, -TWO_PI)
        upper = np.append(posed.upper, TWO_PI)
        posed = Program(_with_heading(), p=posed.p, lower=lower, upper=upper)
    return mixed_program(posed)


@cache
def _with_heading() -> Expressions:
    """Model (4.12) in four variables.

    The last variable is the final heading. The parameters p are the target (X, Y).
    """
    import casadi

    x = casadi.SX.sym("x", 4)
    p = casadi.SX.sym("p", 2)
    z1, z2, z3, th = casadi.vertsplit(x)
    x_end, y_end = end_point(z1, th, z3, casadi)
    gaps = casadi.vertcat(p[0] - x_end, p[1] - y_end, th - z1 + z2)
    return Expressions(x, p, f=z1 + z2 + z3, g=gaps)


def _claim(runs: list[Run[FloatArray]], covers: bool) -> Claim:
    """The claim for all programs together.

    `infeasible` if no program has a point; `optimal` if each is solved or has no point; `limit` if
    a limit ended a run. If the programs do not cover the question, the first two become `failed`
    and `local`. Otherwise the claim is `feasible` with a point, `failed` without one.
    """
    claims = {run.claim for run in runs}
    if claims == {Claim.INFEASIBLE}:
        if covers:
            return Claim.INFEASIBLE
        return Claim.FAILED
    if claims <= {Claim.OPTIMAL, Claim.INFEASIBLE}:
        if covers:
            return Claim.OPTIMAL
        return Claim.LOCAL
    if Claim.LIMIT in claims:
        return Claim.LIMIT
    if any(run.length < math.inf for run in runs):
        return Claim.FEASIBLE
    return Claim.FAILED


def _path(leg: PosedLeg, case: Case, z: FloatArray, polish: bool) -> Path:
    """The path of a point z, shape (3,).

    z has the case's first turn, its second turn and its straight. With `polish` the point is first
    moved to meet the target, where that is possible.
    """
    scenario = leg.question.scenario
    if polish:
        turns = z  # left, right, straight
        if case.subproblem.mirrored:
            turns = z[[1, 0, 2]]
        words = _words(case.subproblem.name, z)
        word, polished = meet_target(scenario, leg.target, words, words[0], turns)
        if polished.meets:
            return as_path(scenario, case_of(word, leg.target).subproblem, polished.z)
    return as_path(scenario, case.subproblem, z)


def _words(name: str, z: FloatArray) -> tuple[str, ...]:
    """The words that a point's lengths may stand for.

    A word of a joint program leaves out one of the lengths z; the words are sorted by that length.
    For `LRS` with z1 < z3 < z2 they are RS, LR and LS.
    """
    if len(name) == 2:
        return (name,)
    missing = sorted(range(3), key=lambda i: float(z[i]))
    return tuple(name[:i] + name[i + 1 :] for i in missing)
