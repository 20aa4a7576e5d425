"""A program as a model in APMonitor's language (apmonitor.com/wiki), for APOPT."""

from __future__ import annotations

import math
from collections.abc import Callable

from dubins_study.solvers.nlp_engines.expression_walk import rebuilt
from dubins_study.solvers.nlp_engines.program import Program
from dubins_study.study.path import FloatArray

# An expression longer than this becomes an intermediate variable of the model, which APMonitor
# computes from the others. Lines have a limit of 15000 characters.
_LONGEST = 2000


def model_text(program: Program, guess: FloatArray) -> str:
    """The model, its variables called x[1], ..., x[n]."""
    intermediates: list[str] = []
    x = [_Term(f"x[{i + 1}]", intermediates) for i in range(guess.size)]
    objective, equations = rebuilt(program, x, _Functions(intermediates))
    bounds = zip(x, guess.tolist(), program.lower.tolist(), program.upper.tolist(), strict=True)
    variables = [
        f"{term.text} = {value!r}" + _bound(">=", lower) + _bound("<=", upper)
        for term, value, lower, upper in bounds
    ]
    return "\n".join(
        (
            *("Model", "Variables", *variables, "End Variables"),
            *("Intermediates", *intermediates, "End Intermediates"),
            *("Equations", *(f"{_text(side)} = 0" for side in equations)),
            *(f"minimize {_text(objective)}", "End Equations", "End Model", ""),
        )
    )


def _bound(sign: str, value: float) -> str:
    return f", {sign} {value!r}" if math.isfinite(value) else ""


class _Term:
    """An expression as text; operators and functions of terms give terms."""

    def __init__(self, text: str, intermediates: list[str]) -> None:
        if len(text) > _LONGEST:
            name = f"i{len(intermediates) + 1}"
            intermediates.append(f"{name} = {text}")
            text = name
        self.text, self.intermediates = text, intermediates

    def _joined(self, left: object, sign: str, right: object) -> _Term:
        return _Term(f"({_text(left)}{sign}{_text(right)})", self.intermediates)

    def __add__(self, other: object) -> _Term:
        return self._joined(self, "+", other)

    def __radd__(self, other: object) -> _Term:
        return self._joined(other, "+", self)

    def __sub__(self, other: object) -> _Term:
        return self._joined(self, "-", other)

    def __rsub__(self, other: object) -> _Term:
        return self._joined(other, "-", self)

    def __mul__(self, other: object) -> _Term:
        return self._joined(self, "*", other)

    def __rmul__(self, other: object) -> _Term:
        return self._joined(other, "*", self)

    def __truediv__(self, other: object) -> _Term:
        return self._joined(self, "/", other)

    def __rtruediv__(self, other: object) -> _Term:
        return self._joined(other, "/", self)

    def __pow__(self, other: object) -> _Term:
        return self._joined(self, "^", other)

    def __neg__(self) -> _Term:
        return self._joined("0", "-", self)


class _Functions:
    """APMonitor's functions of terms, by the names that they have there and in `math` alike."""

    __name__ = "APMonitor"

    def __init__(self, intermediates: list[str]) -> None:
        self.intermediates = intermediates

    def __getattr__(self, name: str) -> Callable[[_Term], _Term]:
        return lambda term: _Term(f"{name}({term.text})", self.intermediates)


def _text(side: object) -> str:
    """An operand as text; negative numbers in brackets."""
    if isinstance(side, _Term):
        return side.text
    return side if isinstance(side, str) else f"({float(str(side))!r})"
