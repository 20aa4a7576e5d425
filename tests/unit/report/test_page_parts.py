"""Parts of the page.

They are glossary, dictionaries, sections of experiments, and the explorer's HTML. The key in an
experiment's TOML file decides on its section, not its name.
"""

import base64
import html
import math
import re
from io import StringIO
from pathlib import Path as FilePath
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

from dubins_study import render
from dubins_study.experiments.definition.experiment import packaged, parse, read
from dubins_study.report.data.results import load
from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.content import Table
from dubins_study.report.page.environment import TEMPLATES
from dubins_study.report.page.explorer import explorer_section, write_explorer
from dubins_study.report.page.glossary import WORDS, Glossed
from dubins_study.report.page.markup import inline
from dubins_study.report.page.sections import KEYS, TOPICS, sections_of
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path as Driven
from dubins_study.study.rows.parts import ResultsError
from dubins_study.study.rows.schema import ROW
from dubins_study.study.scenario import Pose, Scenario
from tests.fuzz.page import odd_parts
from tests.unit.report.results_folder import attempt, paper_scenarios
from tests.unit.report.topic_page import topic_page


def test_hatches_of_a_figure_follow_the_page_and_its_texts_stay():
    """Hatches of a figure follow the page.

    Its texts stay. The colour of a hatch is an attribute; only a style can hold a variable.
    """
    svg = '<svg><rect fill="#0072b2"/><text>&lt;b&gt; id="x" #1a1c1f</text></svg>'
    element = inline(svg, "times", "a <figure>")

    assert ElementTree.fromstring(element).attrib["aria-label"] == "a <figure>"
    assert '<rect style="fill: var(--blue)"/>' in element
    assert '<text>&lt;b&gt; id="x" #1a1c1f</text>' in element


def test_the_first_use_of_a_word_is_a_link():
    """The first use of a word is a link.

    It is one once on a page, with its meaning; what is from outside stays text.
    """
    glossed = Glossed()
    first = glossed("The gap of <b>an engine</b>, and another gap.")
    second = glossed("A gap.")

    assert first.count('href="#term-gap"') == first.count('href="#term-engine"') == 1
    assert "&lt;b&gt;" in first
    assert second == "A gap."
    assert len({word.anchor for word in WORDS}) == len(WORDS)


def test_the_number_behind_a_cell_is_the_raw_one():
    """The number behind a cell is raw.

    For a text with an interval it is the number that the text begins with; a text without a number
    has none.
    """
    frame = pd.DataFrame(
        {"v": [0.5, None], "flag": [True, False], "name": ["a", "b"]}
        | {"w_text": ["50 %", "–"], "w_share": [0.5, np.nan], "x_text": ["1", "2"], "x": [1, 2]}
    )
    shown = [Column(key, key) for key in ("v", "flag", "name", "w_text", "x_text")]

    assert Table("t", "", frame, tuple(shown)).values() == [
        [0.5, 1.0, None, 0.5, 1.0],
        [None, 0.0, None, None, 2.0],
    ]


@pytest.mark.slow
def test_dictionaries_name_every_column(results, tmp_path):
    """Dictionaries name every column.

    They are the columns of the rows, and of every table's CSV file.
    """
    folder = results("paper", [attempt(s) for s in paper_scenarios()])
    tables = render([folder], tmp_path / "out").parent / "tables"
    rows = pd.read_csv(tables / "columns.csv", keep_default_na=False)
    known = pd.read_csv(tables / "dictionary.csv", keep_default_na=False)

    assert rows["name"].tolist() == [column.name for column in ROW]
    for file in tables.glob("*.csv"):
        if file.stem != "dictionary":
            header = pd.read_csv(StringIO(file.read_text(encoding="utf-8")), nrows=0)
            named = known.loc[known["file"] == file.stem, "column"].tolist()
            assert named == header.columns.tolist(), file


def _text(page: FilePath) -> str:
    return page.read_text(encoding="utf-8")


