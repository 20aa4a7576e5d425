"""A mixed-integer nonlinear program, as every engine of this room takes it.

A formulation writes its program with whatever variables and functions it is given, so that an
engine gets it in expressions of its own interface.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim


class Row(NamedTuple):
    """lower <= body <= upper, in an engine's expressions; an equation if both are equal.

    Either bound may be infinite, with its sign.
    """

    body: Any
    lower: float = 0.0
    upper: float = 0.0

    def relations(self) -> list[Any]:
        """The row as one or two relations that the operators of the body's own type make."""
        if self.lower == self.upper:
            return [self.body == self.lower]
        least = [self.body >= self.lower] if math.isfinite(self.lower) else []
        most = [self.body <= self.upper] if math.isfinite(self.upper) else []
        return least + most


class Written(NamedTuple):
    """A program in an engine's expressions: the objective to be minimised, and the rows."""

    objective: Any
    rows: list[Row]


@dataclass(frozen=True, eq=False)
class MixedProgram:
    """min f(x) subject to rows and bounds; some variables are binary.

    Args:
        lower, upper: bounds of x, shape (n,); infinite where there is none.
        binary: which variables are 0 or 1, shape (n,).
        write: (the engine's variables, n of them; where it keeps `sin`, `cos`, ...) -> the program
            in these. Functions of numbers are computed.
    """

    lower: FloatArray
    upper: FloatArray
    binary: NDArray[np.bool_]
    write: Callable[[Sequence[Any], Any], Written]


class Settings(NamedTuple):
    """What every engine is asked for.

    Args:
        gap: relative difference of objective and bound at which the engine may stop.
        feastol: the engine's tolerance on equations, absolute.
        lean: without heuristics, cutting planes, presolving and propagation, where an engine can.
        cutoff: points with a larger objective are of no interest; infinite for none.
    """

    gap: float
    feastol: float
    lean: bool = False
    cutoff: float = float("inf")


class ProvenResult(NamedTuple):
    """The end of one run of an engine.

    Args:
        x: shape (n,), or None without a point.
        claim: the engine's own status as a claim: `optimal` within the gap, `infeasible`, `limit`,
            `feasible` or `failed`.
        bound: that the engine proves on the objective; minus infinity without one, infinity where
            it proves that there is no point.
        nodes: of the branch and bound, None if the engine does not count.
        iterations: of linear programs, None if the engine does not count.
        status, message: the engine's own.
    """

    x: FloatArray | None
    claim: Claim
    bound: float
    nodes: int | None
    iterations: int | None
    status: str
    message: str


# (the program, the seconds left) -> the result
MinlpEngine = Callable[[MixedProgram, float], ProvenResult]
