"""expression_walk: casadi's expressions carried out with other operands."""

from __future__ import annotations

import math

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.solvers.nlp_engines.expressions import UnknownOperationError, rebuilt
from dubins_study.solvers.nlp_engines.program import Expressions, Program


def program(p=(0.7, 1.3)):
    """A program in three variables that has every operation of the walk in it."""
    x, q = casadi.SX.sym("x", 3), casadi.SX.sym("q", 2)
    f = x[0] + 2 * x[1] + x[2] ** 2 + casadi.sqrt(x[0]) - casadi.exp(-x[1]) / x[2]
    turn = casadi.sin(x[0] - x[1]) * q[0] - casadi.cos(x[0]) * casadi.sin(q[1])
    powers = x[1] ** 1.5 + casadi.log(x[2]) + 1 / x[0] + x[0] ** x[2]
    inverse = casadi.atan(x[1]) + casadi.tan(q[0]) - casadi.asin(0.1 * x[2]) * casadi.acos(0.5)
    g = casadi.vertcat(turn, casadi.SX(0), powers, inverse)
    return Program(Expressions(x, q, f, g), np.array(p), np.full(3, 0.1), np.full(3, 5.0))


@given(st.lists(st.floats(0.1, 5.0), min_size=3, max_size=3))
def test_with_numbers_the_walk_is_casadis_evaluation(x):
    """The same operations in the same order; libm's functions may differ in the last digit."""
    posed = program()
    functions = posed.expressions.functions(posed.p)

    objective, equations = rebuilt(posed, x)

    assert objective == pytest.approx(functions.objective(np.array(x)), rel=1e-14, abs=1e-14)
    # sums of a few terms, the largest of them 5^5
    assert equations == pytest.approx(functions.equations(np.array(x)), rel=1e-13, abs=1e-14)


def test_parameters_become_constants():
    """Another value of the parameters gives other equations, from the same expressions."""
    sides = [rebuilt(program(p), [0.4, 1.1, 2.3])[1][0] for p in ((0.7, 1.3), (0.0, 0.0))]

    turn = math.sin(0.4 - 1.1) * 0.7 - math.cos(0.4) * math.sin(1.3)
    assert sides == pytest.approx([turn, 0.0], abs=1e-15)


def test_an_operation_that_is_not_known_is_named():
    """Neither by the walk, nor by the interface whose functions are taken."""
    x, bound = casadi.SX.sym("x"), np.ones(1)
    steps, waves = (
        Program(Expressions(x, casadi.SX.sym("p", 0), f, x), np.zeros(0), -bound, bound)
        for f in (casadi.floor(x), casadi.sin(x))
    )

    class Algebra:
        """An interface without sines, and its variable."""

    with pytest.raises(UnknownOperationError, match="OP_FLOOR has no counterpart in math"):
        rebuilt(steps, [0.5])
    with pytest.raises(UnknownOperationError, match="OP_SIN has no counterpart in Algebra"):
        rebuilt(waves, [Algebra()], Algebra())
