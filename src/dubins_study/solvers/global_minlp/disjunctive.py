"""The shortest path as a disjunction of words, solved to proven global optimality by SCIP.

Pyomo.GDP states the model (`solvers.global_minlp.model`), Pyomo's `scip_direct` hands it to SCIP
through its Python interface. SCIP's branch and bound proves that no path of any word is shorter
than its bound; its point, which meets the target only to a tolerance, is polished.
"""

from __future__ import annotations

import importlib.util
import math
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers import library_versions
from dubins_study.solvers.global_minlp.model import TRANSFORMATIONS, WORDS, gdp_model, transformed
from dubins_study.solvers.global_minlp.polish import Polished, meet_target
from dubins_study.solvers.paper_nlp.model import SUBPROBLEMS, already_there, as_path
from dubins_study.solvers.protocol import Guarantee, Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, within
from dubins_study.study.check.verdict import Claim
from dubins_study.study.path import FloatArray

EMPHASES = ("lean", "default")

# Pyomo's names of SCIP's statuses; a point is claimed to be more only by `Disjunctive._claim`
_CLAIMS = {
    "convergenceCriteriaSatisfied": Claim.FEASIBLE,
    "provenInfeasible": Claim.INFEASIBLE,
    "maxTimeLimit": Claim.LIMIT,
    "interrupted": Claim.LIMIT,
}
_STATUS = re.compile(r"^SCIP Status\s*:\s*(.*?)\s*$", re.MULTILINE)

# SCIP leaves this share of the gap for its tolerance on constraints, which counts as well.
_SHARE = 0.1

_BROKEN = "error"

# What is infeasible, or broken, is asked again with a tolerance so many times larger.
_LOOSER = 100

# A point that misses by so many tolerances counts as feasible: each of the equations that lead
# from an arc to its end may be off by one.
_SLACK = 10

# radii; farther off, the words' lengths differ by less than SCIP's tolerances make of them: bounds
# above the shortest length were seen from 1e6 radii on, none up to 1e5
_PROVABLE = 1e5


class Model(NamedTuple):
    """A question as `solve` takes it, and what answers it."""

    question: Question
    words: tuple[str, ...]
    program: Any  # the transformed Pyomo model, of a type that its package does not state


class Native(NamedTuple):
    """What SCIP says: lengths in radii; `word` and z (left, right, straight) None without a point.

    `condition` is Pyomo's name of `status`, which is SCIP's own.
    """

    condition: str
    status: str
    bound: float
    word: str | None
    z: FloatArray | None
    nodes: int
    feastol: float


