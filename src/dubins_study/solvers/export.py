"""The models of this study as files for other people's solvers.

(4.12) is in the scenario's own coordinates and units, the disjunctive model in body coordinates at
unit radius.
"""

from __future__ import annotations

from importlib.resources import files
from io import StringIO
from typing import Any

import numpy as np

from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.course import body_course
from dubins_study.solvers.one_leg.initial_guesses import initial_guesses
from dubins_study.solvers.one_leg.model import case_of
from dubins_study.solvers.protocol import Question
from dubins_study.study.body_coordinates import local
from dubins_study.study.scenario import Scenario
from dubins_study.study.values import did_you_mean

MODELS = ("paper", "disjunctive")
FORMATS = {"paper": ("nl", "mod", "gams"), "disjunctive": ("nl", "gams")}
# the disjunctive model has both orders in it
ORDERS = {"paper": ("LRS", "RLS"), "disjunctive": ("LRS",)}


class ExportError(DubinsStudyError, ValueError):
    """A model, format or order that cannot be written."""


def export(scenario: Scenario, model: str = "paper", format: str = "nl", order: str = "LRS") -> str:
    """A model of a scenario as the text of a file.

    `paper` is (4.12) in z1, z2 and z3, the lengths of the two turns of an order and of the
    straight; `disjunctive` the choice among LS, RS, LR and RL in z[1], z[2], z[3] (left, right,
    straight), cosines, sines and a binary a word. `nl` has no names: its first line tells them.
    """
    _check("model", model, MODELS)
    _check("format", format, FORMATS[model])
    _check("order", order, ORDERS[model])
    if not scenario.one_free_leg:
        raise ExportError("the scenario has via points or a final heading; expected neither")
    if format == "mod":
        return _mod(scenario, order)
    if model == "paper":
        program, title = _paper(scenario, order), f"model (4.12), order {order}"
    else:
        from dubins_study.solvers.global_minlp.gdp_model import gdp_model, transformed

        program = transformed(gdp_model(body_course(scenario)))
        title = "disjunctive model, unit radius, vehicle's frame"
    return _nl(program, title) if format == "nl" else _gams(program, title)


def _check(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        near = did_you_mean(value, choices)
        raise ExportError(f"{name} is {value!r}; {near}expected one of: {', '.join(choices)}")


def _guess(scenario: Scenario, order: str) -> tuple[float, ...]:
    """The first initial guess of this study's local solvers, in the scenario's unit."""
    case = case_of(order, local(scenario))
    points = initial_guesses(Question(scenario), case, "bearing", 0, 1)
    return tuple(abs(float(length)) * scenario.radius for length in next(points))  # abs: no -0.0


def _paper(scenario: Scenario, order: str) -> Any:
    """(4.12) in Pyomo. With b = -1/R its two turns are to the right and to the left."""
    from pyomo.environ import ConcreteModel, Constraint, Expression, Objective, Var, cos, sin

    R = scenario.radius if order == "LRS" else -scenario.radius
    th0 = scenario.start.heading
    m = ConcreteModel()
    for name, length in zip(("z1", "z2", "z3"), _guess(scenario, order), strict=True):
        m.add_component(name, Var(bounds=(0, None), initialize=length))
    m.theta1 = Expression(expr=th0 + m.z1 / R)
    m.theta2 = Expression(expr=m.theta1 - m.z2 / R)
    th1, th2 = m.theta1, m.theta2
    dx, dy = np.diff(scenario.points, axis=0)[0].tolist()
    m.x_end = Constraint(expr=dx - R * (-sin(th0) + 2 * sin(th1) - sin(th2)) - m.z3 * cos(th2) == 0)
    m.y_end = Constraint(expr=dy - R * (cos(th0) - 2 * cos(th1) + cos(th2)) - m.z3 * sin(th2) == 0)
    m.f = Objective(expr=m.z1 + m.z2 + m.z3)
    return m


def _nl(program: Any, title: str) -> str:
    from pyomo.repn.plugins.nl_writer import NLWriter

    stream = StringIO()
    info = NLWriter().write(program, stream, linear_presolve=False)
    names = [v.name.removesuffix(".binary_indicator_var") for v in info.variables]
    # The rest of the first line is the only place for a comment that every reader leaves alone.
    first, _, rest = stream.getvalue().partition("\n")
    return f"{first.partition('#')[0]}# dubins-study: {title}; variables {' '.join(names)}\n{rest}"


def _gams(program: Any, title: str) -> str:
    from pyomo.opt import WriterFactory

    stream = StringIO()
    everything = {"symbolic_solver_labels": True}
    WriterFactory("gams")(program, stream, lambda feature: True, everything)
    return f"* dubins-study: {title}\n{stream.getvalue().rstrip()}\n"


def _mod(scenario: Scenario, order: str) -> str:
    first, second = ("left", "right") if order == "LRS" else ("right", "left")
    template = files(__package__).joinpath("paper.mod").read_text(encoding="utf-8")
    return template.format(
        scenario=scenario,
        order=order,
        first=first,
        second=second,
        curvature="1 / R" if order == "LRS" else "-1 / R",
        z=_guess(scenario, order),
    )
