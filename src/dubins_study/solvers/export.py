"""Models of this study as files for other solvers.

(4.12) is in the scenario's own coordinates and units. The disjunctive model is in body coordinates
at unit radius.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from importlib.resources import files
from io import StringIO
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.course import body_course
from dubins_study.solvers.highs import highs_holding, highs_rows
from dubins_study.solvers.nlp_engines.expressions import mixed_program
from dubins_study.solvers.nlp_engines.nl_file import nl_file, pyomo_model
from dubins_study.solvers.one_leg.initial_guesses import initial_guesses
from dubins_study.solvers.one_leg.model import case_of
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.registry import load
from dubins_study.study.body_coordinates import local
from dubins_study.study.scenario import Scenario
from dubins_study.study.specs import name_of
from dubins_study.study.values import did_you_mean

MODELS = ("paper", "disjunctive")
FORMATS = {"paper": ("nl", "mod", "gams"), "disjunctive": ("nl", "gams")}
# the disjunctive model has both orders in it
ORDERS = {"paper": ("LRS", "RLS"), "disjunctive": ("LRS",)}


class ExportError(DubinsStudyError, ValueError):
    """A model, format or order that cannot be written."""


def export(scenario: Scenario, model: str = "paper", format: str = "nl", order: str = "LRS") -> str:
    """Write a model of a scenario as text.

    `paper` is (4.12) in z1, z2 and z3: the lengths of the two turns of an order and of the
    straight. `disjunctive` is the choice among LS, RS, LR and RL, in z[1], z[2], z[3] (left, right,
    straight), cosines, sines and one binary for each word. The format `nl` has no names of
    variables; its first line lists them.
    """
    _check("model", model, MODELS)
    _check("format", format, FORMATS[model])
    _check("order", order, ORDERS[model])
    if not scenario.one_free_leg:
        raise ExportError("the scenario has via points or a final heading; expected neither")
    if format == "mod":
        return _mod(scenario, order)
    if model == "paper":
        program = _paper(scenario, order)
        title = f"model (4.12), order {order}"
    else:
        from dubins_study.solvers.global_minlp.gdp_model import gdp_model, transformed

        program = transformed(gdp_model(body_course(scenario)))
        title = "disjunctive model, unit radius, vehicle's frame"
    if format == "nl":
        return nl_file(program, title).text
    return _gams(program, title)


def _check(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        near = did_you_mean(value, choices)
        raise ExportError(f"{name} is {value!r}; {near}expected one of: {', '.join(choices)}")


def _guess(scenario: Scenario, order: str) -> tuple[float, ...]:
    """The first initial guess of the local solvers.

    Returns z1, z2 and z3 in the scenario's unit.
    """
    case = case_of(order, local(scenario))
    points = initial_guesses(Question(scenario), case, "bearing", seed=0, count=1)
    return tuple(abs(float(length)) * scenario.radius for length in next(points))  # abs: no -0.0


def _paper(scenario: Scenario, order: str) -> Any:
    """The model (4.12) in Pyomo.

    For the order RLS the radius is negative: the first turn is then to the right.
    """
    from pyomo.environ import ConcreteModel, Constraint, Expression, Objective, Var, cos, sin

    R = scenario.radius
    if order == "RLS":
        R = -R
    th0 = scenario.start.heading
    m = ConcreteModel()
    for name, length in zip(("z1", "z2", "z3"), _guess(scenario, order), strict=True):
        m.add_component(name, Var(bounds=(0, None), initialize=length))
    m.theta1 = Expression(expr=th0 + m.z1 / R)
    m.theta2 = Expression(expr=m.theta1 - m.z2 / R)
    th1 = m.theta1
    th2 = m.theta2
    dx, dy = np.diff(scenario.points, axis=0)[0].tolist()
    m.x_end = Constraint(expr=dx - R * (-sin(th0) + 2 * sin(th1) - sin(th2)) - m.z3 * cos(th2) == 0)
    m.y_end = Constraint(expr=dy - R * (cos(th0) - 2 * cos(th1) + cos(th2)) - m.z3 * sin(th2) == 0)
    m.f = Objective(expr=m.z1 + m.z2 + m.z3)
    return m


def _gams(program: Any, title: str) -> str:
    from pyomo.opt import WriterFactory

    stream = StringIO()
    options = {"symbolic_solver_labels": True}
    # the writer asks of each feature whether the reader has it: yes
    WriterFactory("gams")(program, stream, lambda feature: True, options)
    return f"* dubins-study: {title}\n{stream.getvalue().rstrip()}\n"


def _mod(scenario: Scenario, order: str) -> str:
    first = "left"
    second = "right"
    curvature = "1 / R"
    if order == "RLS":
        first = "right"
        second = "left"
        curvature = "-1 / R"
    template = files(__package__).joinpath("paper.mod").read_text(encoding="utf-8")
    return template.format(
        scenario=scenario,
        order=order,
        first=first,
        second=second,
        curvature=curvature,
        z=_guess(scenario, order),
    )


# The texts of a question's files, by the ends of the files' names: {".nl": "g3 1 1 0 ..."}.
Texts = dict[str, str]


def texts_of(formulation: str) -> Callable[[Question], Texts]:
    """The function that writes a question's files.

    `formulation` is `paper`, or the spec of a solver. The function raises an `ExportError` if the
    formulation does not take the question.
    """
    _check("formulation", name_of(formulation), tuple(WRITERS))
    write = WRITERS[name_of(formulation)]
    if formulation == "paper":
        return lambda question: write(None, question)
    solver = load(formulation)

    def texts(question: Question) -> Texts:
        scenario = question.scenario
        branch = question.branch
        lacking = [need for need in scenario.needs if need not in solver.takes]
        if branch not in solver.branches:
            lacking.append(f"the branch {branch}")
        if lacking:
            raise ExportError(f"{formulation} does not take: {', '.join(lacking)}")
        return write(solver, question)

    return texts


def _paper_texts(_: Any, question: Question) -> Texts:
    if question.branch != "best":
        raise ExportError(f"(4.12) is asked for the best path, not for {question.branch}")
    return {f"-{order}.nl": export(question.scenario, order=order) for order in ORDERS["paper"]}


def _route_texts(solver: Any, question: Question) -> Texts:
    """A route's program as an NL file.

    The file's starting point is the solver's first initial guess.
    """
    model = solver.build(question)
    program = pyomo_model(mixed_program(model.program), solver.first_guess(model))
    title = f"{solver.name}, radii, from the start; of each leg its arcs and the heading after"
    return {".nl": nl_file(program, title).text}


def _disjunction_texts(solver: Any, question: Question) -> Texts:
    model = solver.build(question)
    if isinstance(model, Solution):
        raise ExportError(model.message)
    title = "disjunctive model, unit radius, vehicle's frame"
    return {".nl": nl_file(model.pyomo, title).text}


def _grid_texts(solver: Any, question: Question) -> Texts:
    """A mixed-integer linear program as an MPS file.

    The column of an arc is named by the places and headings (rad) at its ends:
    `p0h0.000000_p1h1.570796`. Further columns are y0, y1, ...
    """
    graph, program = solver.build(question)
    if graph.places.count > 2 and getattr(solver, "model", "") == "cuts":
        raise ExportError("tour-milp[model=cuts] adds rows while it runs; expected flow or mtz")
    # the fields of `LinearProgram` are the parameters of `highs_rows`, in their order
    linear = highs_rows(*program)
    ends = [f"p{place}h{h:.6f}" for place, h in zip(graph.owner, graph.headings, strict=True)]
    arcs = zip(graph.tails.tolist(), graph.heads.tolist(), strict=True)
    names = [f"{ends[tail]}_{ends[head]}" for tail, head in arcs]
    linear.col_names_ = names + [f"y{i}" for i in range(program.cost.size - len(names))]
    with tempfile.TemporaryDirectory() as folder:
        file = FilePath(folder) / "model.mps"
        highs_holding(linear, {}).writeModel(str(file))
        return {".mps": file.read_text(encoding="utf-8")}


def _convex_texts(_: Any, question: Question) -> Texts:
    """A frozen convex problem as a CBF file.

    A problem without cones is written as a QPS file too.
    """
    from dubins_study.study.convex.formats import cbf_text, qps_text
    from dubins_study.study.convex.problem import posed

    name = question.scenario.label
    problem = posed(name)
    texts = {".cbf": cbf_text(problem)}
    if not problem.cones.size:
        texts[".qps"] = qps_text(problem, name)
    return texts


# By the formulation's name: the function that writes the files of a question.
WRITERS: dict[str, Callable[[Any, Question], Texts]] = {
    "paper": _paper_texts,
    "route-nlp": _route_texts,
    "disjunctive": _disjunction_texts,
    "heading-milp": _grid_texts,
    "tour-milp": _grid_texts,
    "convex": _convex_texts,
}
