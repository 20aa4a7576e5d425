"""The paper's model written in Pyomo and solved by Ipopt, an interior-point method.

Pyomo writes the NL file once: the target is two variables that each scenario fixes through their
bounds. An `ipopt` executable on PATH solves it if there is one; otherwise the Ipopt library inside
the casadi wheel does, in process.
"""

from __future__ import annotations

import importlib.util
import math
import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path as FilePath
from typing import Any, ClassVar, NamedTuple

import numpy as np

from solvers.model import (
    FULL_TURN,
    MODELS,
    ORDERS,
    Attempts,
    Point,
    Subproblem,
    answer,
    subproblems,
    target,
)
from solvers.protocol import Guarantee, Question, Solution
from solvers.settings import one_of, positive
from solvers.starts import STARTS, every_start, starting_points
from study.path import FloatArray
from study.verify import Claim

VIAS = ("auto", "executable", "library")

# Ipopt's application return statuses as the library names them, and as the executable says them
_CLAIMS = {
    "Solve_Succeeded": Claim.LOCAL,
    "Solved_To_Acceptable_Level": Claim.LOCAL,
    "Feasible_Point_Found": Claim.FEASIBLE,
    "Infeasible_Problem_Detected": Claim.INFEASIBLE,
    "Maximum_Iterations_Exceeded": Claim.LIMIT,
    "Maximum_CpuTime_Exceeded": Claim.LIMIT,
    "Maximum_WallTime_Exceeded": Claim.LIMIT,
    "optimal": Claim.LOCAL,
    "locallyOptimal": Claim.LOCAL,
    "infeasible": Claim.INFEASIBLE,
    "locallyInfeasible": Claim.INFEASIBLE,
    "maxIterations": Claim.LIMIT,
    "maxTimeLimit": Claim.LIMIT,
}


class Native(NamedTuple):
    """What Ipopt says of one run; z has shape (3,)."""

    z: FloatArray
    multipliers: tuple[float, float] | None
    status: str
    message: str
    iterations: int | None
    evaluations: int | None


# (z at the start, its lower bounds, its upper bounds, the target) -> what Ipopt says
Run = Callable[[FloatArray, FloatArray, FloatArray, tuple[float, float]], Native]


Options = tuple[tuple[str, float], ...]


class Case(NamedTuple):
    """A subproblem as Ipopt takes it: bounds of z and the target."""

    subproblem: Subproblem
    lower: FloatArray
    upper: FloatArray
    target: tuple[float, float]


class Model(NamedTuple):
    question: Question
    cases: list[Case]
    run: Run


@dataclass(frozen=True)
class Ipopt:
    """Settings: see `solvers.model` (model, order) and `solvers.starts` (start, seed, count).

    `capped` bounds arcs by a full turn, which the paper does not. `tol`, `max_iter` and
    `bound_relax` (its bound_relax_factor) are Ipopt's own; the last is 1e-8 there, and Ipopt then
    returns arcs of -1e-8, which no vehicle drives: cut to zero they miss a target 1 000 radii away
    by 1e-5 radii. `via` is `executable`, `library` or `auto`: the executable if PATH has one.
    """

    model: str = "words"
    order: str = "both"
    start: str = "bearing"
    seed: int = 0
    count: int = 10
    capped: bool = True
    tol: float = 1e-8
    max_iter: int = 200
    bound_relax: float = 0.0
    via: str = "auto"

    name: ClassVar[str] = "ipopt"
    method: ClassVar[str] = "local NLP"
    guarantee: ClassVar[Guarantee] = Guarantee.LOCAL
    branches: ClassVar[tuple[str, ...]] = ("best", "LS", "RS")
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "the paper's model (4.12) in Pyomo by Ipopt"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    def __post_init__(self) -> None:
        one_of(model=(self.model, MODELS), order=(self.order, ORDERS), start=(self.start, STARTS))
        one_of(via=(self.via, VIAS))
        positive(count=self.count, tol=self.tol, max_iter=self.max_iter)

    def unavailable(self) -> str | None:
        if importlib.util.find_spec("pyomo") is None:
            return "the package pyomo is not installed"
        executable = _executable()
        library = importlib.util.find_spec("casadi") is not None
        reasons = {
            "executable": None if executable else "no executable 'ipopt' on PATH",
            "library": None if library else "the package casadi, which carries Ipopt, is missing",
        }
        if self.via == "auto":
            return None if executable or library else "; ".join(filter(None, reasons.values()))
        return reasons[self.via]

    def build(self, question: Question) -> Model:
        executable = self.via == "executable" or (self.via == "auto" and _executable())
        template = executable_template if executable else library_template
        cases = [
            self._case(question, subproblem)
            for subproblem in subproblems(question, self.model, self.order)
        ]
        return Model(question, cases, template(self._options))

    @property
    def _options(self) -> Options:
        return (
            ("tol", self.tol),
            ("max_iter", self.max_iter),
            ("bound_relax_factor", self.bound_relax),
        )

    def _case(self, question: Question, subproblem: Subproblem) -> Case:
        arc = FULL_TURN if self.capped else math.inf
        upper = np.where(subproblem.mask, (arc, arc, math.inf), 0.0)
        return Case(
            subproblem,
            np.zeros(3),
            upper,
            target(question.scenario, subproblem.mirrored),
        )

    def solve(self, model: Model, limit: float) -> Solution:
        question = model.question
        attempts = [
            Attempts(
                partial(_attempt, model.run, case),
                starting_points(question, case.subproblem, self.start, self.seed, self.count),
                every_start(case.subproblem, self.start),
            )
            for case in model.cases
        ]
        return answer(question, attempts, limit)


