"""A program's casadi expressions rebuilt in another interface's language, or as text.

casadi keeps the functions of its SX symbols as lists of instructions. Carried out with numbers the
instructions give values; carried out with the variables of SCIP or MAiNGO they give
expressions of these, so that every engine with such an interface reads every program.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any, NamedTuple

from dubins_study.solvers.nlp_engines.program import Expressions, Program

# What Python's operators do for every type of operand, by casadi's name of the operation, and its
# text in APMonitor's language. A square is a power, which the interfaces recognise as convex, and
# not a product of two expressions.
_ARITHMETIC: dict[str, tuple[Callable[..., Any], str]] = {
    "OP_ASSIGN": (lambda a: a, "{}"),
    "OP_ADD": (operator.add, "({} + {})"),
    "OP_SUB": (operator.sub, "({} - {})"),
    "OP_MUL": (operator.mul, "({} * {})"),
    "OP_DIV": (operator.truediv, "({} / {})"),
    "OP_NEG": (operator.neg, "(0 - {})"),
    "OP_SQ": (lambda a: a**2, "(({})^((2.0)))"),
    "OP_TWICE": (lambda a: 2.0 * a, "((2.0) * {})"),
    "OP_INV": (lambda a: 1.0 / a, "((1.0) / {})"),
    "OP_POW": (operator.pow, "(({})^({}))"),
    "OP_CONSTPOW": (operator.pow, "(({})^({}))"),
}
# What each interface has functions of its own for, under the names that `math` uses too.
_FUNCTIONS = {
    f"OP_{name.upper()}": name
    for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan")
}


def rebuilt(program: Program, x: Sequence[Any], functions: Any = math) -> tuple[Any, list[Any]]:
    """A program's objective and m equations, at its parameters, in other variables x (n,).

    `functions` has attributes `sin`, `cos`, ...; those of numbers are computed by `math`. An
    operation that no interface has, such as OP_FLOOR, is a KeyError.
    """
    function, names = _function(program.expressions), _operation_names()
    given = x, program.p.tolist()
    work: list[Any] = [0.0] * function.sz_w()
    objective, equations = outputs = [0.0], [0.0] * function.numel_out(1)
    for k in range(function.n_instructions()):
        name = names[function.instruction_id(k)]
        source, place = function.instruction_input(k), function.instruction_output(k)
        if name == "OP_CONST":
            work[place[0]] = function.instruction_constant(k)
        elif name == "OP_INPUT":
            work[place[0]] = given[source[0]][source[1]]
        elif name == "OP_OUTPUT":
            outputs[place[0]][place[1]] = work[source[0]]
        else:
            operands = [work[i] for i in source]
            work[place[0]] = _operation(name, operands, functions)(*operands)
    return objective[0], equations


@lru_cache(maxsize=256)
def _function(expressions: Expressions) -> Any:
    import casadi

    sides = [casadi.densify(side) for side in (expressions.f, expressions.g)]
    return casadi.Function("sides", [expressions.x, expressions.p], sides)


def _operation(name: str, operands: list[Any], functions: Any) -> Callable[..., Any]:
    """What carries out an operation on operands."""
    numbers = all(isinstance(operand, (int, float)) for operand in operands)
    if isinstance(functions, APMonitor) and not numbers:
        return partial(functions.of, name)
    if name in _ARITHMETIC:
        return _ARITHMETIC[name][0]
    function: Callable[..., Any] = getattr(math if numbers else functions, _FUNCTIONS[name])
    return function


@lru_cache(maxsize=1)
def _operation_names() -> dict[int, str]:
    """casadi's names of its operations, by their numbers."""
    import casadi

    return {getattr(casadi, name): name for name in dir(casadi) if name.startswith("OP_")}


_LONGEST = 2000  # characters; lines may have 15000


class AlgebraText(NamedTuple):
    """A program as text; an intermediate is a name and an expression of those before it."""

    variables: list[str]
    objective: str
    equations: list[str]
    intermediates: list[tuple[str, str]]


def algebra_text(program: Program) -> AlgebraText:
    """A program at its parameters in APMonitor's language, long expressions cut in pieces."""
    text = APMonitor([])
    variables = [f"x[{i + 1}]" for i in range(program.lower.size)]
    objective, equations = rebuilt(program, variables, text)
    sides = [_operand(side) for side in equations]
    return AlgebraText(variables, _operand(objective), sides, text.intermediates)


class APMonitor(NamedTuple):
    """Operations on texts of its language, which give texts, or the names of long ones."""

    intermediates: list[tuple[str, str]]

    def of(self, operation: str, *operands: float | str) -> str:
        """The text of an operation on operands."""
        if operation in _ARITHMETIC:
            _, template = _ARITHMETIC[operation]
        else:
            template = f"{_FUNCTIONS[operation]}({{}})"
        text = template.format(*map(_operand, operands))
        if len(text) <= _LONGEST:
            return text
        self.intermediates.append((f"i{len(self.intermediates) + 1}", text))
        return self.intermediates[-1][0]


def _operand(operand: float | str) -> str:
    """An operand as text: a number to its last digit, in brackets since it may be negative."""
    return operand if isinstance(operand, str) else f"({float(operand)!r})"