def test_an_empty_run_makes_a_page_that_says_so(results, tmp_path):
    """An empty run makes a page that says so.

    It has no part, or one without rows, alone or beside a run with rows; what is no run is
    refused.
    """
    rows = [attempt(s) for s in paper_scenarios()]
    bare, none, full = results("bare", rows), results("none", []), results("paper", rows)
    (bare / "parts" / "1.parquet").unlink()

    page = render([bare, none], tmp_path / "a")
    both = topic_page([bare, full], tmp_path / "b", "summary")

    assert "There is nothing to report yet." in _text(page)
    assert _text(page).count("It has no rows") == 2
    assert (page.parent / "tables" / "columns.csv").exists()
    assert 'id="summary"' in _text(both)
    assert _text(both).count("It has no rows") == 1
    for folders, message in (([none, tmp_path / "nowhere"], "not a folder"), ([], "at least one")):
        with pytest.raises(ResultsError, match=message):
            render(folders, tmp_path / "out")


SPEC = "slsqp[model=joint,order=LRS,initial_guess=given,capped=false]"

# one that an experiment asks for, and two that it need not
SECTIONS = ("where initial guesses lead", "summary", "success and gaps")


def folder(results, name, section):
    """Results of an experiment that names a section.

    There are two attempts from given initial guesses.
    """
    guesses = [attempt(paper_scenarios()[2], SPEC, initial_guess=f"{z} 0 5") for z in (0, 1)]
    return results(name, guesses, section=section)


def section_ids(page):
    return re.findall(r'<section id="([^"]+)"', page.read_text(encoding="utf-8"))


def test_a_copy_under_another_name_keeps_its_section(results, tmp_path):
    """A renamed copy keeps its section.

    One without the key has none; the general sections need no key.
    """
    copy = parse("copy", "copy.toml", read("basins").text).experiment
    bare = parse("bare", "bare.toml", re.sub("(?m)^section = .*$", "", read("basins").text))

    page = topic_page(folder(results, "copy", copy.section), tmp_path / "kept", *SECTIONS)
    none = topic_page(
        folder(results, "bare", bare.experiment.section), tmp_path / "none", *SECTIONS
    )

    assert copy.section == "basins"
    assert bare.experiment.section is None
    assert "basins" in section_ids(page)
    assert "basins" not in section_ids(none)
    assert {"summary", "success"} <= set(section_ids(none))


def test_every_packaged_key_has_a_section_and_every_section_an_experiment():
    """Sections and packaged experiments belong together.

    No packaged experiment asks for a section that is not there, and no topic is never asked.
    """
    keys = {read(name).experiment.section for name in packaged()} - {None}

    assert keys == set(KEYS)


def test_an_unknown_section_is_a_line_on_the_page(results, tmp_path):
    """An unknown section is a line on the page.

    The set of sections is the report's: a plug-in's experiment is reported without one.
    """
    page = topic_page(folder(results, "mine", "guesses"), tmp_path / "out", *SECTIONS)
    line = "which the report does not have"

    assert line in page.read_text(encoding="utf-8")
    assert "summary" in section_ids(page)


@pytest.mark.slow
def test_two_experiments_of_one_topic_have_a_section_each(results, tmp_path):
    first, second = (folder(results, name, "basins") for name in ("one", "two"))
    page = topic_page([first, second], tmp_path / "out", *SECTIONS)

    assert [key for key in section_ids(page) if "basins" in key] == ["basins-one", "basins-two"]
    for name in ("one", "two"):
        assert [*(page.parent / "figures").glob(f"basins-1-*-{name}.svg")]


@pytest.mark.slow
def test_a_study_enters_no_pooled_number(results):
    """A study enters no pooled number.

    Variants and extreme questions are not counted with other experiments' attempts.
    """
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


ROOT = FilePath(__file__).parents[3]
NUMBER = re.compile(r"-?\d+\.?\d*")


