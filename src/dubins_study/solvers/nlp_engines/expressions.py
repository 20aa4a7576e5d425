"""A program's casadi expressions rebuilt in another interface's language, or as text.

casadi keeps the functions of its SX symbols as lists of instructions. Carried out with numbers the
instructions give values; carried out with the variables of Pyomo, SCIP, Gurobi or Xpress they give
expressions of these, so that every engine with such an interface reads every program.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from dubins_study.errors import DubinsStudyError
from dubins_study.solvers.nlp_engines.program import Expressions, Program

# What Python's operators do for every type of operand, by casadi's name of the operation. A square
# is a power, which the interfaces recognise as convex, and not a product of two expressions.
_ARITHMETIC: dict[str, Callable[..., Any]] = {
    "OP_ASSIGN": lambda a: a,
    "OP_ADD": operator.add,
    "OP_SUB": operator.sub,
    "OP_MUL": operator.mul,
    "OP_DIV": operator.truediv,
    "OP_NEG": operator.neg,
    "OP_SQ": lambda a: a**2,
    "OP_TWICE": lambda a: 2.0 * a,
    "OP_INV": lambda a: 1.0 / a,
    "OP_POW": operator.pow,
    "OP_CONSTPOW": operator.pow,
}
# What each interface has functions of its own for, under the names that `math` uses too.
_FUNCTIONS = {
    f"OP_{name.upper()}": name
    for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan")
}


class UnknownOperationError(DubinsStudyError, ValueError):
    """An expression holds an operation that the walk, or the other interface, does not have."""


class Rebuilt(NamedTuple):
    """A program's objective and the left-hand sides of its equations, shape (m,), rebuilt."""

    objective: Any
    equations: list[Any]


def rebuilt(program: Program, x: Sequence[Any], functions: Any = math) -> Rebuilt:
    """A program's objective and equations, at its parameters, in other variables.

    x, shape (n,), are the other interface's variables, or numbers; parameters become constants.
    `functions` has attributes `sin`, `cos`, ...; functions of numbers are computed by `math`.
    """
    function = _function(program.expressions)
    objective, equations = carried_out(function, [x, program.p.tolist()], functions)
    return Rebuilt(objective[0], equations)


@lru_cache(maxsize=256)
def _function(expressions: Expressions) -> Any:
    import casadi

    sides = [casadi.densify(side) for side in (expressions.f, expressions.g)]
    return casadi.Function("sides", [expressions.x, expressions.p], sides)


def carried_out(function: Any, given: Sequence[Sequence[Any]], functions: Any = math) -> list[Any]:
    """The outputs of a `casadi.Function` of dense SX for operands of any type.

    An input or an output is the list of its elements, column by column.

    Raises:
        UnknownOperationError: naming the operation.
    """
    names = _operation_names()
    work: list[Any] = [0.0] * function.sz_w()
    outputs: list[Any] = [[0.0] * function.numel_out(i) for i in range(function.n_out())]
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
    return outputs


def _operation(name: str, operands: list[Any], functions: Any) -> Callable[..., Any]:
    """What carries out an operation on operands."""
    if name in _ARITHMETIC:
        return _ARITHMETIC[name]
    numbers = all(isinstance(operand, (int, float)) for operand in operands)
    place = math if numbers else functions
    function: Callable[..., Any] | None = getattr(place, _FUNCTIONS.get(name, ""), None)
    if function is None:
        known = ", ".join(sorted({*_ARITHMETIC, *_FUNCTIONS}))
        where = getattr(place, "__name__", type(place).__name__)
        raise UnknownOperationError(
            f"casadi's operation {name} has no counterpart in {where}; state the program "
            f"with operations out of: {known}"
        )
    return function


@lru_cache(maxsize=1)
def _operation_names() -> dict[int, str]:
    """casadi's names of its operations, by their numbers."""
    import casadi

    return {getattr(casadi, name): name for name in dir(casadi) if name.startswith("OP_")}


class Language(NamedTuple):
    """What differs between the languages; all write `sin(x)` and `(x + 1) * y`."""

    name: str  # for messages
    variable: str  # template of the variables' names, of their numbers from 1
    power: str  # template of the first operand to the power of the second
    longest: int  # lines have a limit: an expression of more characters becomes an intermediate


class AlgebraText(NamedTuple):
    """A program as text; an intermediate is a name and an expression of those before it."""

    variables: list[str]
    objective: str
    equations: list[str]
    intermediates: list[tuple[str, str]]


def algebra_text(program: Program, language: Language) -> AlgebraText:
    """A program at its parameters, in the syntax of a language."""
    intermediates: list[tuple[str, str]] = []
    functions = _Functions(language, intermediates)
    variables = [language.variable.format(i + 1) for i in range(program.lower.size)]
    x = [_Term(name, language, intermediates) for name in variables]
    objective, equations = rebuilt(program, x, functions)
    return AlgebraText(variables, _text(objective), list(map(_text, equations)), intermediates)


class _Term:
    """An expression as text; operators and functions of terms give terms."""

    def __init__(self, text: str, language: Language, intermediates: list[tuple[str, str]]) -> None:
        if len(text) > language.longest:
            name = f"i{len(intermediates) + 1}"
            intermediates.append((name, text))
            text = name
        self.text, self.language, self.intermediates = text, language, intermediates

    def _term(self, template: str, *operands: object) -> _Term:
        text = template.format(*map(_text, operands))
        return _Term(text, self.language, self.intermediates)

    def __pow__(self, other: object) -> _Term:
        return self._term(self.language.power, self, other)

    def __neg__(self) -> _Term:
        return self._term("(0 - {})", self)


def _operators(sign: str) -> tuple[Any, Any]:
    """An operator between terms, and the one for a number on its left side."""
    template = f"({{}} {sign} {{}})"
    return (
        lambda self, other: self._term(template, self, other),
        lambda self, other: self._term(template, other, self),
    )


for _name, _sign in {"add": "+", "sub": "-", "mul": "*", "truediv": "/"}.items():
    for _prefix, _operator in zip(("__", "__r"), _operators(_sign), strict=True):
        setattr(_Term, f"{_prefix}{_name}__", _operator)


class _Functions:
    """Functions of terms, which have the names there that they have in `math`."""

    def __init__(self, language: Language, intermediates: list[tuple[str, str]]) -> None:
        self.language, self.intermediates = language, intermediates
        self.__name__ = language.name

    def __getattr__(self, name: str) -> Callable[[_Term], _Term]:
        return lambda term: _Term(f"{name}({term.text})", self.language, self.intermediates)


def _text(operand: object) -> str:
    """An operand as text: a number to its last digit, in brackets since it may be negative."""
    return operand.text if isinstance(operand, _Term) else f"({float(str(operand))!r})"