@dataclass(frozen=True)
class Disjunctive(Solver):
    """Settings.

    `transformation` turns the disjunctions into linear constraints: `bigm` or `hull`. `gap` is the
    largest relative difference of path and bound that counts as proven. `feastol` is SCIP's
    tolerance on constraints (numerics/feastol, 1e-6 there). `emphasis` is `lean`, SCIP's bare
    spatial branch and bound, or SCIP's `default`, whose heuristics and cutting planes take some
    seventy times as long on the paper's problems, and whose presolving and propagation, working
    with tolerances of their own, now and then cut off the optimum (see docs/decisions.md).

    A feasible point of SCIP's may miss the target by the tolerance. Near the front of a turning
    circle that buys up to a full turn, and no polishing closes the miss: the point is then
    returned as it is, claimed feasible and not optimal, and the bound, though low, still holds.
    `lower_bound` is a bound for the branch that is asked.
    """

    transformation: str = "bigm"
    gap: float = 1e-6
    feastol: float = 1e-8
    emphasis: str = "lean"

    name: ClassVar[str] = "disjunctive"
    method: ClassVar[str] = "global MINLP"
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

    def unavailable(self) -> str | None:
        for package in ("pyomo", "pyscipopt"):
            if importlib.util.find_spec(package) is None:
                return f"the package {package} is not installed"
        return None

    def library_versions(self) -> dict[str, str]:
        return library_versions.scip()

    def build(self, question: Question) -> Model:
        words = WORDS if question.branch == "best" else (question.branch,)
        program = transformed(gdp_model(*question.scenario.local(), words), self.transformation)
        return Model(question, words, program)

    def solve(self, model: Model, limit: float) -> Solution:
        there = already_there(model.question)
        if there is not None:
            return replace(there, claim=Claim.OPTIMAL, lower_bound=0.0)
        native = self._run(model, limit, self.feastol)
        if native.condition in ("provenInfeasible", _BROKEN):
            # A looser tolerance admits more: what is infeasible to it as well is so more surely,
            # and linear programs that SCIP fails to solve are solved.
            native = self._run(model, limit, _LOOSER * self.feastol)
        return self._answer(model, native)

    def _run(self, model: Model, limit: float, feastol: float) -> Native:
        from pyomo.contrib.solver.common.factory import SolverFactory
        from pyomo.environ import value

        options = dict(_lean() if self.emphasis == "lean" else ())
        options |= {"numerics/feastol": feastol, "limits/gap": self.gap * _SHARE}
        try:
            results = SolverFactory("scip_direct").solve(
                model.program,
                time_limit=limit,
                load_solutions=False,
                raise_exception_on_nonoptimal_result=False,
                solver_options=options,
            )
        except Exception as error:
            # SCIP's own errors (of its linear programs, mostly) have no type of their own
            if not str(error).startswith("SCIP:"):
                raise
            return Native(_BROKEN, str(error), 0.0, None, None, 0, feastol)
        word = z = None
        if results.incumbent_objective is not None:
            results.solution_loader.load_vars()
            chosen = {w: value(model.program.word[w].binary_indicator_var) for w in model.words}
            word = max(chosen, key=chosen.__getitem__)
            z = np.array([value(z) for z in model.program.z.values()])
        status = _STATUS.search(results.solver_log)
        return Native(
            results.termination_condition.name,
            status.group(1) if status else "",
            float(results.objective_bound),
            word,
            z,
            int(results.extra_info["NNodes"]),
            feastol,
        )

    def _answer(self, model: Model, native: Native) -> Solution:
        question, scenario = model.question, model.question.scenario
        # Node bounds come from linear programs solved to SCIP's tolerance, not exactly.
        bound = max(0.0, native.bound - native.feastol * (1 + abs(native.bound)))
        provable = math.hypot(*scenario.local()) <= _PROVABLE
        known = Solution(
            _CLAIMS.get(native.condition, Claim.FAILED),
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
        """What may be said of a polished path, whatever SCIP says of its own point."""
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
        reached = _CLAIMS.get(native.condition) is Claim.LIMIT
        return (Claim.LIMIT if reached else Claim.FEASIBLE), message


def _without_a_path(question: Question, known: Solution) -> Solution:
    if known.claim is not Claim.INFEASIBLE:
        return known
    if question.branch == "best":
        # Some word reaches every target, so SCIP has cut it off.
        return replace(known, claim=Claim.FAILED, lower_bound=None, message="no word left")
    return replace(known, lower_bound=None, message=f"{question.branch} does not reach the target")


@lru_cache(maxsize=1)
def _lean() -> tuple[tuple[str, Any], ...]:
    """SCIP's parameters for branch and bound without heuristics, cutting planes, presolving and
    propagation."""
    from pyscipopt import Model as Scip
    from pyscipopt.scip import PY_SCIP_PARAMSETTING as SCIP_PARAMSETTING

    scip = Scip()
    before = scip.getParams()
    scip.setHeuristics(SCIP_PARAMSETTING.OFF)
    scip.setSeparating(SCIP_PARAMSETTING.OFF)
    scip.setParam("presolving/maxrounds", 0)
    scip.setParam("propagating/maxrounds", 0)
    scip.setParam("propagating/maxroundsroot", 0)
    after = scip.getParams()
    return tuple((name, value) for name, value in after.items() if value != before[name])
