"""The shortest path as a disjunction of words, solved to proven global optimality by SCIP.

Pyomo.GDP states the model (`solvers.global_minlp.model`), which is handed to SCIP through its
Python interface (`solvers.global_minlp.scip`). SCIP's branch and bound proves that no path of any
word is shorter than its bound; its point, which meets the target only to a tolerance, is polished.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

from dubins_study.solvers import library_versions
from dubins_study.solvers.global_minlp.model import TRANSFORMATIONS, WORDS, gdp_model, transformed
from dubins_study.solvers.global_minlp.scip import BROKEN, Native, ScipSettings, run_scip
from dubins_study.solvers.paper_nlp.model import SUBPROBLEMS, as_path
from dubins_study.solvers.paper_nlp.polish import Polished, meet_target
from dubins_study.solvers.presolve import words
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution, Solver
from dubins_study.solvers.setting_checks import missing_package, one_of, within
from dubins_study.solvers.vehicle_frame import at_start
from dubins_study.study.claim import Claim

EMPHASES = ("lean", "default")

# by SCIP's statuses; only `Disjunctive._claim` makes a stronger claim
_CLAIMS = {
    "optimal": Claim.FEASIBLE,
    "gaplimit": Claim.FEASIBLE,
    "infeasible": Claim.INFEASIBLE,
    "timelimit": Claim.LIMIT,
}
# SCIP leaves this share of the gap for its tolerance on constraints, which counts as well.
_SHARE = 0.1

# Where SCIP finds no point, or fails, it runs again with a tolerance so many times larger.
_LOOSER = 100

# A point that misses by at most so many tolerances counts as feasible: each of the equations from
# an arc to its end may be off by one tolerance.
_SLACK = 10

# radii; for farther targets the words' lengths differ by less than SCIP's tolerances: bounds above
# the shortest length were seen from 1e6 radii on, none up to 1e5
_PROVABLE = 1e5


class Model(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    words: tuple[str, ...]
    program: Any  # the transformed Pyomo model, of a type that its package does not state


@dataclass(frozen=True)
class Disjunctive(Solver):
    """One disjunct for each word, proven by SCIP's branch and bound.

    `transformation` turns the disjunctions into linear constraints: `bigm` or `hull`. `gap` is the
    largest relative difference of path and bound that counts as proven. `feastol` is SCIP's
    tolerance on constraints (numerics/feastol, 1e-6 there). `emphasis` is `lean`, SCIP's bare
    spatial branch and bound, or SCIP's `default`, whose heuristics and cutting planes take some
    seventy times as long on the paper's problems, and whose presolving and propagation, working
    with tolerances of their own, now and then cut off the optimum (see docs/decisions.md).

    A feasible point of SCIP's may miss the target by the tolerance. Near the front of a turning
    circle that buys up to a full turn, and no polishing closes the miss: the point is then
    returned as it is, claimed feasible and not optimal, and the bound, though low, still holds.
    `lower_bound` is a bound for the branch that is asked. `presolve` leaves out words that cannot
    exist (`solvers.presolve`): SCIP's bound then holds for the others.
    """

    transformation: str = "bigm"
    gap: float = 1e-6
    feastol: float = 1e-8
    emphasis: str = "lean"
    presolve: bool = False

    name: ClassVar[str] = "disjunctive"
    guarantee: ClassVar[Guarantee] = Guarantee.GLOBAL
    branches: ClassVar[tuple[str, ...]] = ("best", *WORDS)
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "pyscipopt")
    summary: ClassVar[str] = "one disjunct per word in Pyomo.GDP, proven by SCIP"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"gap": 1e-4, "feastol": 1e-6},
        "accurate": {"gap": 1e-7, "feastol": 1e-9},
    }

    def __post_init__(self) -> None:
        one_of(
            transformation=(self.transformation, TRANSFORMATIONS),
            emphasis=(self.emphasis, EMPHASES),
        )
        # SCIP takes tolerances up to 1e-3, and what it calls infeasible is asked again at 100 times
        # ours; what is closed to no more than a hundredth proves nothing
        within(gap=(self.gap, 1e-12, 1e-2), feastol=(self.feastol, 1e-12, 1e-5))

    @property
    def method(self) -> Method:
        return Method("disjunction", "SCIP", "none", self.feastol)

    def unavailable(self) -> str | None:
        return missing_package(*self.packages)

    def library_versions(self) -> dict[str, str]:
        return library_versions.scip()

    @property
    def keeps_limit(self) -> bool:
        return True

    def build(self, question: Question) -> Model:
        disjuncts = words(question, self.presolve)
        program = transformed(gdp_model(*question.scenario.local(), disjuncts), self.transformation)
        return Model(question, disjuncts, program)

    def solve(self, model: Model, limit: float) -> Solution:
        there = at_start(model.question)
        if there is not None:
            return replace(there, claim=Claim.OPTIMAL, lower_bound=0.0)
        until = perf_counter() + limit
        settings = ScipSettings(self.gap * _SHARE, self.feastol, self.emphasis == "lean", limit)
        native = run_scip(model.program, model.words, settings)
        if native.status == "infeasible" or native.status.startswith(BROKEN):
            # A looser tolerance admits more: what is infeasible to it as well is so more surely,
            # and linear programs that SCIP fails to solve are solved.
            left = until - perf_counter()
            looser = settings._replace(feastol=_LOOSER * self.feastol, limit=left)
            native = run_scip(model.program, model.words, looser)
        return self._answer(model, native)

    def _answer(self, model: Model, native: Native) -> Solution:
        question, scenario = model.question, model.question.scenario
        # Node bounds come from linear programs solved to SCIP's tolerance, not exactly.
        bound = max(0.0, native.bound - native.feastol * (1 + abs(native.bound)))
        provable = math.hypot(*scenario.local()) <= _PROVABLE
        known = Solution(
            _CLAIMS.get(native.status, Claim.FAILED),
            lower_bound=bound * scenario.radius if provable else None,
            iterations=native.nodes,
            native_status=native.status,
        )
        if native.word is None or native.z is None:
            return _without_a_path(question, known)
        word, polished = meet_target(scenario, model.words, native.word, native.z)
        claim, message = self._claim(question, native, bound, polished)
        return replace(
            known,
            claim=claim,
            path=as_path(scenario, SUBPROBLEMS[word], polished.z),
            claimed_length=float(native.z.sum()) * scenario.radius,
            message=f"{word}: {message}",
        )

    def _claim(
        self, question: Question, native: Native, bound: float, polished: Polished
    ) -> tuple[Claim, str]:
        """The claim for a polished path, and why; SCIP's claim is for its own point only."""
        if not polished.meets:
            close = polished.miss <= _SLACK * native.feastol
            message = f"meets the target only to {polished.miss:.1e} radii"
            return (Claim.FEASIBLE, message) if close else (Claim.FAILED, message)
        length = float(polished.z.sum())
        gap = (length - bound) / max(length, 1.0)
        message = f"within {gap:.1e} of the bound"
        if gap <= self.gap and math.hypot(*question.scenario.local()) > _PROVABLE:
            return Claim.FEASIBLE, f"{message}, which proves nothing beyond {_PROVABLE:g} radii"
        if gap <= self.gap:
            return Claim.OPTIMAL, message
        reached = _CLAIMS.get(native.status) is Claim.LIMIT
        return (Claim.LIMIT if reached else Claim.FEASIBLE), message


def _without_a_path(question: Question, known: Solution) -> Solution:
    if known.claim is not Claim.INFEASIBLE:
        return known
    if question.branch == "best":
        # Some word reaches every target, so SCIP has cut it off.
        return replace(known, claim=Claim.FAILED, lower_bound=None, message="no word left")
    return replace(known, lower_bound=None, message=f"{question.branch} does not reach the target")
