"""The topic of anytime curves."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from dubins_study.report.topics.anytime import FLOOR, anytime


def row(evaluations, lengths, solver="a"):
    via = {"via_x": [1.0], "via_y": [2.0], "verdict": "longer", "presolved": False, "late": False}
    known = {"reference_low": 10.0, "radius": 1.0, "solver": solver}
    return {**via, **known, "trace_evaluations": evaluations, "trace_lengths": lengths}


def test_curves_are_medians_of_the_best_path_so_far():
    """By hand: three attempts, of which one never has a path, at 1, 10 and 100 evaluations."""
    rows = pd.DataFrame(
        [row([1.0, 10.0], [12.0, 11.0]), row([5.0, 100.0], [14.0, 10.0]), row(None, None)]
    )

    curve = anytime(rows).set_index("evaluations")["gap"]

    assert curve.index.min() == 1
    assert curve.index.max() == pytest.approx(100)
    assert np.isinf(curve[curve.index < 4.9]).all()  # most have no path yet
    assert curve[(curve.index > 5) & (curve.index < 9.9)].unique() == pytest.approx([0.4])
    assert curve[(curve.index > 10.1) & (curve.index < 99)].unique() == pytest.approx([0.4])
    assert curve.iloc[-1] == pytest.approx(0.1)


def test_each_solver_and_number_of_legs_has_its_curve():
    """A gap of rounding is drawn at the floor."""
    rows = pd.DataFrame([row([1.0], [10.0]), row([20.0], [15.0], "b")])
    one_leg = pd.DataFrame([row([2.0], [11.0])]).assign(via_x=None, via_y=None)

    table = anytime(pd.concat([rows, one_leg]))

    ends = table.groupby(["legs", "solver"])["gap"].last()
    assert ends.to_dict() == pytest.approx({(1, "a"): 0.1, (2, "a"): FLOOR, (2, "b"): 0.5})
