"""`collocation`: the optimal-control problem in `pyomo.dae`.

It is solved as one program. The model: docs/formulations/collocation.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.arcs import Elements, Rates, most_turn
from dubins_study.solvers.course import Course
from dubins_study.solvers.engines import ENGINES, program_engine
from dubins_study.solvers.nlp_engines.pyomo_program import Ask, PyomoProgram, asked
from dubins_study.solvers.optimal_control.transcription import (
    Guess,
    NlpTranscription,
    Template,
    Transcribed,
)
from dubins_study.solvers.setting_checks import whole
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import NLP


class Collocated(NamedTuple):
    """The compiled transcription of one choice of settings."""

    fraction: FloatArray  # how far into its element each point lies, shape (points,), in (0, 1]
    ask: Ask


@lru_cache(maxsize=64)
def template(shape: Shape, engine: str, tol: float, max_iter: int, options: str) -> Collocated:
    """A compiled transcription.

    It is compiled once for each choice of settings and number of legs.
    """
    model = pyomo_model(shape)
    times = [tau for tau in model.tau if tau > 0]
    states = (model.x, model.y, model.theta, model.dx, model.dy, model.dtheta)
    controls = [*model.duration.values(), *model.turn.values()]
    # in the order in which `Collocation.template` gives them
    unknowns = [*controls, *(state[tau] for state in states for tau in times)]
    end = [model.passes[2 * shape.legs - 2], model.passes[2 * shape.legs - 1]]
    program = PyomoProgram(model, unknowns, list(model.data.values()), end)
    library = ENGINES.get(engine) or program_engine(engine, NLP)
    call = library.load()(tol, max_iter, options)
    ask = asked(program, call, native=engine == "ipopt")
    # not from the points' labels in the model, which Pyomo rounds
    fraction = np.array(model.tau.get_discretization_info()["tau_points"][1:])
    return Collocated(fraction, ask)


class Shape(NamedTuple):
    """The sizes of a collocation.

    `n` counts elements of a leg, `points` the points of an element. `equal` says that elements are
    equally long, `final` that a final heading is given.
    """

    n: int
    points: int
    equal: bool
    legs: int
    final: bool


def pyomo_model(shape: Shape) -> Any:
    """The transcription in Pyomo.

    The variables are the states `x`, `y` and `theta` at the collocation points, the `turn` (rad) of
    each element, and durations (radii). There is a `duration` for each leg if the elements are
    equal, else for each element. `data`, the points and a final heading, are variables for the
    caller to fix.
    """
    from pyomo import environ as pyo
    from pyomo.dae import ContinuousSet, DerivativeVar

    n, points, equal, legs, final = shape
    m = pyo.ConcreteModel(name="dubins-2.2")
    m.tau = ContinuousSet(initialize=range(n * legs + 1))
    m.elements = pyo.RangeSet(n * legs)
    timed = m.elements
    if equal:
        timed = pyo.RangeSet(legs)
    m.duration = pyo.Var(timed, bounds=(0, None), initialize=1.0)
    m.turn = pyo.Var(m.elements, initialize=0.0)
    m.data = pyo.Var(range(2 * legs + final), initialize=1.0)
    m.x, m.y, m.theta = (pyo.Var(m.tau, initialize=0.0) for _ in range(3))
    m.dx, m.dy, m.dtheta = (DerivativeVar(state, wrt=m.tau) for state in (m.x, m.y, m.theta))
    pyo.TransformationFactory("dae.collocation").apply_to(
        m, wrt=m.tau, nfe=n * legs, ncp=points, scheme="LAGRANGE-RADAU"
    )
    for state in (m.x, m.y, m.theta):
        state[0].fix(0.0)

    def length(e: int) -> Any:
        if equal:
            return m.duration[(e - 1) // n + 1] / n
        return m.duration[e]

    times = {tau: math.ceil(tau) for tau in m.tau if tau > 0}  # the element of each point
    m.east = pyo.Constraint(
        times, rule=lambda m, t: m.dx[t] == length(times[t]) * pyo.cos(m.theta[t])
    )
    m.north = pyo.Constraint(
        times, rule=lambda m, t: m.dy[t] == length(times[t]) * pyo.sin(m.theta[t])
    )
    m.bend = pyo.Constraint(times, rule=lambda m, t: m.dtheta[t] == m.turn[times[t]])
    m.left = pyo.Constraint(m.elements, rule=lambda m, e: m.turn[e] <= length(e))
    m.right = pyo.Constraint(m.elements, rule=lambda m, e: -m.turn[e] <= length(e))
    passed = [state[n * leg] for leg in range(1, legs + 1) for state in (m.x, m.y)]
    m.passes = pyo.Constraint(range(2 * legs), rule=lambda m, i: m.data[i] - passed[i] == 0)
    if final:  # as `course.heading_gap`
        heading = m.theta[n * legs] - m.data[2 * legs]
        m.arrives = pyo.Constraint(expr=2 * pyo.sin(heading / 2) == 0)
    m.length = pyo.Objective(expr=sum(m.duration.values()))
    return m


@dataclass(frozen=True)
class Collocation(NlpTranscription):
    """Problem (2.2) collocated at Legendre-Gauss-Radau points.

    Other settings: `NlpTranscription`.

    Args:
        points: collocation points in each element.
        engine: Ipopt reads Pyomo's file as it is; the others get it with slack variables.
    """

    points: int = whole(5, 1, 10)  # more than ten Radau points are lost in rounding

    name = "collocation"
    formulation = "Radau collocation"
    packages = ("pyomo", "casadi")
    summary = "optimal control collocated in pyomo.dae, free elements"
    profiles: ClassVar = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 6, "points": 6, "tol": 1e-11},
    }

    def template(self, course: Course) -> Template:
        n = self.n
        legs = course.legs
        equal = self.mesh == "equal"
        shape = Shape(n, self.points, equal=equal, legs=legs, final=course.last is not None)
        compiled = template(shape, self.engine, self.tol, self.max_iter, self.options)

        def solve(guess: Guess, rates: Rates, until: float) -> Transcribed:
            """Solve from a guess.

            The guess has controls, from which its states follow. The values are in the order of the
            unknowns in `template`.
            """
            turn, length = guess.elements
            times = length
            if equal:
                times = length.reshape(legs, -1).sum(axis=1)
            fraction = compiled.fraction
            each_turn = np.repeat(turn, fraction.size)
            each_length = np.repeat(length, fraction.size)
            x, y, heading = guess.states(legs, fraction).T
            dx = each_length * np.cos(heading)
            dy = each_length * np.sin(heading)
            values = np.concatenate((times, turn, x, y, heading, dx, dy, each_turn))
            lower = np.full(values.size, -math.inf)
            upper = np.full(values.size, math.inf)
            lower[: times.size] = 0.0
            turns = slice(times.size, times.size + turn.size)
            # the rows |turn| <= length bound the rate; LS and RS have 0 as their bound on one side
            most = most_turn(course, n, equal)
            lower[turns] = most * rates.lower
            upper[turns] = most * rates.upper
            result = compiled.ask(values, course.data, lower, upper, until - perf_counter())
            length = np.maximum(result.x[: times.size], 0.0)
            if equal:
                length = np.repeat(length / n, n)
            return Transcribed(Elements(result.x[turns], length).within(rates), result)

        shares = None
        if equal:
            shares = np.full((legs, n), 1 / n)
        return Template(shares, solve)
