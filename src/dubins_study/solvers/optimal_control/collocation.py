"""`collocation`: the optimal-control problem in `pyomo.dae`, solved as one program by Ipopt."""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers import library_versions
from dubins_study.solvers.ipopt_library.engine import (
    CLAIMS,
    VIAS,
    Result,
    by_executable,
    unavailable,
)
from dubins_study.solvers.optimal_control.collocation_correction import closed, miss
from dubins_study.solvers.optimal_control.collocation_guesses import guesses
from dubins_study.solvers.optimal_control.collocation_model import Elements, Template, template
from dubins_study.solvers.optimal_control.turn_rate_dynamics import RATES, Rates
from dubins_study.solvers.paper_nlp.best_point import total
from dubins_study.solvers.paper_nlp.polish import one_sided_only
from dubins_study.solvers.presolve import words
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.solvers.vehicle_frame import in_world, staying
from dubins_study.study.claim import Claim
from dubins_study.study.path import FloatArray, Path
from dubins_study.study.vehicle_frame import Local, local

MESHES = ("free", "equal")
_ARRIVED = 1e-8  # radii; a hundredth of what the check allows
_ROUNDED = 32 * math.ulp(1.0)  # of the target's distance
_SAME = 1e-6  # relative; of two answers this near, the one that Ipopt calls a solution is taken


class Model(NamedTuple):
    """A question in the vehicle's frame, in radii."""

    question: Question
    place: Local
    rates: Rates
    transcription: Template

    @property
    def target(self) -> FloatArray:
        """Shape (2,)."""
        return np.array((self.place.X, self.place.Y))


class Run(NamedTuple):
    """One solve by Ipopt; `missed` and `miss` (radii) are before and after the correction."""

    claim: Claim
    elements: Elements
    missed: float
    miss: float
    native: Result
    rollouts: int


@dataclass(frozen=True)
class Collocation(Solver):
    """Problem (2.2) of the paper over n elements, each with a turn rate of its own, free in length.

    The states are collocated at Legendre-Gauss-Radau points. Ipopt's controls are then integrated
    exactly; the path misses by the transcription's own error, which a last correction removes.
    `LS` and `RS` forbid turning the other way. For `best`, Ipopt starts from the shape of every
    word, and the shortest path is the answer.

    Args:
        n: number of finite elements.
        points: collocation points in each.
        mesh: `free` elements, whose lengths are variables, so that a switch falls between two of
            them and the gap is Ipopt's tolerance; or `equal` ones, whose gap falls like 1 / n^2.
        correct: whether a last correction removes the miss.
        tol, max_iter: Ipopt's own.
        via: `executable`, `library` or `auto`: the executable if PATH has one.
        presolve: whether no guess is shaped like a word that cannot exist (`solvers.presolve`).
    """

    n: int = 5
    points: int = 5
    mesh: str = "free"
    correct: bool = True
    tol: float = 1e-9
    max_iter: int = 200
    via: str = "auto"
    presolve: bool = False

    name: ClassVar[str] = "collocation"
    guarantee: ClassVar[Guarantee] = Guarantee.DISCRETISED
    branches: ClassVar[tuple[str, ...]] = tuple(RATES)
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "optimal control collocated in pyomo.dae, free elements, by Ipopt"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 6, "points": 6, "tol": 1e-11},
    }

    def __post_init__(self) -> None:
        # Three elements hold every word: an arc of up to a full turn takes two free elements.
        # More than ten Radau points are lost in rounding; a thousand elements take minutes.
        whole(n=(self.n, 3, 1000), points=(self.points, 1, 10), max_iter=(self.max_iter, 1, 10**6))
        one_of(mesh=(self.mesh, MESHES), via=(self.via, VIAS))
        within(tol=(self.tol, 1e-14, 1e-2))

    @property
    def method(self) -> Method:
        return Method("Radau collocation", "Ipopt", "bearing", self.tol)

    def unavailable(self) -> str | None:
        return unavailable(self.via)

    @property
    def keeps_limit(self) -> bool:
        # Pyomo lets the executable run; compiling takes 0.4 s at 500 points and 5 s at 5000
        return not by_executable(self.via) and self.n * self.points <= 250

    def library_versions(self) -> dict[str, str]:
        return library_versions.ipopt(by_executable(self.via))

    def build(self, question: Question) -> Model:
        options = (("tol", self.tol), ("max_iter", self.max_iter), ("bound_relax_factor", 0.0))
        transcription = template(
            self.n, self.points, self.mesh == "equal", options, by_executable(self.via)
        )
        place = local(question.scenario)
        return Model(question, place, RATES[question.branch], transcription)

    def solve(self, model: Model, limit: float) -> Solution:
        question, place = model.question, model.place
        if place.X == place.Y == 0:
            return staying(question)
        runs: list[Run] = []
        until = perf_counter() + limit
        shapes = words(question, self.presolve)
        for word in guesses(question, place, shapes, self.n, self.mesh == "equal"):
            for guess in word:
                if perf_counter() > until:
                    return _answer(model, runs, in_time=False)
                runs.append(self._run(model, guess, until))
                if runs[-1].claim is Claim.LOCAL:
                    break
        return _answer(model, runs, in_time=perf_counter() <= until)

    def _run(self, model: Model, guess: Elements, until: float) -> Run:
        elements, native = model.transcription.solve(guess, model.rates, model.target, until)
        claim = CLAIMS.get(native.status, Claim.FAILED)
        if not np.isfinite(elements).all():
            return Run(Claim.FAILED, elements, math.inf, math.inf, native, 0)
        missed = off = miss(elements, model.target)
        rollouts = 1
        if self.correct:
            equal = self.mesh == "equal"
            elements, off, rollouts = closed(elements, model.rates, model.target, equal)
            if claim is Claim.LOCAL and not _arrives(off, model.target):
                claim = Claim.FAILED
        return Run(claim, elements, missed, off, native, rollouts)


