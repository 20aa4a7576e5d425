"""All figures of two pages, and their tables.

One page has everything, the other sixty-four solvers.
"""

import re

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.layout_engine import ConstrainedLayoutEngine

from dubins_study.report.data.results import load
from dubins_study.report.elements.content import Picture, Table
from dubins_study.report.elements.looks import common_part
from dubins_study.report.elements.plots import Mark, stacked_shares
from dubins_study.report.elements.style import (
    INK,
    RULE,
    drawing,
    figure_bytes,
    fix_layout,
    new_figure,
)
from dubins_study.report.page.render import render
from dubins_study.report.page.sections import TOPICS, sections_of
from dubins_study.report.statistics.methods import MOST_ENGINES
from dubins_study.report.topics.cost import MARKS
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import FORMULATIONS, Claim
from tests.unit.report import test_page
from tests.unit.report.results_folder import astray, attempt, write_folder

# The page's column is 984 pixels wide on a screen of 1280 by 900, half of it 478.
SCREEN = {False: 900 / 984, True: 900 / 478}


ENGINES = [f"engine {n}" for n in range(14)]
SCENARIOS = [Scenario(0, 0, 0, x, y) for x, y in ((4, 1), (5, -2), (-3, 2))]


def many_methods():
    """Fourteen engines, and five on other formulations.

    The fourteen share one formulation. Most answers are right.
    """
    for place, formulation in enumerate(FORMULATIONS[1:]):
        for number, engine in enumerate(ENGINES if place == 0 else ENGINES[:5]):
            for n, scenario in enumerate(SCENARIOS):
                right = (number + n + place) % 5 > 0
                yield attempt(
                    scenario,
                    f"s{place}[engine={number},a_setting_with_a_long_name=1]",
                    path="exact" if right else astray(scenario),
                    claim=Claim.LOCAL if right else Claim.FAILED,
                    scenario_id=str(n),
                    formulation=formulation,
                    engine=engine,
                    wall_s=1e-3 * (1 + number),
                )


def drawn_of(sections):
    return [block for s in sections for block in s.blocks if isinstance(block, Picture)]


@pytest.fixture(scope="module")
def sections(tmp_path_factory):
    """Every section of a page of many methods.

    It has sixty-four methods, the paper, sweeps, a plane and meshes.
    """
    base = tmp_path_factory.mktemp("everything")
    rows = {
        "benchmark": many_methods(),
        "paper": test_page.paper_rows(),
        "radius-sweep": test_page.sweep_rows(),
        "plane": test_page.plane_rows(),
        "convergence": [
            row | {"formulation": "turn rates", "engine": row["solver"].split("=")[-1][:-1]}
            for row in test_page.convergence_rows()
        ],
    }
    results = load([write_folder(base / name, name, each) for name, each in rows.items()])
    with drawing():
        return [section for topic in TOPICS for section in sections_of(topic, results)]


@pytest.fixture(scope="module")
def pictures(sections):
    """Every figure by its name, laid out and drawn."""
    blocks = drawn_of(sections)
    with drawing():
        for block in blocks:
            fix_layout(block.figure)
            figure_bytes(block.figure, "svg")
            block.figure.set_dpi(200)  # at less, letters are as wide as whole pixels
    return {block.name: block for block in blocks}


def is_map(ax):
    """Whether a panel shows cells."""
    return bool(ax.images) or any(isinstance(part, QuadMesh) for part in ax.collections)


def curves(ax):
    """Coloured lines of a panel with many points.

    Grey lines and the closed form's are left out.
    """
    lines = [line for line in ax.lines if len(line.get_xdata()) > 2]
    lines = [line for line in lines if line.get_linestyle() != "None"]
    return [line for line in lines if line.get_color() not in (RULE, INK)]


@pytest.mark.slow
def test_the_page_has_figures_of_many_topics(pictures):
    assert {"matrix", "comparison-profiles", "belief-claims", "times"} <= set(pictures)
    assert "convergence-outside" in pictures
    assert len(pictures) > 15