def _executable() -> bool:
    return _on_path(os.environ.get("PATH", ""))


@lru_cache(maxsize=4)
def _on_path(path: str) -> bool:
    # looked up once for every value of PATH: the search costs as much as a few iterations
    return shutil.which("ipopt", path=path) is not None


def _attempt(run: Run, case: Case, start: FloatArray) -> Point:
    native = run(start, case.lower, case.upper, case.target)
    return Point(
        case.subproblem,
        native.z,
        _CLAIMS.get(native.status, Claim.FAILED),
        native.multipliers,
        native.iterations,
        native.evaluations,
        native.status,
        native.message,
    )


def pyomo_model() -> Any:
    """Model (4.12) in Pyomo: z[1..3] >= 0 and the target as variables X, Y to be fixed."""
    from pyomo.environ import ConcreteModel, Constraint, Objective, Var, cos, sin

    m = ConcreteModel(name="dubins-4.12")
    m.z = Var((1, 2, 3), bounds=(0, None), initialize=1.0)
    m.X = Var(initialize=1.0)
    m.Y = Var(initialize=1.0)
    z1, z2, z3 = m.z[1], m.z[2], m.z[3]
    m.x_end = Constraint(expr=m.X - (2 * sin(z1) - sin(z1 - z2)) - z3 * cos(z1 - z2) == 0)
    m.y_end = Constraint(expr=m.Y - (1 - 2 * cos(z1) + cos(z1 - z2)) - z3 * sin(z1 - z2) == 0)
    m.length = Objective(expr=z1 + z2 + z3)
    return m


@lru_cache(maxsize=32)
def library_template(options: Options) -> Run:
    """Ipopt from the casadi wheel on the NL file that Pyomo writes; compiled once per setting."""
    import casadi
    from pyomo.repn.plugins.nl_writer import NLWriter

    with tempfile.TemporaryDirectory() as folder:
        file = FilePath(folder) / "model.nl"
        with file.open("w") as stream:
            # no presolve: every variable must keep its place, fixed or not
            info = NLWriter().write(pyomo_model(), stream, linear_presolve=False)
        builder = casadi.NlpBuilder()
        builder.import_nl(str(file))
    names = [variable.name for variable in info.variables]
    ours = ("z[1]", "z[2]", "z[3]", "X", "Y")
    places = [ours.index(name) for name in names]
    z_places = [names.index(name) for name in ours[:3]]
    rows = [constraint.name for constraint in info.constraints]
    ends = [rows.index("x_end"), rows.index("y_end")]
    solver = casadi.nlpsol(
        "ipopt",
        "ipopt",
        {"x": casadi.vertcat(*builder.x), "f": builder.f, "g": casadi.vertcat(*builder.g)},
        {
            "print_time": False,
            "expand": True,  # scalar expressions evaluate faster than the file's matrix ones
            "ipopt": {"print_level": 0, "sb": "yes", **dict(options)},
        },
    )
    g_low, g_high = builder.g_lb, builder.g_ub

    def run(
        start: FloatArray, lower: FloatArray, upper: FloatArray, target: tuple[float, float]
    ) -> Native:
        x0, low, high = (np.concatenate((z, target))[places] for z in (start, lower, upper))
        found = solver(x0=x0, lbx=low, ubx=high, lbg=g_low, ubg=g_high)
        stats = solver.stats()
        duals = found["lam_g"].full().ravel()[ends]
        return Native(
            found["x"].full().ravel()[z_places],
            (float(duals[0]), float(duals[1])),
            str(stats["return_status"]),
            str(stats["return_status"]).replace("_", " ").lower(),
            int(stats["iter_count"]),
            int(stats["n_call_nlp_f"]),
        )

    return run


@lru_cache(maxsize=32)
def executable_template(options: Options) -> Run:
    """The `ipopt` executable on PATH, through Pyomo; the file is rewritten for every call."""
    from pyomo.environ import SolverFactory, Suffix

    model = pyomo_model()
    model.dual = Suffix(direction=Suffix.IMPORT)
    solver = SolverFactory("ipopt", options=dict(options))

    def run(
        start: FloatArray, lower: FloatArray, upper: FloatArray, target: tuple[float, float]
    ) -> Native:
        for i, z in enumerate(model.z.values()):
            z.setlb(lower[i])
            z.setub(upper[i] if math.isfinite(upper[i]) else None)
            z.set_value(start[i], skip_validation=True)
            # the NL writer wants fixed variables marked as such, not only pinned by their bounds
            z.fixed = bool(lower[i] == upper[i])
        model.X.fix(target[0])
        model.Y.fix(target[1])
        results = solver.solve(model, load_solutions=False)
        status = str(results.solver.termination_condition)
        duals = None
        if len(results.solution):
            model.solutions.load_from(results)
            # ASL's duals have the opposite sign to Ipopt's own
            duals = (-float(model.dual[model.x_end]), -float(model.dual[model.y_end]))
        z_end = np.array([z.value for z in model.z.values()], dtype=np.float64)
        return Native(z_end, duals, status, str(results.solver.message), None, None)

    return run
