"""A program's casadi expressions as text in APMonitor's language.

casadi keeps a function of its SX symbols as a list of instructions; each is one operation's text.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

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
    """A program as text; an intermediate is a name and an expression of those before it.

    With `**` for `^` the text is Python's too.
    """

    variables: list[str]
    objective: str
    equations: list[str]
    intermediates: list[tuple[str, str]]


def algebra_text(program: Program) -> AlgebraText:
    """A program at its parameters in APMonitor's language, long expressions cut in pieces.

    An operation that the language lacks, such as OP_FLOOR, is a KeyError.
    """
    import casadi

    posed = program.expressions
    sides = [casadi.densify(posed.f), casadi.densify(posed.g)]
    function = casadi.Function("sides", [posed.x, posed.p], sides)
    names = _operation_names()
    variables = [f"x[{i + 1}]" for i in range(program.lower.size)]
    parameters = [f"({value!r})" for value in program.p.tolist()]  # to the last digit
    inputs = variables, parameters
    intermediates: list[tuple[str, str]] = []
    work = [""] * function.sz_w()
    objective = [""]
    equations = [""] * function.numel_out(1)
    outputs = objective, equations
    for k in range(function.n_instructions()):
        operation = names[function.instruction_id(k)]
        source = function.instruction_input(k)
        place = function.instruction_output(k)
        if operation == "OP_OUTPUT":
            outputs[place[0]][place[1]] = work[source[0]]
            continue
        if operation == "OP_CONST":
            text = f"({function.instruction_constant(k)!r})"
        elif operation == "OP_INPUT":
            text = inputs[source[0]][source[1]]
        else:
            text = _TEXTS[operation].format(*(work[i] for i in source))
        if len(text) > _LONGEST:
            intermediates.append((f"i{len(intermediates) + 1}", text))
            text = intermediates[-1][0]
        work[place[0]] = text
    return AlgebraText(variables, objective[0], equations, intermediates)


@cache
def _operation_names() -> dict[int, str]:
    """casadi's names of its operations, by their numbers."""
    import casadi

    return {getattr(casadi, name): name for name in dir(casadi) if name.startswith("OP_")}