@pytest.mark.slow
def test_every_figure_fits_a_screen_and_says_what_its_axes_are(pictures):
    """Every figure fits a screen with labelled axes.

    There is a label at each axis or one for all; maps of named cells have names instead.

    A legend has less area than the panels together, and lies in the figure.
    """
    for name, block in pictures.items():
        figure = block.figure
        width, height = figure.get_size_inches()
        assert height / width <= SCREEN[block.half], name
        labels = [ax.get_xlabel() for ax in figure.axes] + [t.get_text() for t in figure.texts]
        cells = any(map(is_map, figure.axes))
        assert any(labels) or cells or figure.get_supxlabel(), name
        boxes = [ax.get_window_extent() for ax in figure.axes if ax.get_visible()]
        plots = sum(box.width * box.height for box in boxes)
        legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes)]
        for legend in filter(None, legends):
            box = legend.get_window_extent()
            assert box.width * box.height < plots, name
            assert figure.bbox.padded(1).containsx(box.x1), name
            assert figure.bbox.padded(1).containsy(box.y0), name


def test_every_caption_ends_and_every_lead_is_one_sentence(sections):
    for section in sections:
        for block in section.blocks:
            if isinstance(block, (Picture, Table)):
                assert block.caption.rstrip().endswith("."), block.name
        assert not section.lead or re.search(r"[.?!]$", section.lead), section.key


def test_what_all_names_of_a_panel_share_goes_to_its_title():
    """Shared parts of names go to the title.

    They do so only if nothing is lost: a method without a presolve keeps the others' names long.
    """
    shared = ["Ipopt, presolve", "SLSQP, presolve"]

    assert common_part(shared) == (" (presolve)", ["Ipopt", "SLSQP"])
    assert common_part(["HiGHS", *shared]) == ("", ["HiGHS", *shared])
    assert common_part(["SCIP", "Ipopt, bearing start"]) == (" (bearing start)", ["SCIP", "Ipopt"])
    assert common_part(["Ipopt, presolve"]) == ("", ["Ipopt, presolve"])


def test_bars_of_all_columns_have_one_length():
    """Bars of all columns have one length.

    The names beside them may be long; names of 44 characters are whole, in fewer columns.
    """
    long, short = "Uno filterSQP, words start, options=default", "SCIP"
    for names, across in (((short, long, short), 3), ((long, long, long), 2)):
        table = pd.DataFrame({"formulation": [*"abc"], "short": names, "note": "38*", "right": 1.0})
        with drawing():
            figure = stacked_shares(table, [Mark("right", colour=INK)], "share")
            fix_layout(figure)
        lengths = [ax.get_window_extent().width for ax in figure.axes]
        texts = [label.get_text() for ax in figure.axes for label in ax.get_yticklabels()]
        assert (texts, len(figure.axes)) == ([*names], across)
        assert max(lengths) < 1.1 * min(lengths)  # the labels of the axes are not counted


