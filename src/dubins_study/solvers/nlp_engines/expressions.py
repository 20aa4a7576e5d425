"""A program's casadi expressions in other languages.

They become text in APMonitor's language, or expressions of another interface. casadi keeps a
function of its SX symbols as a list of instructions; each is one operation.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.minlp_engines.mixed_program import Functions, MixedProgram, Row, Written
from dubins_study.solvers.nlp_engines.program import Program

# By casadi's name of an operation; powers have spaces nowhere, and brackets around both parts.
_TEXTS = {
    "OP_ASSIGN": "{}",
    "OP_ADD": "({} + {})",
    "OP_SUB": "({} - {})",
    "OP_MUL": "({} * {})",
    "OP_DIV": "({} / {})",
    "OP_NEG": "(0 - {})",
    "OP_SQ": "(({})^((2.0)))",
    "OP_TWICE": "((2.0) * {})",
    "OP_INV": "((1.0) / {})",
    "OP_POW": "(({})^({}))",
    "OP_CONSTPOW": "(({})^({}))",
} | {
    f"OP_{name.upper()}": f"{name}({{}})"
    for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan")
}
_LONGEST = 2000  # characters; lines may have 15000


class AlgebraText(NamedTuple):
    """A program as text.

    An intermediate is a name and an expression, in which earlier intermediates may stand.
    """

    variables: list[str]
    objective: str
    equations: list[str]
    intermediates: list[tuple[str, str]]


def algebra_text(program: Program) -> AlgebraText:
    """A program as text in APMonitor's language.

    The parameters are numbers, and long expressions are cut in pieces. An operation that the
    language lacks, such as OP_FLOOR, is a KeyError.
    """
    variables = [f"x[{i + 1}]" for i in range(program.lower.size)]
    intermediates: list[tuple[str, str]] = []

    def short(text: str) -> str:
        # a long text becomes an intermediate, whose name then stands for it
        if len(text) <= _LONGEST:
            return text
        intermediates.append((f"i{len(intermediates) + 1}", text))
        return intermediates[-1][0]

    def constant(value: float) -> str:
        return f"({value!r})"  # to the last digit

    def operation(name: str, *parts: str) -> str:
        return short(_TEXTS[name].format(*parts))

    objective, equations = _evaluated(program, variables, constant, operation)
    return AlgebraText(variables, objective, equations, intermediates)


# By casadi's name of an operation; any other is a function of one argument.
_OPERATORS: dict[str, Callable[..., Any]] = {
    "OP_ASSIGN": lambda a: a,
    "OP_ADD": operator.add,
    "OP_SUB": operator.sub,
    "OP_MUL": operator.mul,
    "OP_DIV": operator.truediv,
    "OP_NEG": operator.neg,
    "OP_SQ": lambda a: a * a,
    "OP_TWICE": lambda a: 2.0 * a,
    "OP_INV": lambda a: 1.0 / a,
    "OP_POW": operator.pow,
    "OP_CONSTPOW": operator.pow,
}


def mixed_program(program: Program) -> MixedProgram:
    """The same program for engines with their own expressions.

    Its variables are all continuous.
    """

    def write(x: Sequence[Any], interface: Any) -> Written:
        functions = Functions(interface)

        def operation(name: str, *parts: Any) -> Any:
            apply = _OPERATORS.get(name) or getattr(functions, name[3:].lower())  # OP_SIN: sin
            return apply(*parts)

        objective, equations = _evaluated(program, list(x), float, operation)
        return Written(objective, [Row(side) for side in equations])

    return MixedProgram(program.lower, program.upper, np.zeros(program.lower.size, bool), write)


def _evaluated(
    program: Program,
    variables: list[Any],
    constant: Callable[[float], Any],
    operation: Callable[..., Any],
) -> tuple[Any, list[Any]]:
    """The objective and the equations in another language.

    casadi's instructions are carried out on `variables`, terms of that language. `operation` takes
    an instruction's name and operands, `constant` a number; both return a term. Returns two values:
    the objective, and a list of the equations' sides that are to be 0.
    """
    import casadi

    posed = program.expressions
    sides = [casadi.densify(posed.f), casadi.densify(posed.g)]
    function = casadi.Function("sides", [posed.x, posed.p], sides)
    names = _operation_names()
    inputs = variables, [constant(value) for value in program.p.tolist()]
    work: list[Any] = [None] * function.sz_w()  # casadi's registers
    outputs: tuple[list[Any], list[Any]] = [None], [None] * function.numel_out(1)
    for k in range(function.n_instructions()):
        name = names[function.instruction_id(k)]
        source = function.instruction_input(k)
        place = function.instruction_output(k)
        if name == "OP_OUTPUT":
            outputs[place[0]][place[1]] = work[source[0]]
        elif name == "OP_CONST":
            work[place[0]] = constant(function.instruction_constant(k))
        elif name == "OP_INPUT":
            work[place[0]] = inputs[source[0]][source[1]]
        else:
            work[place[0]] = operation(name, *(work[i] for i in source))
    [objective], equations = outputs
    return objective, equations


@cache
def _operation_names() -> dict[int, str]:
    """casadi's names of its operations, by number."""
    import casadi

    return {getattr(casadi, name): name for name in dir(casadi) if name.startswith("OP_")}
