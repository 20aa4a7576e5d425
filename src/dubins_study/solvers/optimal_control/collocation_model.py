"""The optimal-control problem (2.2) transcribed by collocation: the model, compiled once.

In the vehicle's frame at unit radius and speed. Element e lasts h_e and turns by a_e at a constant
rate, so over its own time, tau from e - 1 to e,

    x' = h_e cos(theta),   y' = h_e sin(theta),   theta' = a_e,   |a_e| <= h_e.

The turn a_e stands in place of the rate u_e = a_e / h_e: the bound is then linear, the heading's
equation too, and an element of no length leaves nothing undetermined. `pyomo.dae` collocates the
states at Legendre-Gauss-Radau points, whose quadrature is exact for polynomials up to degree
2 p - 2 for p points (Biegler 2010, Nonlinear Programming, ch. 10).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.ipopt_library.deadline import Deadline
from dubins_study.solvers.ipopt_library.engine import CLAIMS, Options, compiled
from dubins_study.solvers.ipopt_library.nl_file import Program
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.optimal_control.collocation_program import Ask, asked
from dubins_study.solvers.optimal_control.elements import MOST_TURN, MOST_TURN_EACH, Elements
from dubins_study.solvers.optimal_control.transcription import Transcribed
from dubins_study.solvers.optimal_control.turn_rate_dynamics import Rates
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim


@dataclass(frozen=True, eq=False)
class Template:
    """The transcription of one choice of settings.

    Args:
        equal: whether all elements are equally long.
        element: which element a collocation point lies in, shape (m,), from 0.
        fraction: how far into it, shape (m,), in (0, 1].
        ask: the compiled program and its engine.
        deadline: when a solve stops; Ipopt's executable does not look at it.
    """

    n: int
    equal: bool
    element: Any
    fraction: FloatArray
    ask: Ask
    deadline: Deadline

    @property
    def shares(self) -> FloatArray | None:
        """As `transcription.Template.shares`."""
        return np.full(self.n, 1 / self.n) if self.equal else None

    def solve(self, guess: Elements, rates: Rates, target: FloatArray, until: float) -> Transcribed:
        """As `transcription.Template.solve`; the states of the guess follow its controls."""
        n, durations = self.n, 1 if self.equal else self.n
        values = np.concatenate((self._durations(guess), guess.turn, target, self._states(guess)))
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

    def _durations(self, guess: Elements) -> FloatArray:
        return np.array([guess.total]) if self.equal else guess.length

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
    """The transcription into n elements of so many points each, compiled once per setting.

    Args:
        engine, tol, max_iter: as `Collocation` has them.
        by_executable: whether Ipopt is the executable on PATH.
    """
    model, deadline = program(n, points, equal), Deadline()
    if engine == "ipopt":
        options = (("tol", tol), ("max_iter", max_iter), ("bound_relax_factor", 0.0))
        ask = _by_ipopt(model, options, by_executable, deadline)
    else:
        first = 1 + n if equal else 2 * n  # of X and Y
        data = slice(first, first + 2)
        ask = asked(model, data, ENGINES[engine].load()(tol, max_iter), deadline)
    element = np.repeat(np.arange(n), points)
    # not from the points' labels in the model, which Pyomo rounds
    fraction = np.tile(model.model.tau.get_discretization_info()["tau_points"][1:], n)
    return Template(n, equal, element, fraction, ask, deadline)


def _by_ipopt(model: Program, options: Options, executable: bool, deadline: Deadline) -> Ask:
    """Ipopt on the NL file as it is, with inequalities and fixed variables."""
    run = compiled(model, options, executable, deadline)

    def ask(guess: FloatArray, lower: FloatArray, upper: FloatArray) -> EngineResult:
        point, duals, status, message, iterations, evaluations = run(guess, lower, upper)
        claim = CLAIMS.get(status, Claim.FAILED)
        return EngineResult(point, claim, duals, iterations, evaluations, status, message)

    return ask


def program(n: int, points: int, equal: bool) -> Program:
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
    return Program(model, variables, [model.x_end, model.y_end])


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
