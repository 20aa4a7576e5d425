"""A mixed-integer nonlinear program for every engine here.

A formulation writes the program with the variables and functions that it is given. Each engine
therefore gets it in expressions of its own interface.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.runs import EngineResult
from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.words import Claim


class Functions:
    """An engine's functions under the names of `math`.

    `Functions(pyscipopt).sin(x)` is `pyscipopt.sin(x)` for an expression x, and `math.sin(x)` for a
    number x.
    """

    def __init__(self, interface: Any) -> None:
        self._interface = interface

    def __getattr__(self, name: str) -> Callable[[Any], Any]:
        def function(x: Any) -> Any:
            place = self._interface
            if isinstance(x, (int, float)):
                place = math
            return getattr(place, name)(x)

        return function


class Row(NamedTuple):
    """A row: lower <= body <= upper.

    The body is in an engine's expressions. Bounds may be equal, or infinite.
    """

    body: Any
    lower: float = 0.0
    upper: float = 0.0

    def relations(self) -> list[Any]:
        """The row as one or two relations.

        The operators of the body's own type make them.
        """
        if self.lower == self.upper:
            return [self.body == self.lower]
        relations = []
        if math.isfinite(self.lower):
            relations.append(self.body >= self.lower)
        if math.isfinite(self.upper):
            relations.append(self.body <= self.upper)
        return relations


class Written(NamedTuple):
    """A program in an engine's expressions.

    The objective is to be minimised.
    """

    objective: Any
    rows: list[Row]


@dataclass(frozen=True, eq=False)
class MixedProgram:
    """min f(x) subject to rows and bounds of x.

    x has shape (n,). Bounds may be infinite, and some x are binary. `write` takes the engine's n
    variables, and the object in which its interface keeps `sin`, `cos` and others.
    """

    lower: FloatArray
    upper: FloatArray
    binary: BoolArray
    write: Callable[[Sequence[Any], Any], Written]

    @property
    def variables(self) -> Iterator[tuple[float, float, bool]]:
        """Each variable's lower bound, upper bound and `binary`."""
        return zip(self.lower.tolist(), self.upper.tolist(), self.binary.tolist(), strict=True)


class Settings(NamedTuple):
    """The settings of a run, for every engine."""

    gap: float  # relative difference of objective and bound at which the engine may stop
    feastol: float  # on equations, absolute
    lean: bool = False  # without heuristics, cuts, presolving and propagation, where it can
    seed: int = 0  # of its random numbers, where it takes one


class ProvenResult(NamedTuple):
    """The end of one run of an engine.

    The claim is that of the engine's status: `optimal` within the gap. The bound is minus infinity
    if there is none. It is infinity if the engine proves that there is no point.
    """

    x: FloatArray | None  # shape (n,)
    claim: Claim
    bound: float
    nodes: int | None
    iterations: int | None  # of linear programs
    status: str
    message: str = ""

    def counted(self, iterations: int | None, evaluations: int | None = None) -> EngineResult:
        """The result as an `EngineResult` with the given counts."""
        x = self.x
        if x is None:
            x = np.empty(0)
        return EngineResult(
            x,
            self.claim,
            iterations=iterations,
            evaluations=evaluations,
            status=self.status,
            message=self.message,
        )


# (the program, the seconds left) -> the result
MinlpCall = Callable[[MixedProgram, float], ProvenResult]