@pytest.fixture
def explorer():
    """The explorer as the report shows it."""
    section = explorer_section(None)  # type: ignore[arg-type]  # the same for all results
    return section.blocks[-1].body


def test_without_scripts_there_are_two_drawings_with_a_text():
    """Without scripts there are two drawings with text.

    They are embedded as images, so that their styles and ids stay their own.
    """
    section = explorer_section(None)  # type: ignore[arg-type]
    bodies = "".join(widget.body for widget in section.blocks)
    images = [
        dict(re.findall(r'([\w-]+)="([^"]*)"', tag)) for tag in re.findall("<img [^>]*>", bodies)
    ]

    assert len(images) == 2
    for image in images:
        kind, _, content = image["src"].partition(",")
        assert kind == "data:image/svg+xml;base64"
        root = ElementTree.fromstring(base64.b64decode(content))
        assert html.unescape(image["alt"]) == root.get("aria-label")
        assert (image["width"], image["height"]) == (root.get("width"), root.get("height"))


def test_the_page_of_its_own_asks_for_nothing(tmp_path, explorer):
    text = write_explorer(tmp_path / "explorer.html").read_text(encoding="utf-8")

    assert explorer in text
    assert odd_parts(text) == []
    assert "@import" not in text
    assert len(text) < 140_000  # of which the map 110 000, routes the rest


PROBLEM = Scenario(0, 0, "70deg", 3.7, -0.15, 1)
BESIDE = [Scenario(0, 0, 0, r * math.sin(0.9), 1 - r * math.cos(0.9)) for r in (0.95, 1.05)]
BEHIND = Driven(Pose(0, 0, 0), [1.0, 0.0], [4.0, 3.4]).end


@pytest.mark.parametrize(
    ("drawing", "scenario", "branch", "text"),
    [
        (TEMPLATES / "problem.svg", PROBLEM, "RS", "right, then straight: {:.2f} R, shortest<"),
        (TEMPLATES / "problem.svg", PROBLEM, "LS", "left, then straight: {:.2f} R<"),
        (ROOT / "docs/img/jump.svg", BESIDE[0], "RL", "just inside: RL, {:.2f} R<"),
        (ROOT / "docs/img/jump.svg", BESIDE[1], "LS", "just outside: LS, {:.2f} R<"),
        (ROOT / "docs/img/cut.svg", Scenario(0, 0, 0, *BEHIND[:2]), "LS", "LS: {:.2f} R<"),
        (ROOT / "docs/img/cut.svg", Scenario(0, 0, 0, *BEHIND[:2]), "RS", "RS: {:.2f} R<"),
    ],
)
def test_a_length_in_a_drawing_is_the_closed_form_s(drawing, scenario, branch, text):
    optimum = shortest(scenario, branch)

    assert optimum is not None
    assert text.format(optimum.total) in drawing.read_text(encoding="utf-8")


def test_the_map_shows_an_example_of_each_word():
    """The map shows an example of each word.

    The targets' dots lie where their paths end and in the region of their word.
    """
    root = ElementTree.parse(TEMPLATES / "words.svg").getroot()
    thin = [e for e in root if e.tag.endswith("path") and "thin" in e.get("class", "")]
    dots = [e for e in root if e.get("class") == "target"]

    assert len(thin) == len(dots) == 4
    words = set()
    for path, dot in zip(thin, dots, strict=True):
        x, y = (float(dot.get(name, "nan")) for name in ("cx", "cy"))
        end = list(map(float, NUMBER.findall(path.get("d", ""))))[-2:]
        assert end == pytest.approx([x, y], abs=0.02)
        best = shortest(Scenario(target_x=x / 100 - 3.6, target_y=2.45 - y / 100))
        assert best is not None
        words.add(best.word)
        assert path.get("class", "").startswith("left" if best.word[0] == "L" else "right")
    assert words == {"LS", "RS", "RL", "LR"}
