"""A Pyomo model as a program for the engines of `solvers.minlp_engines`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.minlp_engines.program import MixedProgram, Row, Written


class Translated(NamedTuple):
    """A program, and the place of each of the model's variables in it, by Pyomo's `id` of it."""

    program: MixedProgram
    place: dict[int, int]


def translated(model: Any) -> Translated:
    """The program of a Pyomo model with equations, inequalities and one objective to minimise.

    Variables come in the order in which the constraints name them; fixed ones stay variables, with
    bounds that meet.
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
    """A Pyomo expression with other variables and functions.

    Args:
        node: the expression.
        variable: Pyomo's variable -> its counterpart.
        functions: where the other interface keeps `sin`, `cos`, ...
    """
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
