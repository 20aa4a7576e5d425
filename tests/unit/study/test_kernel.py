"""The closed form over arrays; the adversary compares its lengths with the scalar form's."""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases import hard_frame

from dubins_study.study.closed_form.kernel import NO_PATH, Rows, shortest_rows
from dubins_study.study.closed_form.kernel_compile import SMALL

COLUMNS = ("x", "y", "heading", "target_x", "target_y", "radius")


def arrays(frame):
    return [frame[name].to_numpy() for name in COLUMNS]


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
