"""The report as a whole.

It is complete, self-contained, escaped, repeatable, and written whole or not at all.
"""

import re
from dataclasses import replace

import pandas as pd
import pytest

from dubins_study import render
from dubins_study.report.elements.columns import SOLVER, Column
from dubins_study.report.elements.content import Table
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.elements.style import INK, MUTED, PAPER, RULE, VARIABLES
from dubins_study.report.page.markup import to_csv, to_tex
from dubins_study.report.page.render import ReportError
from dubins_study.report.page.sections import TOPICS
from dubins_study.study.scenario import Scenario
from dubins_study.study.values import printable_text
from dubins_study.study.words import Claim
from tests.fuzz.page import check_report, odd_parts
from tests.unit.report.results_folder import astray, attempt, lost, paper_scenarios, write_folder
from tests.unit.report.topic_page import topic_page, with_pdf_files

HOSTILE = (
    "<script>alert('x')</script> & |a_b| $x^2$ \\input{y} `c` [l](u) #%~{}\x1b[31m\x07\x9b\u202e"
)


def paper_rows():
    """Rows of every test problem and branch.

    They come from the closed form and from a solver that always misses.
    """
    rows = []
    for scenario in paper_scenarios():
        for branch in ("best", "LS", "RS"):
            rows.append(attempt(scenario, branch=branch))
            wrong = attempt(scenario, "ipopt", branch, path=astray(scenario), claim=Claim.LOCAL)
            rows.append(wrong)
    return rows


def sweep_rows():
    """Problem 5 through its crossing, cold and warm."""
    rows = []
    for radius in (20.0, 40.0, 55.0, 60.0, 80.0):
        scenario = Scenario(0, 0, 2.0943951023931953, -80, 20, radius, label="problem 5")
        rows += [
            attempt(scenario),
            attempt(scenario, "slsqp"),
            attempt(scenario, "slsqp", initial_guess="warm"),
        ]
    return rows


def plane_rows():
    """Two coarse planes of two solvers.

    The closed form's is coarse, the other solver's coarser.
    """
    places = [-1.9 + 0.4 * i for i in range(10)]
    grid = [Scenario(0, 0, 0, x, y, 1) for x in places for y in places]
    return [attempt(s) for s in grid] + [attempt(s, "slsqp", path=None) for s in grid[::3]]


