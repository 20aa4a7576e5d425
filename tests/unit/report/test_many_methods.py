"""A page of fifty solvers: figures stay on a screen, tables in their frame, nothing explodes."""

from __future__ import annotations

import re

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.elements.content import Picture
from dubins_study.report.elements.figure_file import figure_bytes
from dubins_study.report.elements.style import RULE, drawing
from dubins_study.report.page.render import render
from dubins_study.report.page.sections import TOPICS, sections_of
from dubins_study.report.statistics.methods import MOST_ENGINES
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import FORMULATIONS, Claim
from tests.unit.report.results_folder import attempt, write_folder

# The page's column is 984 pixels wide on a screen of 1280 by 900, half of it 478.
SCREEN = {False: 900 / 984, True: 900 / 478}
ENGINES = [f"engine {n}" for n in range(14)]
SCENARIOS = [Scenario(0, 0, 0, x, y) for x, y in ((4, 1), (5, -2), (-3, 2))]


def rows():
    """Fourteen engines on one formulation, five on each of the others; most answers are right."""
    for place, formulation in enumerate(FORMULATIONS[1:]):
        for number, engine in enumerate(ENGINES if place == 0 else ENGINES[:5]):
            for n, scenario in enumerate(SCENARIOS):
                right = (number + n + place) % 5 > 0
                yield attempt(
                    scenario,
                    f"s{place}[engine={number},a_setting_with_a_long_name=1]",
                    path="exact" if right else Path(scenario.start, [0.0], [1.0]),
                    claim=Claim.LOCAL if right else Claim.FAILED,
                    scenario_id=str(n),
                    formulation=formulation,
                    engine=engine,
                    wall_s=1e-3 * (1 + number),
                )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Sixty-four solvers in a folder."""
    return write_folder(tmp_path_factory.mktemp("many") / "many", "many", rows())


@pytest.fixture(scope="module")
def sections(folder):
    """Every section of their page."""
    results = load([folder])
    return {s.key: s for topic in TOPICS for s in sections_of(topic, results)}


def pictures(sections):
    return [b for s in sections.values() for b in s.blocks if isinstance(b, Picture)]


def is_curve(line):
    """Whether a line is a curve with a colour: not a rule beside a name, nor grey behind others."""
    return line.get_clip_on() and len(line.get_xdata()) > 2 and line.get_color() != RULE


def test_no_figure_is_taller_than_a_screen(sections):
    drawn = pictures(sections)

    assert {"verdicts", "times", "performance", "gap-profile-many"} <= {p.name for p in drawn}
    for block in drawn:
        width, height = block.figure.get_size_inches()
        assert height / width <= SCREEN[block.half], block.name


def test_no_panel_has_more_than_ten_methods(sections):
    """Neither bars with names nor curves; the matrix of agreement has a line per formulation."""
    for block in pictures(sections):
        for ax in block.figure.axes:
            names = [label.get_text() for label in ax.get_yticklabels()]
            lines = [line for line in ax.lines if is_curve(line)]
            limit = MOST_ENGINES if block.name != "agreement-formulations" else len(FORMULATIONS)
            assert len(lines) <= limit + 1, block.name
            assert sum("engine" in name for name in names) <= limit, block.name


def test_agreement_is_between_the_best_of_each_formulation(sections):
    section = sections["agreement-formulations"]
    frame = section.blocks[0].frame

    assert len({*frame["first"], *frame["second"]}) == len(FORMULATIONS) - 1
    assert "most surely right" in section.text


def test_every_solver_stays_in_the_tables(sections):
    summary = sections["summary"].blocks[0].frame

    assert len(summary) == len(ENGINES) + 5 * (len(FORMULATIONS) - 2)
    tables = {b.name: b.frame for s in sections.values() for b in s.blocks if hasattr(b, "frame")}
    for name in ("times", "gap-quantiles"):
        assert len(tables[name]) == len(summary)
        assert len(tables[f"{name}-best"]) == len(FORMULATIONS) - 1
        assert set(tables[f"{name}-best"]["solver"]) < set(tables[name]["solver"])


@pytest.mark.slow
def test_long_tables_scroll_inside_their_frame(folder, tmp_path):
    """Only long ones, and the page says so for those who do not see a scroll bar."""
    page = render([folder], tmp_path / "out").read_text(encoding="utf-8")
    tables = re.findall(r'<figure class="table" id="table-([^"]+)">(.*?)</figure>', page, re.DOTALL)

    for name, text in tables:
        lines = text.count("<tr>") - 1
        assert ('class="scroll tall"' in text) == (lines > 20), name
        assert ("scroll inside the table" in text) == (lines > 20), name


@pytest.mark.slow
@pytest.mark.parametrize("formulation", ["closed form", None, "x" * 3000 + "\n<b>", "$\\frac"])
def test_many_methods_of_one_strange_formulation_are_drawn(formulation, results):
    """No formulation of our own, or none that an engine solves; names as long as they like."""
    engine = "e" * 3000 + "\n\u202e$"
    strange = [
        attempt(
            scenario, f"s{n}", formulation=formulation, engine=f"{engine}{n}", scenario_id=str(k)
        )
        for n in range(16)
        for k, scenario in enumerate(SCENARIOS)
    ]
    loaded = load([results("strange", strange)])
    with drawing():
        drawn = pictures({s.key: s for topic in TOPICS for s in sections_of(topic, loaded)})
        files = [figure_bytes(block.figure, "svg") for block in drawn]

    assert {"verdicts", "times", "gap-profile-strange"} <= {block.name for block in drawn}
    assert all(files)
    for block in drawn:
        assert block.figure.get_size_inches()[1] < 7, block.name
