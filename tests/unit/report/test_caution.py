"""What the rows do not carry: a warning with its number, or none."""

from __future__ import annotations

import math

import pytest

from dubins_study import Path, Scenario
from dubins_study.report.statistics.methods import compared
from dubins_study.report.topics.caution import shorter_paths
from dubins_study.study.closed_form.shortest import shortest_path
from tests.unit.report.results_folder import attempt

# The target lies 9e-7 R inside the front of the left circle, at the arc angle 1; the path to it
# turns right first and is several radii long.
DEPTH = 9e-7
INSIDE = Scenario(
    0, 0, 0, (1 - DEPTH) * math.sin(1.0), 1 - (1 - DEPTH) * math.cos(1.0), 1, label="inside"
)
OUTSIDE = Scenario(0, 0, 0, 4, 1, 1)


def row(scenario, path="exact"):
    """With the proven lower end of the shortest length, here the closed form's."""
    return attempt(scenario, "slsqp", path=path, reference_low=shortest_path(scenario).length)


def caution_of(load_rows, rows):
    return shorter_paths(compared(load_rows("x", rows)))


def test_a_path_that_stops_on_the_circle_is_named(load_rows):
    """The arc of one radian misses by less than arriving allows, and is right."""
    short = Path(INSIDE.start, [1.0], [1.0])
    rows = [row(INSIDE, short), row(OUTSIDE)]
    caution = caution_of(load_rows, rows)

    assert rows[0]["verdict"] == "optimal"
    times = shortest_path(INSIDE).length / 1.0
    assert caution.estimate.value == 1
    assert "1 right answer at 1 scenario next to" in caution.sentence
    assert float(caution.sentence.split(" times shorter")[0].split()[-1]) == pytest.approx(
        times,
        rel=0.05,  # printed with two digits
    )


def test_paths_to_the_target_itself_need_no_warning(load_rows):
    assert caution_of(load_rows, [row(INSIDE), row(OUTSIDE)]) is None
