"""The paper's printed tables against the closed form."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from dubins_study.report.elements.style import drawing
from dubins_study.report.paper.printed import (
    PROBLEMS,
    QUANTITIES,
    committed,
    compare,
    misprints,
    segments,
)
from dubins_study.report.topics.paper import side_by_side
from dubins_study.report.topics.paper_figures import figures_section
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose
from tests.unit.report.results_folder import attempt, load_folders, paper_scenarios


@pytest.fixture
def paths():
    return {
        (scenario.label, branch): shortest_path(scenario, branch)
        for scenario in paper_scenarios()
        for branch in ("LS", "RS")
    }


@pytest.fixture
def cells(paths):
    return compare(paths)


def test_26_of_the_33_printed_cells_are_correct_roundings(cells):
    """By the closed form in doubles; the other seven are those of the audit."""
    assert len(cells) == 33
    assert cells["verdict"].value_counts().to_dict() == {"correct": 26, "misprint": 7}
    wrong = cells[cells["verdict"] == "misprint"]
    assert set(zip(wrong["label"], wrong["path"], wrong["quantity"], strict=True)) == {
        (cell["label"], cell["path"], cell["quantity"]) for cell in misprints(committed())
    }


def test_the_papers_scenarios_are_those_of_the_experiment():
    """The exact problems that the audit starts from, beside the doubles that solvers are given."""
    for scenario in paper_scenarios():
        problem = PROBLEMS[scenario.label]
        assert (scenario.target_x, scenario.target_y) == problem.target
        assert scenario.radius == problem.radius
        assert scenario.heading == pytest.approx(float(problem.heading) * math.pi, rel=1e-15)
    assert len(PROBLEMS) == len(paper_scenarios())


def test_a_crossed_number_shows_why(cells):
    """The exact text below it rounds to another number by itself; the others have six decimals."""
    lines = side_by_side(cells).fillna("").to_dict("records")
    pairs = [
        (printed[quantity], exact[quantity])
        for printed, exact in zip(lines[::2], lines[1::2], strict=True)
        for quantity in QUANTITIES
        if printed[quantity]
    ]
    crossed = {printed: exact for printed, exact in pairs if "✗" in printed}

    assert crossed["1.74 ✗"] == "1.7349999"
    assert len(crossed) == 7
    for printed, exact in pairs:
        wrong = abs(Fraction(printed.removesuffix(" ✗")) - Fraction(exact)) > Fraction("0.005")
        assert wrong == ("✗" in printed), (printed, exact)
        assert len(exact.partition(".")[2]) == (7 if printed == "1.74 ✗" else 6)


def test_a_path_off_by_a_hundredth_differs(paths):
    """A cell that no misprint explains is not excused."""
    good = paths["problem 2", "LS"]
    paths["problem 2", "LS"] = Path(good.start, good.curvatures, good.lengths + 0.01)
    changed = compare(paths)

    differs = changed[changed["verdict"] == "differs"]
    assert set(differs["label"]) == {"problem 2"}
    assert set(differs["quantity"]) == {"z1", "z3", "f"}


def test_a_row_needs_both_words():
    scenario = paper_scenarios()[0]
    cells = compare({("problem 1", "LS"): shortest_path(scenario, "LS")})

    assert set(cells["verdict"]) == {"no answer"}


def test_a_turn_at_half_rate_counts_half():
    """Segments of a discretised path: the turn's full-rate length, the rest straight."""
    path = Path(Pose(0, 0, 0), [0.5, 0.25, 0.0, -0.5], [2.0, 1.0, 3.0, 1.0])

    assert segments(path, radius=2.0) == (2.5, 1.0, 3.5, 7.0)


def test_the_papers_figures_name_their_paths(results):
    """3.1, then 6.1 to 6.5; every path is named, with its length."""
    rows = [attempt(s, branch=word) for s in paper_scenarios() for word in ("LS", "RS")]
    with drawing():
        section = figures_section(load_folders([results("paper", rows)]))
        assert section is not None
        pictures = {picture.name: picture for picture in section.blocks}
    panels = {name: picture.figure.axes for name, picture in pictures.items()}

    assert list(pictures) == ["paths-feasible", *(f"paths-{i}" for i in range(1, 6))]
    for name, lengths in (  # those of Tables 6.1 and 6.2, with one digit more
        ("paths-1", ["optimal: RS, 11.87", "feasible: LS, 16.88"]),
        ("paths-2", ["optimal: LS, 6.743", "feasible: RS, 12.96"]),
    ):
        legend = panels[name][0].get_legend()
        assert [text.get_text() for text in legend.get_texts()] == lengths
    named = {text.get_text() for text in panels["paths-feasible"][0].texts}
    assert {"P", "X₁", "X₂", "X₃ = T"} <= named