def _arrives(off: float, target: FloatArray) -> bool:
    return off <= max(_ARRIVED, _ROUNDED * float(np.abs(target).sum()))


def _chosen(model: Model, runs: list[Run]) -> Run:
    """The shortest run that arrives, or else the run that ends nearest to the target.

    Of runs that are equally short, one that Ipopt calls a solution goes first.
    """
    arrived = [run for run in runs if run.claim is Claim.LOCAL or _arrives(run.miss, model.target)]
    if not arrived:
        return min(runs, key=lambda run: run.miss)
    shortest = min(run.elements.total for run in arrived)
    tied = [run for run in arrived if run.elements.total <= shortest * (1 + _SAME)]
    return min(tied, key=lambda run: (run.claim is not Claim.LOCAL, run.elements.total))


def _answer(model: Model, runs: list[Run], in_time: bool) -> Solution:
    if not runs:
        return Solution(Claim.LIMIT, message="no time to begin")
    best = _chosen(model, runs)
    scenario, claim = model.question.scenario, best.claim
    if not in_time:
        claim = Claim.LIMIT
    elif claim is not Claim.LOCAL:
        # Ipopt gave up, or wrongly called it infeasible; the corrected path may still arrive
        claim = Claim.FEASIBLE if _arrives(best.miss, model.target) else Claim.FAILED
    elements = best.elements
    rate = np.clip(elements.rate, model.rates.lower, model.rates.upper)
    path = Path(scenario.start, rate / scenario.radius, elements.length * scenario.radius)
    message = f"{best.native.message}; missed by {best.missed:.1e} radii before the correction"
    if claim in (Claim.LOCAL, Claim.FEASIBLE) and (reason := one_sided_only(model.question, path)):
        claim, message = Claim.FAILED, reason
    multipliers = None
    if best.native.duals is not None and claim is Claim.LOCAL:
        multipliers = in_world(scenario, *map(float, best.native.duals))
    return Solution(
        claim,
        path=path,
        claimed_length=elements.total * scenario.radius,
        multipliers=multipliers,
        iterations=total(run.native.iterations for run in runs),
        evaluations=total(n for run in runs for n in (run.native.evaluations, run.rollouts)),
        native_status=best.native.status,
        message=message,
    )