@pytest.mark.filterwarnings("error:constrained_layout")
@pytest.mark.parametrize("narrow", [False, True])
def test_a_single_bar_has_room_beside_its_legend(narrow):
    """A single bar has room beside its legend.

    A page of one solver has such a bar.
    """
    table = pd.DataFrame({"formulation": ["turn rates"], "short": ["Ipopt"], "note": ["1 ms"]})
    for mark in MARKS:
        table[mark.key] = 1 / len(MARKS)
    with drawing():
        fix_layout(stacked_shares(table, MARKS, "share of the time", narrow=narrow))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Sixty-four solvers in a folder."""
    return write_folder(tmp_path_factory.mktemp("many") / "many", "many", many_methods())


@pytest.fixture(scope="module")
def of_many(folder):
    """Every section of their page, by its key."""
    results = load([folder])
    return {s.key: s for topic in TOPICS for s in sections_of(topic, results)}


def groups_of(ax):
    """Groups of a panel's names by formulation.

    A title stands between two groups.
    """
    labels = ax.get_yticklabels()
    ends = np.flatnonzero(np.diff(ax.get_yticks()) > 1) + 1
    return np.split([label.get_text() for label in labels], ends)


@pytest.mark.slow
def test_no_panel_has_more_than_ten_methods(pictures, of_many):
    """No panel has more than ten methods.

    That holds for bars with names and for curves; maps alone have a line per engine.
    """
    for block in (*pictures.values(), *drawn_of(of_many.values())):
        for ax in block.figure.axes:
            assert len(curves(ax)) <= MOST_ENGINES, block.name
            named = max(map(len, groups_of(ax)))
            assert named <= MOST_ENGINES or is_map(ax), block.name


@pytest.mark.slow
def test_every_solver_stays_in_the_tables(of_many):
    summary = of_many["summary"].blocks[0].frame

    assert len(summary) == len(ENGINES) + 5 * (len(FORMULATIONS) - 2)
    tables = {b.name: b.frame for s in of_many.values() for b in s.blocks if hasattr(b, "frame")}
    assert len(tables["times"]) == len(summary)


@pytest.mark.slow
def test_long_tables_scroll_inside_their_frame(folder, tmp_path):
    """Long tables scroll inside their frame.

    Only long ones do, and the page says so for those who do not see a scroll bar.
    """
    page = render([folder], tmp_path / "out").read_text(encoding="utf-8")
    tables = re.findall(r'<figure class="table" id="table-([^"]+)">(.*?)</figure>', page, re.DOTALL)

    for name, text in tables:
        lines = text.count("<tr>") - 1
        assert ('class="scroll tall"' in text) == (lines > 20), name
        assert ("scroll inside the table" in text) == (lines > 20), name


@pytest.mark.slow
@pytest.mark.parametrize("formulation", ["closed form", None, "x" * 3000 + "\n<b>", "$\\frac"])
def test_many_methods_of_one_strange_formulation_are_drawn(formulation, load_rows):
    """Many methods of a strange formulation are drawn.

    It is no formulation of ours, or none that an engine solves; names are as long as they like.
    """
    engine = "e" * 3000 + "\n\u202e$"
    strange = [
        attempt(
            scenario, f"s{n}", formulation=formulation, engine=f"{engine}{n}", scenario_id=str(k)
        )
        for n in range(16)
        for k, scenario in enumerate(SCENARIOS)
    ]
    loaded = load_rows("strange", strange)
    with drawing():
        figure_blocks = drawn_of(s for topic in TOPICS for s in sections_of(topic, loaded))
        files = [figure_bytes(block.figure, "svg") for block in figure_blocks]

    assert {"times", "gap-profile-strange"} <= {block.name for block in figure_blocks}
    assert all(files)
    for block in figure_blocks:
        assert block.figure.get_size_inches()[1] < 7, block.name


def test_a_file_does_not_depend_on_the_last_digits_of_the_layout(monkeypatch):
    """A file never depends on the layout's last digits.

    Files are the same in every run; the layout's solver sorts by addresses in memory.
    """
    layout = ConstrainedLayoutEngine.execute

    def rounded_otherwise(engine, figure):
        layout(engine, figure)
        for ax in figure.axes:
            left, bottom, width, height = ax.get_position().bounds
            ax.set_position((left, bottom, width * (1 + 1e-15), height))

    files = []
    for execute in (layout, rounded_otherwise):
        monkeypatch.setattr(ConstrainedLayoutEngine, "execute", execute)
        with drawing():
            figure = new_figure(4, 3)
            for ax in figure.subplots(1, 3):
                ax.barh([0, 1], [2, 3])
            fix_layout(figure)
            files.append(figure_bytes(figure, "svg"))

    assert files[0] == files[1]
