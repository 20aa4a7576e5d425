"""Rows: whatever a plug-in puts into one, no other row suffers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dubins_study.study.rows.row_table import ARROW_SCHEMA, fitting, rows_table
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


class Unspeakable:
    def __repr__(self):
        raise OSError("no")


@pytest.mark.parametrize(
    ("column", "value", "message"),
    [
        ("evaluations", "x", "TypeError: evaluations is 'x'; expected int64"),
        ("iterations", 2**80, "TypeError: iterations is 1208925819614629174706176; expected int64"),
        ("claimed_length", "long", "TypeError: claimed_length is 'long'; expected double"),
        ("lengths", [1.0, "b"], "TypeError: lengths is [1.0, 'b']; expected list<item: double>"),
        ("native_status", Unspeakable(), "TypeError: native_status is a value of type Unspeakable"),
    ],
)
def test_a_row_that_does_not_fit_is_one_that_raised(column, value, message):
    """The good rows beside it are written as they are; of the bad one, what is ours is kept."""
    good = NONE | {"scenario_id": "a", "outcome": "returned", "length": 1.0, "wall_s": 0.5}
    bad = good | {"scenario_id": "b", "word": "LS", column: value}
    one, other = rows_table([good, bad]).to_pylist()

    assert one == good
    assert (other["scenario_id"], other["wall_s"]) == ("b", 0.5)
    assert (other["outcome"], other["claim"], other["verdict"]) == ("raised", "none", "none")
    assert (other["word"], other["length"]) == (None, None)
    assert other["message"].startswith(message)
    assert fitting(bad) == other
    assert list(other) == ARROW_SCHEMA.names
