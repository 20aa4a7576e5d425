"""All figures of a page of everything: what may be said of any of them."""

from __future__ import annotations

import re

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.elements.content import Picture, Table
from dubins_study.report.elements.figure_file import figure_bytes, fix_layout
from dubins_study.report.elements.names import common_part
from dubins_study.report.elements.style import RULE, drawing
from dubins_study.report.page.sections import TOPICS, sections_of
from tests.unit.report import test_many_methods, test_page
from tests.unit.report.results_folder import write_folder

# The page's column is 984 pixels wide on a screen of 1280 by 900, half of it 478.
SCREEN = {False: 900 / 984, True: 900 / 478}
MOST_CURVES = 10
MOST_SVG_BYTES = 120_000


@pytest.fixture(scope="module")
def sections(tmp_path_factory):
    """Every section of a page of sixty-four methods, the paper, sweeps, a plane and meshes."""
    base = tmp_path_factory.mktemp("everything")
    rows = {
        "benchmark": test_many_methods.rows(),
        "paper": test_page.paper_rows(),
        "radius-sweep": test_page.sweep_rows(),
        "plane": test_page.plane_rows(),
        "discretisation": [
            row | {"formulation": "turn rates", "engine": row["solver"].split("=")[-1][:-1]}
            for row in test_page.discretisation_rows()
        ],
    }
    results = load([write_folder(base / name, name, each) for name, each in rows.items()])
    with drawing():
        return [section for topic in TOPICS for section in sections_of(topic, results)]


@pytest.fixture(scope="module")
def svg_files(sections):
    """Every figure with its SVG file, for which it has been laid out and drawn."""
    blocks = [b for s in sections for b in s.blocks if isinstance(b, Picture)]
    with drawing():
        for block in blocks:
            fix_layout(block.figure)
        return [(block, figure_bytes(block.figure, "svg")) for block in blocks]


@pytest.fixture(scope="module")
def pictures(svg_files):
    """Every figure by its name."""
    return {block.name: block for block, _ in svg_files}


def curves(ax):
    """The lines of a panel with a colour and many points: not grey ones."""
    lines = [line for line in ax.lines if len(line.get_xdata()) > 2]
    return [line for line in lines if line.get_color() != RULE and line.get_linestyle() != "None"]


def test_the_page_has_figures_of_many_topics(pictures):
    assert {"matrix", "comparison-profiles", "belief-claims", "verdicts"} <= set(pictures)
    assert {"comparison-targets", "work-precision"} <= set(pictures)
    assert len(pictures) > 15


def test_no_figure_is_taller_than_a_screen(pictures):
    for name, block in pictures.items():
        width, height = block.figure.get_size_inches()
        assert height / width <= SCREEN[block.half], name


def test_no_panel_has_more_than_ten_curves(pictures):
    """With a colour; the others are grey, without names."""
    for name, block in pictures.items():
        for ax in block.figure.axes:
            assert len(curves(ax)) <= MOST_CURVES, name


def test_no_legend_is_larger_than_its_plot(pictures):
    """Its box has less area than the panels together, and lies in the figure."""
    for name, block in pictures.items():
        figure = block.figure
        boxes = [ax.get_window_extent() for ax in figure.axes if ax.get_visible()]
        plots = sum(box.width * box.height for box in boxes)
        legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes)]
        for legend in filter(None, legends):
            box = legend.get_window_extent()
            assert box.width * box.height < plots, name
            assert figure.bbox.padded(1).containsx(box.x1), name
            assert figure.bbox.padded(1).containsy(box.y0), name


def test_every_figure_says_what_its_axes_are(pictures):
    """A label at each axis or one for all; maps of named cells have names instead."""
    for name, block in pictures.items():
        figure = block.figure
        labels = [ax.get_xlabel() for ax in figure.axes] + [t.get_text() for t in figure.texts]
        cells = any(ax.images for ax in figure.axes)
        assert any(labels) or cells or figure.get_supxlabel(), name


def test_the_files_of_figures_are_small(svg_files):
    for block, svg in svg_files:
        assert len(svg) < MOST_SVG_BYTES, block.name


def test_every_caption_ends_and_every_lead_is_one_sentence(sections):
    for section in sections:
        for block in section.blocks:
            if isinstance(block, (Picture, Table)):
                assert block.caption.rstrip().endswith("."), block.name
        assert not section.lead or re.search(r"[.?!]$", section.lead), section.key


def test_what_all_names_of_a_panel_share_goes_to_its_title():
    """Only if nothing is lost: a method without a presolve keeps the others' names long."""
    shared = ["Ipopt, presolve", "SLSQP, presolve"]

    assert common_part(shared) == (" (presolve)", ["Ipopt", "SLSQP"])
    assert common_part(["HiGHS", *shared]) == ("", ["HiGHS", *shared])
    assert common_part(["SCIP", "Ipopt, bearing start"]) == (" (bearing start)", ["SCIP", "Ipopt"])
    assert common_part(["Ipopt, presolve"]) == ("", ["Ipopt, presolve"])
