"""The paper's tables, figures and sweeps.

Its printed tables are compared with the closed form; the sweeps are over the radius.
"""

import math
from fractions import Fraction

import pandas as pd
import pytest

from dubins_study.report.elements.style import drawing
from dubins_study.report.paper.printed import (
    CORRECT,
    PROBLEMS,
    QUANTITIES,
    committed,
)
from dubins_study.report.topics.paper import side_by_side
from dubins_study.report.topics.paper_figures import figures_section
from dubins_study.report.topics.radius import (
    radius_section,
    sweep_rows,
    visibly_wrong,
    warm_section,
    warm_starts,
)
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt, load_folders, paper_scenarios


@pytest.fixture
def cells():
    return pd.DataFrame(committed()["cells"])


def test_26_of_the_33_cells_are_correct_roundings(cells):
    assert (cells["verdict"] == CORRECT).sum() == 26
    assert len(cells) == 33


def test_the_papers_scenarios_are_those_of_the_experiment():
    """The paper's scenarios are the experiment's.

    The audit starts from the exact problems; solvers are given the doubles beside them.
    """
    for scenario in paper_scenarios():
        problem = PROBLEMS[scenario.label]
        assert (scenario.target_x, scenario.target_y) == problem.target
        assert scenario.radius == problem.radius
        assert scenario.heading == pytest.approx(float(problem.heading) * math.pi, rel=1e-15)
    assert len(PROBLEMS) == len(paper_scenarios())


def test_a_crossed_number_shows_why(cells):
    """A crossed number shows why.

    The exact text below it rounds to another number by itself.
    """
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


def test_the_papers_figures_name_their_paths(results):
    """The paper's figures name their paths.

    They are 6.1 to 6.5; every path is named, with its length.
    """
    rows = [attempt(s, branch=word) for s in paper_scenarios() for word in ("LS", "RS")]
    with drawing():
        section = figures_section(load_folders([results("paper", rows)]))
        assert section is not None
        pictures = {picture.name: picture for picture in section.blocks}
    panels = {name: picture.figure.axes for name, picture in pictures.items()}

    assert list(pictures) == [f"paths-{i}" for i in range(1, 6)]
    for name, lengths in (  # those of Tables 6.1 and 6.2, with one digit more
        ("paths-1", ["optimal: RS, 11.87", "feasible: LS, 16.88"]),
        ("paths-2", ["optimal: LS, 6.743", "feasible: RS, 12.96"]),
        ("paths-5", ["R = 25: LS, 85.00", "R = 10: LS, 83.36", "R = 5: LS, 82.89"]),
    ):
        legend = panels[name][0].get_legend()
        assert [text.get_text() for text in legend.get_texts()] == lengths


RADII = (20.0, 40.0, 55.0, 60.0, 80.0)  # the target enters a circle at 57.35


def where(radius):
    """Test problem 5 at some radius."""
    return Scenario(0, 0, 2.0943951023931953, -80, 20, radius, label="problem 5")


def folder_rows():
    """Right, longer, lost and missing answers.

    One is by 0.5 % and one by 50 % too long, one is lost, and a radius is not asked.
    """
    exact = {"formulation": "closed form", "engine": "closed form"}
    rows = [attempt(where(radius), **exact) for radius in RADII]
    rows += [attempt(where(radius), "slsqp", wall_s=1e-3) for radius in RADII if radius != 55.0]
    rows += [attempt(where(radius), "slsqp", initial_guess="warm", wall_s=9.0) for radius in RADII]
    columns = {"verdict": "longer", "formulation": "turn rates"}
    rows += [
        attempt(where(20.0), "turn-rate-qp", gap=0.005, **columns),
        attempt(where(40.0), "turn-rate-qp", gap=0.5, **columns),
    ]
    wrong = {"path": astray(where(55.0)), "claim": Claim.FAILED, "formulation": "turn rates"}
    rows.append(attempt(where(55.0), "turn-rate-qp", **wrong))
    return rows


@pytest.fixture
def loaded(load_rows):
    return load_rows("radius-sweep", folder_rows())


def test_only_visibly_wrong_answers_are_drawn(loaded):
    """Only visibly wrong answers are drawn.

    Half a percent lies on the line of the shortest lengths.
    """
    (rows,) = sweep_rows(loaded.rows).values()
    lines = visibly_wrong(rows)

    assert lines["radius"].tolist() == [40.0, 55.0]
    assert lines["gap"].notna().tolist() == [True, False]


def test_a_sweep_is_a_figure_that_names_the_words_and_the_circle(loaded):
    section = radius_section(loaded)
    assert section is not None
    texts = [text.get_text() for text in section.blocks[0].figure.axes[0].texts]

    assert "R* = 57.35" in texts
    assert [text for text in texts if text in ("LS", "RS", "RL", "LR")] == ["LS", "RL"]


def sweep_scenario(radius):
    return Scenario(0, 0, 0, -3, 4, radius, label="sweep")


def warm_rows():
    """Solvers that save, pay or do nothing, warm.

    One saves, one pays, two are the same: one counts no iterations, the other none for a cold
    start.
    """
    attempts = []
    for place, radius in enumerate((1.0, 1.1, 1.2, 1.3, 1.4)):
        where = sweep_scenario(radius)
        for start, time, work in (("cold", 0.01, 10), ("warm", 0.001 * (place + 1), 5)):
            attempts.append(
                attempt(where, "ipopt", initial_guess=start, wall_s=time, iterations=work)
            )
        for start, time, work in (("cold", 0.01, 10), ("warm", 0.02, 30)):
            attempts.append(
                attempt(where, "slsqp", initial_guess=start, wall_s=time, iterations=work)
            )
        attempts += [
            attempt(where, solver, initial_guess=start, iterations=iterations)
            for solver, counts in (("shooting", (None, None)), ("penalty", (0, 3)))
            for start, iterations in zip(("cold", "warm"), counts, strict=True)
        ]
        attempts.append(attempt(where, "never-warm"))
    return attempts


def test_ratios_by_hand(load_rows):
    """Ratios by hand.

    Ratios are 0.1 to 0.5 in five steps; iterations are halved; without a number there is no ratio.

    A solver that is never warm is left out.
    """
    results = load_rows("radius-sweep", warm_rows())
    table = warm_starts(results.rows).set_index("solver")

    assert table.index.tolist() == ["ipopt", "penalty", "shooting", "slsqp"]
    assert table.loc["ipopt", ["questions", "ratio", "work"]].tolist() == pytest.approx(
        [5, 0.3, 0.5]
    )
    assert table.loc[["shooting", "penalty"], "work"].isna().all()
    assert warm_section(results).blocks[0].name == "warm-starts"
    cold = [row for row in warm_rows() if row["initial_guess"] == "cold"]
    assert warm_section(load_rows("cold", cold)) is None
