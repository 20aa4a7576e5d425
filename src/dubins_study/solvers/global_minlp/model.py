"""The shortest path as a generalised disjunctive program (docs/formulations/disjunction.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.minlp_engines.program import MixedProgram, Row, Written
from dubins_study.solvers.paper_nlp.model import FULL_TURN

WORDS = ("LS", "RS", "LR", "RL")
TRANSFORMATIONS = ("bigm", "hull")
_QUADRANTS = (0, 1, 2, 3)


def gdp_model(X: float, Y: float, words: tuple[str, ...] = WORDS, quadrants: bool = True) -> Any:
    """The shortest path among some words to (X, Y) radii, in Pyomo.GDP, not transformed.

    The least z[1] + z[2] + z[3] such that exactly one word leads to the target: how far the vehicle
    turns to the left, to the right (rad), and goes straight (radii); c[i] and s[i] are the cosine
    and sine of z[i], which is q[i] past the beginning of its quadrant. Without `quadrants` sines
    and cosines are of the arcs themselves, up to 2 pi.
    """
    from pyomo.environ import ConcreteModel, Constraint, Objective, RangeSet, Var, cos, sin
    from pyomo.gdp import Disjunct, Disjunction

    # No optimum has a full turn in it, and a turn moves the vehicle by its chord, at most 2 radii.
    farthest = math.hypot(X, Y) + 2
    m = ConcreteModel(name="dubins-disjunctive")
    m.turns = RangeSet(2)
    m.z = Var(RangeSet(3), bounds=lambda m, i: (0, farthest if i == 3 else FULL_TURN), initialize=1)
    m.c = Var(m.turns, bounds=(-1, 1), initialize=math.cos(1))
    m.s = Var(m.turns, bounds=(-1, 1), initialize=math.sin(1))
    if quadrants:
        _add_quadrants(m)
    else:
        m.cosine = Constraint(m.turns, rule=lambda m, i: m.c[i] == cos(m.z[i]))
        m.sine = Constraint(m.turns, rule=lambda m, i: m.s[i] == sin(m.z[i]))
    m.word = Disjunct(list(words), rule=lambda disjunct, word: _word(disjunct, word, X, Y))
    m.one_word = Disjunction(expr=[m.word[word] for word in words])
    m.length = Objective(expr=m.z[1] + m.z[2] + m.z[3])
    return m


def _add_quadrants(m: Any) -> None:
    """Variables, constraints and disjuncts that tie the arcs to their sines and cosines."""
    from pyomo.environ import Constraint, Var, cos, sin
    from pyomo.gdp import Disjunct, Disjunction

    m.q = Var(m.turns, bounds=(0, FULL_TURN / 4), initialize=1)
    m.cos_q = Var(m.turns, bounds=(0, 1), initialize=math.cos(1))
    m.sin_q = Var(m.turns, bounds=(0, 1), initialize=math.sin(1))
    m.cosine = Constraint(m.turns, rule=lambda m, i: m.cos_q[i] == cos(m.q[i]))
    m.sine = Constraint(m.turns, rule=lambda m, i: m.sin_q[i] == sin(m.q[i]))
    m.quadrant = Disjunct(m.turns, _QUADRANTS, rule=_quadrant)
    m.one_quadrant = Disjunction(m.turns, rule=lambda m, i: [m.quadrant[i, k] for k in _QUADRANTS])


def _quadrant(disjunct: Any, i: int, k: int) -> None:
    """Constraints of arc i in quadrant k: turning by pi / 2 takes (cos, sin) to (-sin, cos)."""
    from pyomo.environ import Constraint

    m = disjunct.model()
    c, s = m.cos_q[i], m.sin_q[i]
    for _ in range(k):
        c, s = -s, c
    disjunct.angle = Constraint(expr=m.z[i] == m.q[i] + k * FULL_TURN / 4)
    disjunct.cosine = Constraint(expr=m.c[i] == c)
    disjunct.sine = Constraint(expr=m.s[i] == s)


def _word(disjunct: Any, word: str, X: float, Y: float) -> None:
    """Constraints of one word: see `gdp_model`."""
    from pyomo.environ import Constraint

    m = disjunct.model()
    first, second, side = (1, 2, 1) if word[0] == "L" else (2, 1, -1)
    straight = word[1] == "S"
    scale = max(1.0, math.hypot(X, Y))
    x, y = X / scale, (side * Y - 1) / scale
    c, s = m.c[first], m.s[first]
    along = m.z[3] if straight else m.s[second]
    across = 1 if straight else 2 - m.c[second]
    disjunct.absent = Constraint(expr=m.z[second if straight else 3] == 0)
    disjunct.along = Constraint(expr=x * c + y * s == along / scale)
    disjunct.across = Constraint(expr=x * s - y * c == across / scale)


def transformed(model: Any, transformation: str = "bigm") -> Any:
    """The model as a mixed-integer nonlinear program, in place."""
    from pyomo.environ import TransformationFactory

    TransformationFactory(f"gdp.{transformation}").apply_to(model)
    return model


class Translated(NamedTuple):
    """A program, and the place of each of the model's variables in it, by Pyomo's `id` of it."""

    program: MixedProgram
    place: dict[int, int]


def translated(model: Any) -> Translated:
    """The program of a Pyomo model of equations, inequalities and one objective to minimise.

    Fixed variables stay variables, with bounds that meet.
    """
    from pyomo.core.expr.visitor import identify_variables
    from pyomo.environ import Constraint, Objective

    constraints = list(model.component_data_objects(Constraint, active=True, descend_into=True))
    (objective,) = model.component_data_objects(Objective, active=True, descend_into=True)
    variables: dict[int, Any] = {}
    for expression in (*(constraint.expr for constraint in constraints), objective.expr):
        for variable in identify_variables(expression):
            variables.setdefault(id(variable), variable)
    place = {key: n for n, key in enumerate(variables)}
    bounds = [(v.value, v.value) if v.fixed else _limits(v.lb, v.ub) for v in variables.values()]

    def write(x: Sequence[Any], functions: Any) -> Written:
        def expression(node: Any) -> Any:
            return rebuilt(node, lambda variable: x[place[id(variable)]], functions)

        rows = [Row(expression(c.body), *_limits(c.lb, c.ub)) for c in constraints]
        return Written(expression(objective.expr), rows)

    lower, upper = np.array(bounds, dtype=np.float64).T
    binary = np.array([v.is_binary() for v in variables.values()])
    return Translated(MixedProgram(lower, upper, binary, write), place)


def _limits(lower: float | None, upper: float | None) -> tuple[float, float]:
    """Pyomo's bounds, of which None is no bound."""
    return -math.inf if lower is None else lower, math.inf if upper is None else upper


def rebuilt(node: Any, variable: Callable[[Any], Any], functions: Any) -> Any:
    """A Pyomo expression with the counterparts of its variables, `sin`, `cos`, ... elsewhere."""
    if isinstance(node, (int, float)):
        return node
    if node.is_variable_type():
        return variable(node)
    if not node.is_expression_type():
        return node.value
    operands = [rebuilt(child, variable, functions) for child in node.args]
    if type(node).__name__ != "UnaryFunctionExpression":
        # Pyomo's sums, products and powers are Python's operators
        return node._apply_operation(operands)
    numbers = all(isinstance(operand, (int, float)) for operand in operands)
    return getattr(math if numbers else functions, node.name)(*operands)
