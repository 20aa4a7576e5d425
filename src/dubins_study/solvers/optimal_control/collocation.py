"""`collocation`: the optimal-control problem in `pyomo.dae`, solved as one program.

The model: docs/formulations/collocation.md. Pyomo writes it as an NL file, and casadi reads it. The
data, variables that are fixed, become parameters, and each inequality an equation with a slack
variable.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.engines import ENGINES, ipopt_executable, ipopt_in_casadi
from dubins_study.solvers.nlp_engines.program import EngineResult, Expressions, NlpCall, Program
from dubins_study.solvers.nlp_engines.pyomo_ipopt import (
    VIAS,
    Ask,
    Deadline,
    PyomoProgram,
    by_executable,
    compiled,
    nl_file,
    unavailable,
)
from dubins_study.solvers.optimal_control.arcs import MOST_TURN, MOST_TURN_EACH, Elements, Rates
from dubins_study.solvers.optimal_control.transcription import Transcribed, Transcription
from dubins_study.solvers.setting_checks import missing_package, one_of, whole
from dubins_study.study.path import FloatArray


def asked(model: PyomoProgram, data: slice, engine: NlpCall, deadline: Deadline) -> Ask:
    """A Pyomo model, whose rows have the right-hand side 0, to be solved by an engine many times.

    `data` are the places of the data, pinned by their bounds, among the variables.
    """
    import casadi as ca

    file = nl_file(model)
    lowest, highest = np.array(file.lower), np.array(file.upper)
    sided = np.flatnonzero(lowest != highest)
    places = np.arange(len(model.variables))
    free = np.delete(places, data)
    x, parameters = ca.SX.sym("x", free.size), ca.SX.sym("data", places[data].size)
    slack = ca.SX.sym("slack", sided.size)
    every = ca.SX(places.size, 1)
    every[free.tolist()], every[places[data].tolist()] = x, parameters
    f, g = ca.Function("file", [file.x], [file.f, file.g])(every[file.to_file.tolist()])
    equations = g - np.where(lowest == highest, lowest, 0.0)
    equations[sided.tolist()] -= slack
    expressions = Expressions(ca.vertcat(x, slack), parameters, f, equations)
    rows = ca.Function("rows", [x, parameters], [g[sided.tolist()]])

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> EngineResult:
        begin = np.clip(guess[free], lower[free], upper[free])
        slacks = np.clip(
            np.asarray(rows(begin, guess[data])).ravel(), lowest[sided], highest[sided]
        )
        program = Program(
            expressions,
            guess[data],
            np.concatenate((lower[free], lowest[sided])),
            np.concatenate((upper[free], highest[sided])),
            magnitude=1.0 + float(np.abs(guess[data]).sum()),
        )
        seconds = deadline.at - perf_counter()
        result = engine(program, np.concatenate((begin, slacks)), seconds)
        point = guess.copy()
        point[free] = result.x[: free.size]
        duals = None if result.duals is None else result.duals[file.rows]
        return result._replace(x=point, duals=duals)

    return ask


@dataclass(frozen=True, eq=False)
class Template:
    """The transcription of one choice of settings, compiled."""

    n: int
    equal: bool  # whether all elements are equally long
    element: Any  # which element a collocation point lies in, shape (m,), from 0
    fraction: FloatArray  # how far into it, shape (m,), in (0, 1]
    ask: Ask
    deadline: Deadline  # when a solve stops; Ipopt's executable does not look at it

    @property
    def shares(self) -> FloatArray | None:
        """As `transcription.Template.shares`."""
        return np.full(self.n, 1 / self.n) if self.equal else None

    def solve(self, guess: Elements, rates: Rates, target: FloatArray, until: float) -> Transcribed:
        """As `transcription.Template.solve`; the states of the guess follow its controls."""
        n, durations = self.n, 1 if self.equal else self.n
        times = np.array([guess.total]) if self.equal else guess.length
        values = np.concatenate((times, guess.turn, target, self._states(guess)))
        lower, upper = np.full(values.size, -math.inf), np.full(values.size, math.inf)
        lower[:durations] = 0.0
        turns, data = slice(durations, durations + n), slice(durations + n, durations + n + 2)
        # |a| <= h bounds both sides by 1; a branch's other bound is 0
        most = MOST_TURN_EACH if self.equal else MOST_TURN / n
        lower[turns], upper[turns] = max(-most, _sided(rates.lower)), min(most, _sided(rates.upper))
        lower[data] = upper[data] = target
        self.deadline.at = until
        result = self.ask(values, lower, upper)
        length = np.maximum(result.x[:durations], 0.0)
        if self.equal:
            length = np.full(n, length[0] / n)
        turn = np.clip(result.x[turns], rates.lower * length, rates.upper * length)
        return Transcribed(Elements(turn, length), result)

    def _states(self, guess: Elements) -> FloatArray:
        """x, y, theta at the collocation points and their derivatives by tau, shape (6 m,)."""
        length, turn = guess.length[self.element], guess.turn[self.element]
        before = np.cumsum(guess.length) - guess.length
        x, y, heading = guess.path.at(before[self.element] + self.fraction * length).T
        slopes = (length * np.cos(heading), length * np.sin(heading), turn)
        return np.concatenate((x, y, heading, *slopes))


def _sided(rate: float) -> float:
    return 0.0 if rate == 0 else math.copysign(math.inf, rate)


@lru_cache(maxsize=64)
def template(
    n: int, points: int, equal: bool, engine: str, tol: float, max_iter: int, by_executable: bool
) -> Template:
    """The transcription into n elements of so many points each, compiled once per setting."""
    model, deadline = program(n, points, equal), Deadline()
    if engine == "ipopt":
        options = (("tol", tol), ("max_iter", max_iter), ("bound_relax_factor", 0.0))
        # the NL file as it is, with inequalities and fixed variables
        ask = compiled(model, options, by_executable, deadline)
    else:
        first = 1 + n if equal else 2 * n  # of X and Y
        data = slice(first, first + 2)
        ask = asked(model, data, ENGINES[engine].load()(tol, max_iter), deadline)
    element = np.repeat(np.arange(n), points)
    # not from the points' labels in the model, which Pyomo rounds
    fraction = np.tile(model.model.tau.get_discretization_info()["tau_points"][1:], n)
    return Template(n, equal, element, fraction, ask, deadline)


def program(n: int, points: int, equal: bool) -> PyomoProgram:
    """The transcription with its variables in the order in which `Template.solve` gives them."""
    model = pyomo_model(n, points, equal)
    times = [tau for tau in model.tau if tau > 0]
    states = (model.x, model.y, model.theta, model.dx, model.dy, model.dtheta)
    variables = [
        *model.duration.values(),
        *model.turn.values(),
        model.X,
        model.Y,
        *(state[tau] for state in states for tau in times),
    ]
    return PyomoProgram(model, variables, [model.x_end, model.y_end])


def pyomo_model(n: int, points: int, equal: bool) -> Any:
    """The transcription in Pyomo; the target is a pair of variables X, Y to be fixed."""
    from pyomo.dae import ContinuousSet, DerivativeVar
    from pyomo.environ import (
        ConcreteModel,
        Constraint,
        Objective,
        RangeSet,
        TransformationFactory,
        Var,
        cos,
        sin,
    )

    m = ConcreteModel(name="dubins-2.2")
    m.tau = ContinuousSet(initialize=range(n + 1))
    m.elements = RangeSet(n)
    m.duration = Var([1] if equal else m.elements, bounds=(0, None), initialize=1.0)
    m.turn = Var(m.elements, initialize=0.0)
    m.X, m.Y = Var(initialize=1.0), Var(initialize=1.0)
    m.x, m.y, m.theta = (Var(m.tau, initialize=0.0) for _ in range(3))
    m.dx, m.dy, m.dtheta = (DerivativeVar(state, wrt=m.tau) for state in (m.x, m.y, m.theta))
    TransformationFactory("dae.collocation").apply_to(
        m, wrt=m.tau, nfe=n, ncp=points, scheme="LAGRANGE-RADAU"
    )
    for state in (m.x, m.y, m.theta):
        state[0].fix(0.0)

    def length(e: int) -> Any:
        return m.duration[1] / n if equal else m.duration[e]

    times = {tau: math.ceil(tau) for tau in m.tau if tau > 0}
    m.east = Constraint(times, rule=lambda m, t: m.dx[t] == length(times[t]) * cos(m.theta[t]))
    m.north = Constraint(times, rule=lambda m, t: m.dy[t] == length(times[t]) * sin(m.theta[t]))
    m.bend = Constraint(times, rule=lambda m, t: m.dtheta[t] == m.turn[times[t]])
    m.left = Constraint(m.elements, rule=lambda m, e: m.turn[e] <= length(e))
    m.right = Constraint(m.elements, rule=lambda m, e: -m.turn[e] <= length(e))
    m.x_end = Constraint(expr=m.X - m.x[n] == 0)
    m.y_end = Constraint(expr=m.Y - m.y[n] == 0)
    m.length = Objective(expr=sum(m.duration.values()))
    return m


@dataclass(frozen=True)
class Collocation(Transcription):
    """Problem (2.2) collocated at Legendre-Gauss-Radau points; other settings: `Transcription`.

    Args:
        points: collocation points in each element.
        engine: Ipopt reads Pyomo's file as it is; the others get it by `asked`.
        via: how Ipopt is reached: `executable`, `library` or `auto`: the executable if PATH has
            one.
    """

    points: int = whole(5, 1, 10)  # more than ten Radau points are lost in rounding
    via: str = one_of("auto", VIAS)

    name: ClassVar[str] = "collocation"
    formulation: ClassVar[str] = "Radau collocation"
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "optimal control collocated in pyomo.dae, free elements"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 6, "points": 6, "tol": 1e-11},
    }

    def unavailable(self) -> str | None:
        if self.engine == "ipopt":
            return unavailable(self.via)
        return missing_package("pyomo", "casadi") or super().unavailable()

    @property
    def keeps_limit(self) -> bool:
        # Pyomo lets the executable run; compiling takes 0.4 s at 500 points and 5 s at 5000
        quick = not by_executable(self.via) and self.n * self.points <= 250
        return self.engine == "ipopt" and quick

    def library_versions(self) -> dict[str, str]:
        if self.engine != "ipopt":
            return super().library_versions()
        return ipopt_executable() if by_executable(self.via) else ipopt_in_casadi()

    def template(self, distance: float) -> Template:
        equal, executable = self.mesh == "equal", by_executable(self.via)
        numbers = self.tol, self.max_iter
        return template(self.n, self.points, equal, self.engine, *numbers, executable)
