"""The paper's model (4.12) by local NLP engines.

`nlp` takes any of them. `slsqp` and `ipopt` are presets of it: `slsqp` names its settings as SciPy
does; `ipopt` reads the model in Pyomo, as the paper's authors solved it. An executable is looked up
on PATH by its name and run as AMPL runs it (`nlp_engines.ampl`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, NamedTuple

from dubins_study.solvers.engines import (
    APART,
    NLP_ENGINES,
    EngineSolver,
    engine_or_program,
    names,
    others,
    packages,
)
from dubins_study.solvers.one_leg.initial_guesses import INITIAL_GUESSES, initial_guesses
from dubins_study.solvers.one_leg.model import (
    MODELS,
    ORDERS,
    UNITS,
    Case,
    PosedLeg,
    formulation,
    posed_leg,
)
from dubins_study.solvers.one_leg.search import searched
from dubins_study.solvers.paper_nlp.case_program import Solve, measured, solve
from dubins_study.solvers.paper_nlp.pyomo_model import (
    ipopt_in_pyomo,
    solve_in_pyomo,
)
from dubins_study.solvers.protocol import Method, Question, Solution
from dubins_study.solvers.runs import at_start
from dubins_study.solvers.setting_checks import (
    iterations,
    one_of,
    option_set,
    tolerance,
    whole,
    within,
)
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import BRANCHES, NLP


class PosedNlp(NamedTuple):
    """A question, translated for `solve`.

    `adapter` solves its cases.
    """

    leg: PosedLeg
    adapter: Solve


@dataclass(frozen=True)
class PaperNlp(EngineSolver):
    """Model (4.12) by a local NLP engine.

    Args:
        model: `words` takes one two-variable problem per word, `joint` the paper's model unsplit.
        order: of the joint model: `LRS` (the paper's), `RLS` or `both`.
        initial_guess: where the search begins (`one_leg.initial_guesses`): `bearing` (several
            guesses a word, one of the joint model), `words` (one for each word), `one`,
            `straight`, `zero`, `random`, or `given`: only from the question's own guess.
        seed: of random guesses; the number of the repeat is added to it.
        count: number of random guesses.
        capped: whether arcs are bounded by a full turn, which the paper does not do.
        presolve: whether words that cannot exist are left out (`solvers.presolve`).
        options: the set of the engine's options: `equal`, `default` or `tuned` (docs/engines.md).
    """

    model: str = one_of("words", MODELS)
    order: str = one_of("both", ORDERS)
    initial_guess: str = one_of("bearing", INITIAL_GUESSES)
    seed: int = whole(0, 0, 2**32)
    count: int = whole(10, 1, 10**9)
    capped: bool = True
    presolve: bool = False
    options: str = option_set()

    units = "radius"  # of the model's lengths (`UNITS`); some presets make it a setting
    # the preset's names of the engine's tolerance and of its limit of iterations
    limits: ClassVar[tuple[str, str]] = ("tol", "max_iter")
    branches = BRANCHES
    warm = True
    profiles: ClassVar = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        posed = formulation(self.model, self.order)
        tol = getattr(self, self.limits[0])
        return self.library.method(posed, self.initial_guess, self.options, tol)

    def adapter(self) -> Solve:
        """The function that solves one case from one guess."""
        tol, max_iter = (getattr(self, name) for name in self.limits)
        return partial(solve, engine=self.library.load()(tol, max_iter, self.options))

    def build(self, question: Question) -> PosedNlp:
        leg = posed_leg(question, self.model, self.order, self.presolve)
        unit = 1.0
        if self.units == "scenario":
            unit = question.scenario.radius
        cases = [case._replace(capped=self.capped, unit=unit) for case in leg.cases]
        return PosedNlp(leg._replace(cases=cases), self.adapter())

    def solve(self, model: PosedNlp, limit: float) -> Solution:
        leg = model.leg
        kind = self.initial_guess
        question = leg.question
        # at z = 0 no constraint qualification holds, so that no NLP method can certify this point
        if there := at_start(question.scenario, leg.target):
            return there
        seed = self.seed + question.repeat
        both = len(leg.cases) > 1

        def guesses(case: Case) -> Iterator[FloatArray]:
            return initial_guesses(question, case, kind, seed=seed, count=self.count, both=both)

        return searched(leg, kind, guesses, model.adapter, limit)


@dataclass(frozen=True)
class Slsqp(PaperNlp):
    """Model (4.12) by SLSQP.

    The other settings: `PaperNlp`.

    Args:
        ftol: SLSQP's tolerance on the objective and the sum of constraint violations, in radii; 0
            for that of `options`.
        maxiter: largest number of iterations; 0 for that of `options`.
        units: of the model: the turning `radius`, or as in the paper the `scenario`'s own unit;
            `ftol` is then in that unit too.
    """

    ftol: float = tolerance()
    maxiter: int = iterations()
    units: str = one_of("radius", UNITS)

    name = "slsqp"
    engine = "slsqp"
    limits = ("ftol", "maxiter")
    packages = ("scipy",)
    summary = "the paper's model (4.12) by SciPy's SLSQP"
    profiles: ClassVar = {
        "fast": {"ftol": 1e-8},
        "accurate": {"ftol": 1e-14},
    }


@dataclass(frozen=True)
class Ipopt(PaperNlp):
    """Model (4.12) in Pyomo by Ipopt.

    The other settings: `PaperNlp`.

    Args:
        tol: Ipopt's tolerances; 0 for those of `options`.
        max_iter: largest number of iterations; 0 for that of `options`.
        mu_target: Ipopt's own: the barrier parameter to stop at.
        units: of the model: the turning `radius`, or as in the paper the `scenario`'s own unit.
    """

    tol: float = tolerance()
    max_iter: int = iterations()
    mu_target: float = within(0.0, 0, 1)
    units: str = one_of("radius", UNITS)

    name = "ipopt"
    engine = "ipopt"
    packages = ("pyomo", "casadi")
    summary = "the paper's model (4.12) in Pyomo by Ipopt"

    def adapter(self) -> Solve:
        chosen = self.library.options.of(self.options, self.tol, self.max_iter)
        if self.mu_target:
            chosen["ipopt.mu_target"] = self.mu_target
        return measured(ipopt_in_pyomo(tuple(chosen.items()), self.units))


_KNITRO = "knitro"
# The fastest engine that finds all 96 targets of benchmark-leg with the guesses of `bearing`.
_DEFAULT = "ipopt"
_ENGINES = names(NLP)


@dataclass(frozen=True)
class _Named(EngineSolver):
    """The setting `engine`, declared apart.

    A canonical spec names it before the settings of `PaperNlp`.

    Args:
        engine: a name in `solvers.engines` of the kind `local NLP`, or the name of an executable on
            PATH that reads NL files.
    """

    engine: str = engine_or_program(_DEFAULT, _ENGINES)


@dataclass(frozen=True)
class Nlp(PaperNlp, _Named):
    """Model (4.12) by one of many NLP engines.

    The other settings: `PaperNlp`.

    Args:
        options: the set of the engine's options: `equal`, `default` or `tuned` (docs/engines.md).
            KNITRO runs with its defaults, as in the paper.
        tol: the feasibility, and with most engines the optimality, that is asked for; 0 for that of
            `options`.
        max_iter: largest number of iterations; 0 for that of `options`.
    """

    tol: float = tolerance()
    max_iter: int = iterations()

    name = "nlp"
    always_named = ("engine",)
    packages = (*packages(NLP_ENGINES), "pyomo", _KNITRO)
    summary = "the paper's model (4.12) by any NLP engine or AMPL solver"
    variants = others("nlp", _ENGINES, *APART)

    def adapter(self) -> Solve:
        if self.engine == _KNITRO:
            return measured(partial(solve_in_pyomo, interface="knitro_direct"))
        return super().adapter()
