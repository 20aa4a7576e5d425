"""Which section of the page an experiment has: the key in its TOML file decides, not its name."""

from __future__ import annotations

import re

import pytest

from dubins_study.experiments.definition.experiment import packaged, parse, read
from dubins_study.report.data.results import load
from dubins_study.report.page.sections import KEYS, TOPICS, sections_of
from tests.unit.report.results_folder import attempt, paper_scenarios
from tests.unit.report.topic_page import topic_page

SPEC = "slsqp[model=joint,order=LRS,initial_guess=given,capped=false]"

# one that an experiment asks for, and two that it need not
SECTIONS = ("where initial guesses lead", "summary", "success and gaps")


def folder(results, name, section):
    """Results of an experiment that names a section: two attempts from given initial guesses."""
    guesses = [attempt(paper_scenarios()[2], SPEC, initial_guess=f"{z} 0 5") for z in (0, 1)]
    return results(name, guesses, section=section)


def section_ids(page):
    return re.findall(r'<section id="([^"]+)"', page.read_text(encoding="utf-8"))


def test_a_copy_under_another_name_keeps_its_section(results, tmp_path):
    """And one without the key has none; the general sections need no key."""
    copy = parse("copy", "copy.toml", read("basins").text).experiment
    bare = parse("bare", "bare.toml", re.sub("(?m)^section = .*$", "", read("basins").text))

    kept = topic_page(folder(results, "copy", copy.section), tmp_path / "kept", *SECTIONS)
    none = topic_page(
        folder(results, "bare", bare.experiment.section), tmp_path / "none", *SECTIONS
    )

    assert copy.section == "basins"
    assert bare.experiment.section is None
    assert "basins" in section_ids(kept)
    assert "basins" not in section_ids(none)
    assert {"summary", "success"} <= set(section_ids(none))


def test_every_packaged_key_has_a_section_and_every_section_an_experiment():
    """No packaged experiment asks for a section that is not there, and no topic is never asked."""
    keys = {read(name).experiment.section for name in packaged()} - {None}

    assert keys == set(KEYS)


def test_an_unknown_section_is_a_line_on_the_page(results, tmp_path):
    """The set of sections is the report's: a plug-in's experiment is reported without one."""
    page = topic_page(folder(results, "mine", "guesses"), tmp_path / "out", *SECTIONS)
    line = "No section of the report is called"

    assert line in page.read_text(encoding="utf-8")
    assert line in (page.parent / "report.md").read_text(encoding="utf-8")
    assert "summary" in section_ids(page)


@pytest.mark.slow
def test_two_experiments_of_one_topic_have_a_section_each(results, tmp_path):
    first, second = (folder(results, name, "basins") for name in ("one", "two"))
    page = topic_page([first, second], tmp_path / "out", *SECTIONS)

    assert [key for key in section_ids(page) if "basins" in key] == ["basins-one", "basins-two"]
    for name in ("one", "two"):
        assert (page.parent / "tables" / f"basins-{name}.csv").is_file()


@pytest.mark.slow
def test_a_study_enters_no_pooled_number(results):
    """Variants and extreme questions are not counted with other experiments' attempts."""
    folders = [
        results("tiny", [attempt(paper_scenarios()[0])]),
        folder(results, "study", "basins"),
    ]
    loaded = load(folders)
    sections = [section for topic in TOPICS for section in sections_of(topic, loaded)]
    summary = next(section for section in sections if section.key == "summary")
    table = summary.blocks[0].frame

    assert table["solver"].tolist() == ["analytic"]
    assert table["attempts"].tolist() == [1]
