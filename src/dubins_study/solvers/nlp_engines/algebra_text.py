"""A program's expressions as text for modelling languages that programs read from a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from dubins_study.solvers.nlp_engines.expression_walk import rebuilt
from dubins_study.solvers.nlp_engines.program import Program


class Language(NamedTuple):
    """What differs between the languages; all write `sin(x)` and `(x + 1) * y`.

    Args:
        name: for messages.
        variable: template of the variables' names, of their numbers from 1.
        power: template of the first operand to the power of the second.
        longest: an expression of more characters becomes an intermediate, since lines have a limit.
    """

    name: str
    variable: str
    power: str
    longest: int


class AlgebraText(NamedTuple):
    """A program as text.

    Args:
        variables: names, shape (n,).
        objective: what is minimised.
        equations: their left-hand sides, shape (m,).
        intermediates: names and expressions, each made of those before it.
    """

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

    def __add__(self, other: object) -> _Term:
        return self._term("({} + {})", self, other)

    def __radd__(self, other: object) -> _Term:
        return self._term("({} + {})", other, self)

    def __sub__(self, other: object) -> _Term:
        return self._term("({} - {})", self, other)

    def __rsub__(self, other: object) -> _Term:
        return self._term("({} - {})", other, self)

    def __mul__(self, other: object) -> _Term:
        return self._term("({} * {})", self, other)

    def __rmul__(self, other: object) -> _Term:
        return self._term("({} * {})", other, self)

    def __truediv__(self, other: object) -> _Term:
        return self._term("({} / {})", self, other)

    def __rtruediv__(self, other: object) -> _Term:
        return self._term("({} / {})", other, self)

    def __pow__(self, other: object) -> _Term:
        return self._term(self.language.power, self, other)

    def __neg__(self) -> _Term:
        return self._term("(0 - {})", self)


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
