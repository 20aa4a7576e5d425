"""`shooting`: Pontryagin's system (2.3)-(2.15) solved as equations.

This is the indirect method. docs/formulations/pontryagin.md has the system, its structures (Maurer
1976, Numerical solution of singular control problems using multiple shooting techniques, JOTA 18),
and the reason why plain single shooting cannot work. The pieces are integrated in closed form. One
arc or one straight is either structure with a piece of no length. An extremal is only a candidate,
so the claim is `local`. `best` is the shortest extremal that the guesses lead to.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.engines import ENGINES, names
from dubins_study.solvers.indirect.structure import ROUNDED, TURNS, Structure, candidates
from dubins_study.solvers.one_leg.initial_guesses import INITIAL_GUESSES, initial_guesses
from dubins_study.solvers.one_leg.model import Case, PosedLeg, posed_leg
from dubins_study.solvers.one_leg.search import searched
from dubins_study.solvers.protocol import Method, Question, Solution, Solver
from dubins_study.solvers.runs import EngineResult, at_start, no_point
from dubins_study.solvers.setting_checks import one_of, option_set, positive, whole
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import ROOTS, Claim

# The iteration ends at steps smaller than `tol` by this factor. It converges superlinearly, except
# on a turning circle, where the equations are singular and every step halves the error.
_STEP = 1e-4


class _OutOfTimeError(Exception):
    """The time limit came during the solution."""


@dataclass(frozen=True)
class Shooting(Solver):
    """Pontryagin's conditions, solved as equations.

    The initial guess of the costates belongs to a path that ends straight, with the guess's final
    heading.

    Args:
        initial_guess, seed, count: the durations to begin with (`one_leg.initial_guesses`).
        root: method of `scipy.optimize.root`, `hybr` (Powell's dogleg) or `lm`
            (Levenberg-Marquardt).
        tol: largest residual of an extremal: the miss in radii, and every costate condition with
            (nu0, nu1, nu2) of length 1.
        max_evaluations: largest number of evaluations of the conditions from one initial guess.
        options: the end of MINPACK's iteration (docs/engines.md): with `equal`, steps below
            1e-4 `tol` or `max_evaluations`; with `default` and `tuned`, MINPACK's own rule.
        presolve: whether words that cannot exist are left out (`solvers.presolve`).
    """

    initial_guess: str = one_of("bearing", INITIAL_GUESSES)
    seed: int = whole(0, 0, 2**63)
    count: int = positive(10)
    root: str = one_of("hybr", names(ROOTS))
    tol: float = positive(1e-9)
    max_evaluations: int = positive(200)
    presolve: bool = False
    options: str = option_set()

    name = "shooting"
    branches = ("best", "LS", "RS", "LR", "RL")
    warm = True
    packages = ("scipy",)
    summary = "Pontryagin's conditions by structured shooting, SciPy's root"
    keeps_limit = True
    profiles: ClassVar = {
        "fast": {"tol": 1e-7},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        return Method(
            formulation="Pontryagin's system",
            engine=ENGINES[self.root].label,
            guess=self.initial_guess,
            tolerance=self.tol,
        )

    def build(self, question: Question) -> PosedLeg:
        return posed_leg(question, "words", "both", self.presolve)

    def solve(self, model: PosedLeg, limit: float) -> Solution:
        question = model.question
        if there := at_start(question.scenario, model.target, self.tol):
            return there
        prescribed = question.branch in ("LR", "RL")
        guesses = partial(self._guesses, question)
        solve = partial(self._from, prescribed)
        return searched(model, self.initial_guess, guesses, solve, limit)

    def _guesses(self, question: Question, case: Case) -> Iterator[FloatArray]:
        """Initial guesses of a case.

        A guess has the durations (3,) in the order of `one_leg.model`, then the costates (4,).
        """
        structure = _structure(case)
        free = list(case.subproblem.free)
        seed = self.seed + question.repeat
        points = initial_guesses(question, case, self.initial_guess, seed=seed, count=self.count)
        for z in points:
            heading = structure.pieces(*z[free])[1].heading
            # costates of a path that ends straight with this heading
            nu = 1.0, -math.cos(heading), -math.sin(heading)
            yield np.concatenate((z, structure.consistent(nu)))

    def _from(
        self, prescribed: bool, case: Case, guess: FloatArray, seconds: float
    ) -> EngineResult:
        """Solve from one initial guess.

        `prescribed` says that the branch prescribes the controls.
        """
        structure = _structure(case)
        free = list(case.subproblem.free)
        v = structure.unknowns(guess[3:], guess[free])
        until = perf_counter() + seconds
        try:
            result = self._root(structure, v, until)
            evaluations = int(result.nfev)
        except _OutOfTimeError:
            return no_point(3, Claim.LIMIT, self.root, "out of time")
        # a miss of `tol`, or a miss that the rounding of a far target leaves
        missed = max(self.tol, ROUNDED * structure.scale)
        # the first candidate without a fault, or else the last one
        for candidate in candidates(structure, result.x, self.tol):
            fault = candidate.fault(missed, prescribed)
            if fault is None:
                break
        z = np.zeros(3)
        z[free] = candidate.durations
        claim = Claim.LOCAL
        if fault is not None:
            claim = Claim.FAILED
        return EngineResult(
            z,
            claim,
            candidate.multipliers,
            iterations=evaluations - 1,  # every evaluation but the first tries a step
            evaluations=evaluations,
            status=f"{self.root} {result.status}",
            message=fault or candidate.describe(),
        )

    def _root(self, structure: Structure, v: FloatArray, until: float) -> Any:
        from scipy.optimize import root

        def residual(v: FloatArray) -> FloatArray:
            if perf_counter() > until:
                raise _OutOfTimeError
            return structure.residual(v)

        # the least step and the limit of evaluations; the other sets leave both to MINPACK
        step = 0.0
        most = 0
        if self.options == "equal":
            step = self.tol * _STEP
            most = int(self.max_evaluations)
        options = ENGINES[self.root].options.of(self.options, step, most)
        return root(residual, v, jac=structure.jacobian, method=self.root, options=options)


def _structure(case: Case) -> Structure:
    """A word as a structure of Pontryagin's system."""
    first, second = (TURNS[i] for i in case.subproblem.free)
    return Structure((first, second), case.target.X, case.target.Y)
