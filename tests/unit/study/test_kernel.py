"""The closed form over arrays against the scalar one, row by row."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from hard_cases import hard_frame

from dubins_study.study.closed_form import kernel_math
from dubins_study.study.closed_form.kernel import NO_PATH, WORDS, Rows, shortest_rows
from dubins_study.study.closed_form.kernel_compile import SMALL, compiled
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import scenarios
from dubins_study.study.words import BRANCHES

EPS = math.ulp(1.0)
COLUMNS = ("x", "y", "heading", "target_x", "target_y", "radius")


def arrays(frame):
    return [frame[name].to_numpy() for name in COLUMNS]


@pytest.mark.parametrize("n", [3_000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("branch", BRANCHES)
def test_rows_agree_with_the_scalar_closed_form(branch, n):
    """Same words, no path in the same places, and lengths to 4 eps of max(length, R), everywhere.

    Both evaluate one formula: sine, cosine and two arctangents good to an ulp, and a dozen
    roundings, some of which agree. The words are done with the scalar's own functions.
    """
    frame = hard_frame(n, seed=n)
    rows = shortest_rows(*arrays(frame), branch=branch)

    for i, scenario in enumerate(scenarios(frame)):
        expected = shortest(scenario, branch)
        if expected is None:
            assert rows.word[i] == NO_PATH
            assert math.isnan(rows.length[i])
            continue
        assert WORDS[rows.word[i]] == expected.word, scenario
        off = abs(rows.length[i] / scenario.radius - expected.total)
        assert off <= 4 * EPS * max(expected.total, 1.0), scenario
        assert rows.length[i] == rows.first[i] + rows.second[i]


def test_threads_and_vectors_do_not_change_a_bit():
    """Threaded, alone, and one row at a time: strict IEEE arithmetic gives the same numbers."""
    data = arrays(hard_frame(700))
    many = [np.tile(column, SMALL // 700 + 2) for column in data]
    threaded = shortest_rows(*many)
    alone = shortest_rows(*data)

    for a, b in zip(threaded, alone, strict=True):
        np.testing.assert_array_equal(a[:700], b)
        np.testing.assert_array_equal(a[700:1400], b)
    for i in range(0, 700, 7):
        single = shortest_rows(*(column[i : i + 1] for column in data))
        assert [a[0] for a in single] == [a[i] for a in alone]


@pytest.mark.parametrize("radius", [1e-310, 1e-160, 1e160, 1e300])
def test_extreme_radii(radius):
    """Where the reciprocal of the radius would overflow, rows are done by division."""
    x = np.zeros(1)
    rows = shortest_rows(x, x, x, 3 * radius + x, 4 * radius + x, radius + x)

    unit = shortest_rows(x, x, x, 3 + x, 4 + x, 1 + x)
    assert WORDS[rows.word[0]] == "LS"
    assert rows.length[0] / radius == pytest.approx(unit.length[0], rel=1e-12)


def test_bad_rows_yield_nan_and_no_word():
    x = np.array([0.0, np.nan, np.inf])
    one = np.ones(3)
    rows = shortest_rows(x, one, one, one, 3 * one, one)

    np.testing.assert_array_equal(rows.word == NO_PATH, [False, True, True])
    np.testing.assert_array_equal(np.isnan(rows.length), [False, True, True])


def test_outputs_can_be_given_and_shapes_are_checked():
    data = arrays(hard_frame(10))
    out = Rows.empty(10)

    assert shortest_rows(*data, out=out).length is out.length
    assert shortest_rows(*(column[:0] for column in data)).length.shape == (0,)
    with pytest.raises(ValueError, match=r"shape \(9,\); expected \(10,\)"):
        shortest_rows(*data, out=Rows.empty(9))
    with pytest.raises(ValueError, match="no branch 'SL'"):
        shortest_rows(*data, branch="SL")


@compiled
def _elementary(angle, y, x, out):
    for i in range(angle.size):
        out[0, i], out[1, i] = kernel_math.sine_cosine(angle[i])
        out[2, i] = kernel_math.upper_arctangent(y[i], x[i])


def test_elementary_functions_are_good_to_two_ulp():
    """Against mpmath. Sine and cosine: of 1, since that is what a rotation needs."""
    rng = np.random.default_rng(1)
    angle = np.concatenate([rng.uniform(-8, 8, 1500), rng.uniform(-1e9, 1e9, 500)])
    y = np.abs(rng.standard_normal(2000)) * 10 ** rng.uniform(-12, 12, 2000)
    x = rng.standard_normal(2000) * 10 ** rng.uniform(-12, 12, 2000)
    out = np.empty((3, 2000))
    _elementary(angle, y, x, out)

    exact = np.array([[mp.sin(a), mp.cos(a)] for a in angle], dtype=object).T
    assert np.abs((out[:2] - exact).astype(float)).max() < EPS
    exact = np.array([mp.atan2(a, b) for a, b in zip(y, x, strict=True)], dtype=object)
    assert np.abs(((out[2] - exact) / exact).astype(float)).max() < 2 * EPS
