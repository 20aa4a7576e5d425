"""Rows as a table.

What no file can hold is replaced.
"""

import math

import numpy as np

from dubins_study.study.rows.parts import rows_table
from dubins_study.study.rows.schema import ROW, names

NONE = dict.fromkeys(names(ROW))


def test_numbers_that_are_not_finite_are_null():
    row = NONE | {
        "length": math.inf,
        "gap": np.float32("nan"),
        "lengths": [1.0, math.nan],
        "message": "lone \ud800",
    }
    table = rows_table([row])

    assert table["length"].to_pylist() == [None]
    assert table["gap"].to_pylist() == [None]
    assert table["lengths"].to_pylist() == [[1.0, None]]
    assert table["message"].to_pylist() == ["lone ?"]
