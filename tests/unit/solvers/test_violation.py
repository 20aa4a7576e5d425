"""Stationary points of the violation.

They are compared with geometry and a minimiser.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize

from dubins_study.solvers.nlp_engines.program import Expressions, Program
from dubins_study.solvers.nlp_engines.violation import violation_slope
from dubins_study.solvers.one_leg.model import case_of
from dubins_study.solvers.paper_nlp.case_program import program
from dubins_study.study.body_coordinates import Local, local
from dubins_study.study.scenario import Scenario


def ls_program(x: float, y: float):
    """LS to a target as a program.

    Its unknowns are the arc and the straight.
    """
    target: Local = local(Scenario(0, 0, 0, x, y, 1))
    return program(case_of("LS", target))


@pytest.mark.parametrize("polar", [(0.3, 1.0), (0.8, -2.0), (0.5, 3.0)])
def test_the_point_of_the_circle_nearest_to_a_target_inside_is_stationary(polar):
    """The nearest point of the circle is stationary.

    The target lies inside, which LS does not reach; the nearest that it comes is the foot on the
    rim.
    """
    r, at = polar
    posed = ls_program(r * math.cos(at), 1 + r * math.sin(at))
    foot = np.array([(at + math.pi / 2) % (2 * math.pi), 0.0])

    assert violation_slope(posed, foot) < 1e-12
    assert violation_slope(posed, foot + np.array([0.3, 0.0])) > 1e-3
    assert violation_slope(posed, foot + np.array([0.0, 0.3])) > 1e-3


def test_no_minimiser_of_either_norm_leaves_a_stationary_point():
    """Minimisers of either norm end at stationary points.

    SciPy's minimisers of both norms end at points whose slope is small, from anywhere.
    """
    posed = ls_program(0.2, 1.3)
    g = posed.functions.equations
    rng = np.random.default_rng(1)
    box = [(0.0, 2 * math.pi), (0.0, 10.0)]
    for guess in rng.uniform((0.5, 0.5), (5.5, 3.0), size=(6, 2)):
        euclidean = least_squares(g, guess, bounds=np.transpose(box), xtol=1e-14, ftol=1e-14).x
        total = minimize(lambda x: abs(g(x)).sum(), guess, method="Nelder-Mead", bounds=box)
        polished = minimize(
            lambda x: abs(g(x)).sum(),
            total.x,
            method="Nelder-Mead",
            bounds=box,
            options={"xatol": 1e-12, "fatol": 1e-14},
        ).x

        assert violation_slope(posed, euclidean) < 1e-4
        assert violation_slope(posed, polished) < 1e-4
        assert violation_slope(posed, guess) > 1e-3


def test_no_point_has_no_slope():
    """NaN is what an engine without a point returns."""
    assert violation_slope(ls_program(1.0, 1.0), np.full(2, np.nan)) is None


def linear(rows: list[list[float]], offset: list[float]):
    """A program of the equations rows x + offset.

    Its variables are in [-2, 2].
    """
    import casadi

    A = np.array(rows)
    x = casadi.SX.sym("x", A.shape[1])
    p = casadi.SX.sym("p", 0)
    source = Expressions(x, p, casadi.sum1(x), casadi.mtimes(casadi.DM(A), x) + casadi.DM(offset))
    ends = np.full(A.shape[1], 2.0)
    return Program(source, np.zeros(0), -ends, ends)


@pytest.mark.parametrize(
    ("rows", "offset"), [([[1.0]], [-1e-5]), ([[1e4, 0.0], [0.0, 1.0]], [0.0, -1.0])]
)
def test_what_one_step_mends_is_not_stationary(rows, offset):
    """A point that one step mends is not stationary.

    That holds however near it is to feasible, and however the equations are scaled.
    """
    program = linear(rows, offset)

    assert violation_slope(program, np.zeros(len(rows[0]))) == pytest.approx(1.0)


def test_a_row_may_have_one_end():
    """A row may have one end.

    x <= 1 is met at 0, so that x = -3, beyond the bounds, is what is left.
    """
    both = linear([[1.0], [1.0]], [0.0, 0.0])
    ends = (np.array([-np.inf, -3.0]), np.array([1.0, -3.0]))

    assert violation_slope(replace(both, bounds=ends), np.array([-2.0])) == pytest.approx(0.0)
    assert violation_slope(replace(both, bounds=ends), np.array([0.0])) > 0.3


def test_two_equations_that_contradict_each_other_are_stationary():
    """Two contradicting equations are stationary.

    x = 1 and x = -1: at 0 no step lowers the sum or the length of both violations.
    """
    assert violation_slope(linear([[1.0], [1.0]], [-1.0, 1.0]), np.zeros(1)) < 1e-9
