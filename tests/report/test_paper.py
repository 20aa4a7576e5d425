"""The paper's printed tables against the closed form."""

from __future__ import annotations

import pytest

from report.paper import MISPRINTS, PRINTED, compare, segments
from study.path import Path
from study.scenario import Pose
from study.synthesis import shortest_path
from tests.report.results_folder import paper_scenarios


@pytest.fixture
def cells():
    paths = {
        (scenario.label, branch): shortest_path(scenario, branch)
        for scenario in paper_scenarios()
        for branch in ("LS", "RS")
    }
    return compare(paths)


def test_26_of_the_33_printed_cells_are_correct_roundings(cells):
    """As recomputed in 40-digit arithmetic; the other seven are known by name and reason."""
    assert len(cells) == 33
    assert cells["verdict"].value_counts().to_dict() == {"correct": 26, "misprint": 7}
    wrong = cells[cells["verdict"] == "misprint"]
    assert set(zip(wrong["label"], wrong["path"], wrong["quantity"], strict=True)) == set(MISPRINTS)


def test_printed_segments_nearly_add_up():
    """Three rounded segments add up to the rounded total within their rounding: no typing slip."""
    for row in PRINTED:
        *parts, total = [cell or 0.0 for cell in row.cells]
        assert sum(parts) == pytest.approx(total, abs=0.0151), row


def test_a_path_off_by_a_hundredth_differs(cells):
    """A cell that no misprint explains is not excused."""
    paths = {
        (scenario.label, branch): shortest_path(scenario, branch)
        for scenario in paper_scenarios()
        for branch in ("LS", "RS")
    }
    good = paths["problem 2", "LS"]
    paths["problem 2", "LS"] = Path(good.start, good.curvature, good.length + 0.01)
    changed = compare(paths)

    differs = changed[changed["verdict"] == "differs"]
    assert set(differs["label"]) == {"problem 2"}
    assert set(differs["quantity"]) == {"z1", "z3", "f"}


def test_a_row_needs_both_words():
    """Which path is optimal cannot be told from one of them."""
    scenario = paper_scenarios()[0]
    cells = compare({("problem 1", "LS"): shortest_path(scenario, "LS")})

    assert set(cells["verdict"]) == {"no answer"}


def test_a_turn_at_half_rate_counts_half():
    """Segments of a discretised path: the turn's full-rate length, the rest straight."""
    path = Path(Pose(0, 0, 0), [0.5, 0.25, 0.0, -0.5], [2.0, 1.0, 3.0, 1.0])

    assert segments(path, radius=2.0) == (2.5, 1.0, 3.5, 7.0)