def convergence_rows():
    """Three numbers of steps, two engines, made-up gaps."""
    scenario = paper_scenarios()[0]
    return [
        attempt(scenario, f"turn-rate-qp[n={n},engine={engine}]", gap=1.0 / n**2, wall_s=n / 1e4)
        for n in (10, 20, 40)
        for engine in ("osqp", "highs")
    ]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A report with every section in it."""
    base = tmp_path_factory.mktemp("whole")
    made = {
        "paper": paper_rows(),
        "radius-sweep": sweep_rows(),
        "plane": plane_rows(),
        "convergence": convergence_rows(),
    }
    folders = [write_folder(base / name, name, rows) for name, rows in made.items()]
    with with_pdf_files():
        return render(folders, out=base / "report")


FRONT = ["explorer", "decision", "convergence", "plane"]
DETAILS = [
    *("caution", "summary", "success", "time", "radius", "warm"),
    *("failures", "attempts", "solvers", "limits"),
]


def test_every_section_is_in_its_place(whole):
    """Every section is in its place.

    There are rows for all of them. They are open or folded, and the contents link to each.
    """
    page, paper = (whole.with_name(name).read_text() for name in ("index.html", "paper.html"))
    keys = re.findall(r'<section id="([^"]+)"', page)
    folded = re.findall(r'<section id="([^"]+)">\s*<details class="part">', page)

    assert keys == [*FRONT, *DETAILS, "provenance", "glossary"]
    assert folded == [*DETAILS, "provenance", "glossary"]
    for key in keys:
        assert f'href="#{key}"' in page
    assert re.findall(r'<section id="([^"]+)"', paper) == [
        *("paper", "audit", "paths", "provenance", "glossary"),
    ]
    assert 'href="paper.html"' in page
    assert 'href="index.html"' in paper


def test_the_page_begins_with_the_problem(whole):
    """The page begins with the problem.

    The picture and the explorer stand above the first figure or table about engines.
    """
    page = whole.read_text(encoding="utf-8")
    figures = re.findall(r'<figure class="\w+" id="([^"]+)"', page)

    assert figures[:2] == ["widget-problem", "widget-explorer"]
    assert figures[2] == "table-decision"


def test_every_section_says_first_what_to_see(whole):
    page = whole.read_text(encoding="utf-8")
    sections = re.findall(r'<section id="([^"]+)".*?</section>', page, re.DOTALL)
    opened = re.sub("</?(details|summary)[^>]*>", "", page)
    leads = re.findall(r'<section id="([^"]+)"[^>]*>\s*<h2>.*?</h2>\s*<p class="see">[A-Z]', opened)

    assert leads == sections


def test_figures_fit_a_column_and_a_screen(whole):
    """Figures fit a column and a screen.

    Each is as wide as a column of a journal or two, 88 or 180 mm, and at most 7 inches high.

    Letters are TrueType with all of Unicode, which journals ask for.
    """
    for file in sorted((whole.parent / "figures").glob("*.pdf")):
        content = file.read_bytes()
        assert b"/Type3" not in content, file.name
        assert b"/CIDFontType2" in content, file.name
        box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", content)
        assert box is not None
        width, height = (float(size) / 72 for size in box.groups())
        # the file gives sizes with as many digits as a float; a tenth of a point is invisible
        assert min(abs(width * 25.4 - mm) for mm in (88, 180)) < 0.05, file.name
        assert height <= 7, file.name


def test_the_page_asks_for_nothing(whole):
    page = whole.read_text(encoding="utf-8")

    assert odd_parts(page) == []
    assert "@import" not in page
    assert not re.search(r"url\((?!#)", page)


def test_every_figure_has_words_for_those_who_cannot_see_it_and_follows_the_page(whole):
    """Every figure has a text and follows the page.

    The text is for those who cannot see it. Its ink, its paper and all hues, of lines and of
    hatches, are the page's variables.
    """
    page = whole.read_text(encoding="utf-8")
    figures = re.findall(r"<svg role='img' aria-label='.*?</svg>", page, re.DOTALL)

    assert page.count("<svg") == len(figures) >= 9
    for figure in figures:
        drawn = re.sub(r">[^<]+<", "><", figure)
        assert not {c for c in (INK, MUTED, RULE, PAPER, *VARIABLES) if c in drawn}
        assert "var(--" in drawn
        assert "<metadata" not in drawn


@pytest.mark.slow
def test_the_same_rows_give_the_same_bytes(results, tmp_path):
    """The same rows give the same bytes.

    There are no dates and no random ids: a report can be compared with the committed one.
    """
    folder = results("paper", paper_rows())
    with with_pdf_files():
        pages = [render([folder], out=tmp_path / name).parent for name in ("one", "two")]
    files = sorted(file.relative_to(pages[0]) for file in pages[0].rglob("*") if file.is_file())

    assert len(files) > 20
    for file in files:
        assert (pages[0] / file).read_bytes() == (pages[1] / file).read_bytes(), file


@pytest.mark.slow
def test_hostile_names_are_shown_as_they_are(results, tmp_path):
    """Hostile names are shown as text.

    Labels, messages, solvers and manifest are text, in HTML, SVG and TeX.

    Control characters are written out; so are halves of pairs, which no file can hold.
    """
    scenario = Scenario(0, 0, 0, 5, 5, 1, label=HOSTILE)
    rows = [
        attempt(scenario, HOSTILE, path=None, claim=Claim.FAILED, message=HOSTILE),
        *[attempt(Scenario(0, 0, 0, 5, 5, r, label=HOSTILE), HOSTILE) for r in (2.0, 3.0, 9.0)],
    ]
    text = HOSTILE + "\ud800"
    experiment = {"name": "radius-sweep", "title": text, "question": text, "text": text}
    hostile = {"command": text, "machine": {text: [text]}, "git": {"branch": text}}
    fields = ("run_id", "started", "state", "engine", "governor")
    hostile["runs"] = [dict.fromkeys(fields, text) | {"machine": {"processor": text}}]
    out = tmp_path / "out"

    render([results("radius-sweep", rows, experiment=experiment, **hostile)], out)

    check_report(out)
    page = (out / "index.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert '<td class="solver"><span title="&lt;script&gt;' in page
    assert "\\x1b" in page
    for svg in (out / "figures").glob("*.svg"):
        assert "mathdefault" not in svg.read_text(encoding="utf-8")
    assert printable_text("a\n\tπ ≤ 2\ud800") == "a\n\tπ ≤ 2\\ud800"


def test_table_in_both_formats():
    """A table comes in both formats.

    CSV keeps raw values; TeX shows the formatted ones, and solvers by their short names.
    """
    frame = pd.DataFrame({"s": ["x_1"], "v": [0.123456], "w": [None], "u": ["[1]"]})
    columns = (SOLVER, Column("v", "v", digits(3)), Column("w", "v"), Column("u", "a & b"))
    table = Table("t", "", frame.rename(columns={"s": "solver"}), columns, labels={"x_1": "Y_1"})

    assert to_csv(table) == "solver,v,w,u\nx_1,0.123456,,[1]\n"
    assert "solver & v & v & a \\& b \\\\\n" in to_tex(table)
    assert "Y\\_1 & 0.123 & – & {[}1] \\\\\n" in to_tex(table)


@pytest.mark.parametrize(
    ("show", "value", "text"),
    [
        (digits(3), 15930.0, "15\u202f930"),
        (digits(3), 999.6, "1\u202f000"),
        (digits(3), -1152, "−1\u202f152"),
        (digits(6), 1152.0, "1152.00"),
        (digits(3), 999, "999"),
        (digits(3), 2e6, "2.00e6"),
        (digits(1), 1e-5, "1e−5"),
        (digits(1), 0.05, "0.05"),
        (digits(3), 0.0012345, "0.00123"),
        (digits(3), 1.2345e-7, "1.23e−7"),
        (digits(3), 0.99999, "1.00"),
        (digits(3), -2.5, "−2.50"),
        (digits(3), float("inf"), "∞"),
        (share, 1.0, "100 %"),
        (share, 0.9999, ">99.9 %"),
        (share, 0.0001, "<0.1 %"),
        (count, 12345, "12\u202f345"),
        (seconds, 0.0123, "12.3 ms"),
        (seconds, 2.5e-7, "250 ns"),
    ],
)
def test_numbers_as_they_are_shown(show, value, text):
    """Numbers are shown briefly.

    They have few digits, are not rounded up to certainty, and have thin spaces between thousands.
    """
    assert show(value) == text


def _same_place(target_x, target_y):
    return [Scenario(0, 0, 0, target_x, target_y, radius, label="p") for radius in (1, 2, 3, 4)]


ODD = {
    "all-lost": [lost(s, outcome="unavailable") for s in paper_scenarios()],
    # answers to some, and of the others one that is not judged and two whose solver was not asked
    "routes": [
        *(attempt(s) for s in paper_scenarios()),
        *(
            lost(replace(s, **route), scenario_id=f"{number}", outcome=outcome)
            for number, s in enumerate(paper_scenarios()[:2])
            for route, outcome in (
                ({"via": [(7, 8), (9, -1)], "final_heading": 1}, "unsupported"),
                ({"final_heading": "270deg", "label": "pose"}, "unsupported"),
                ({"via": [(7, 8)]}, "raised"),
            )
        ),
    ],
    "failures": [
        attempt(s, solver, path=astray(s), claim=Claim.FAILED)
        for s in paper_scenarios()
        for solver in ("slsqp", "ipopt")
    ],
    "one-lost": [attempt(paper_scenarios()[0]), lost(paper_scenarios()[0])],
    "paper": [attempt(s, branch="LS") for s in paper_scenarios()],
    "ahead": [attempt(s) for s in _same_place(5, 0)],
    "behind": [attempt(s) for s in _same_place(-5, 0)],
    "at-the-start": [attempt(s) for s in _same_place(0, 0)],
    "warm-only": [attempt(s, initial_guess="warm") for s in paper_scenarios()],
    **{
        study: [lost(s, solver, initial_guess=guess) for s in paper_scenarios()]
        for study, solver, guess in (
            ("basins", "slsqp[model=joint,order=LRS,initial_guess=given]", "0.0 0.0 5.0"),
            ("convergence", "turn-rate-qp[n=10]", "cold"),
        )
    },
    "many": [attempt(s, f"s{i}[a={i}]") for s in paper_scenarios()[:2] for i in range(9)],
}


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "name",
    ["all-lost", "routes", *(pytest.param(name, marks=pytest.mark.slow) for name in [*ODD][2:])],
)
def test_odd_results_make_a_report_too(results, tmp_path, name):
    """Odd results make a report too.

    Nothing came back, nothing to compare with, no circle to cross, or no length at all.
    """
    page = render([results(name, ODD[name])], tmp_path / "out")

    assert '<section id="summary"' in page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_an_unfinished_run_says_so(results, tmp_path):
    """An unfinished run says so.

    Its numbers are of some cells only, which may be the easy ones.
    """
    done = results("tiny", [attempt(paper_scenarios()[0])])
    part = results("part", [attempt(paper_scenarios()[0])], finished=None)

    assert "Not finished" not in render([done], tmp_path / "a").read_text(encoding="utf-8")
    page = render([part], tmp_path / "b")
    assert "Not finished" in page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_progress_is_told(results, tmp_path):
    told: list[str] = []
    render([results("tiny", [attempt(paper_scenarios()[0])])], tmp_path / "out", told.append)

    assert told == [topic.title for topic in TOPICS]


def test_a_place_that_cannot_be_written_is_refused(results, tmp_path):
    folder = results("tiny", [attempt(paper_scenarios()[0])])
    cases = {"file": "file", "file/below": "file", "full": "full/a.txt", "site": "site/index.html"}
    for out, kept in cases.items():
        (tmp_path / kept).parent.mkdir(exist_ok=True)
        (tmp_path / kept).write_text("mine")
        with pytest.raises(ReportError, match=out.split("/")[0]):
            topic_page(folder, tmp_path / out, "summary")
        assert (tmp_path / kept).read_text() == "mine"


def test_nothing_half_written_is_left(results, tmp_path, monkeypatch):
    """Nothing half-written is left.

    A report that fails while it is written leaves the old one as it was.
    """
    folder = results("tiny", [attempt(paper_scenarios()[0])])
    page = topic_page(folder, tmp_path / "out", "summary")
    before = page.read_bytes()

    def full(*_: object) -> str:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("dubins_study.report.page.render.to_tex", full)
    with pytest.raises(ReportError, match="No space left"):
        topic_page(folder, tmp_path / "out", "summary")

    assert page.read_bytes() == before
    assert {p.name for p in tmp_path.iterdir()} == {"tiny", "out"}
