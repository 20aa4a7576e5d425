"""README's table, the documentation's numbers, its notebooks and CITATION.cff."""

import json
import re
import tomllib
from importlib import import_module
from pathlib import Path

import duckdb
import pytest
import yaml

from dubins_study.report.data.results import load
from dubins_study.report.paper.printed import CITATION, TITLE
from dubins_study.report.topics.decision import decision_section

ROOT = Path(__file__).parents[2]
# Columns of the page's table that README shows.
SUITES = ("suite_0", "suite_1", "suite_2", "suite_3")
SHOWN = ("method", "knows", *SUITES, "false", "stops")


def table_lines() -> list[str]:
    """All lines of the page's table, as in README."""
    folders = [ROOT / "results" / "benchmark" / suite for suite in ("leg", "pose", "route")]
    frame = decision_section(load(folders)).blocks[0].frame
    texts = frame.reindex(columns=SHOWN).fillna("–").astype(str)
    for suite in SUITES:
        texts[suite] = texts[suite].str.replace(r"(.+)\n(.+)", r"`\1` \2", regex=True)
    cells = texts.map(lambda text: " ".join(text.replace("\n", " ").split()))
    return [f"| {' | '.join(line)} |" for line in cells.itertuples(index=False)]


@pytest.mark.slow
def test_the_table_is_that_of_the_committed_rows():
    """README's table has the committed rows' numbers.

    Run `python -m tests.docs.test_readme` to print the lines, of which README shows six.
    """
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = re.search(r"\| formulation.*?\n\n", text, re.S)[0].strip().split("\n")[2:]

    assert len(shown) == 6
    assert [line for line in shown if line not in table_lines()] == []


PARTS = ROOT / "results" / "benchmark" / "leg" / "parts" / "*.parquet"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch):
    """The module of `docs/ext` that writes the tables."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "ext"))
    return import_module("benchmark_numbers")


def right_of(spec: str) -> tuple[float, int]:
    """Share of right answers (%) and questions, by SQL.

    Only questions with a path are counted.
    """
    [(share, questions)] = duckdb.sql(
        f"""SELECT 100 * avg(right_share), count(*) FROM (
            SELECT avg((verdict = 'optimal' AND NOT presolved)::INT) AS right_share
            FROM '{PARTS}' WHERE solver = '{spec}' AND reference IS NOT NULL
            GROUP BY scenario_id, branch)"""
    ).fetchall()
    return share, questions


@pytest.mark.slow
@pytest.mark.parametrize(
    ("formulation", "engine", "spec"),
    [
        ("grid of headings", "HiGHS", "heading-milp"),
        ("disjunction", "SCIP", "disjunctive"),
        ("penalty", "differential evolution", "penalty"),
    ],
)
def test_a_share_is_that_of_the_rows(benchmark, formulation: str, engine: str, spec: str):
    """A share is that of the rows.

    A question that is right in two of three repeats counts 2/3, in both ways of counting.
    """
    line = re.search(rf"^\| {engine} .*$", benchmark.formulation(formulation), re.M)
    shown = re.search(r"([\d.]+) % of (\d+)", line[0])
    share, questions = right_of(spec)

    assert int(shown[2]) == questions
    assert float(shown[1]) == pytest.approx(share, abs=0.05)  # shown with one decimal


NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_stored_without_outputs_and_checks_what_its_text_says(notebook: Path):
    """Notebooks have no outputs and check their text.

    Outputs would be of some machine and some day; the site shows those of its build, which runs
    the checks.
    """
    text = notebook.read_text(encoding="utf-8")
    cells = json.loads(text)["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]

    assert code
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)
    assert all(not cell["metadata"] for cell in cells)
    assert "assert " in text


def test_both_notebooks_are_pages():
    """Both notebooks are pages.

    They lie in the tree of the site, by a link, and are named in its contents.
    """
    page = (ROOT / "docs" / "notebooks.md").read_text(encoding="utf-8")

    assert len(NOTEBOOKS) == 2
    assert all(f"notebooks/{notebook.stem}" in page for notebook in NOTEBOOKS)
    assert (ROOT / "docs" / "notebooks").resolve() == NOTEBOOKS[0].parent


@pytest.fixture(scope="module")
def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_the_file_agrees_with_the_package(citation):
    """Version, licence, authors and keywords are those of pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

    assert str(citation["version"]) == project["version"]
    assert citation["license"] == project["license"]
    assert citation["authors"] == project["authors"]
    assert set(citation["keywords"]) == set(project["keywords"])


def test_the_file_cites_the_paper_as_the_reports_do(citation):
    """The file cites the paper as the reports do.

    It has one title; no authors and no year, as long as the reports know none.
    """
    (paper,) = citation["references"]

    assert paper["title"] == TITLE
    assert TITLE in CITATION
    assert "year" not in paper
    assert [author["name"] for author in paper["authors"]] == ["authors unknown to this study"]


if __name__ == "__main__":
    print("\n".join(table_lines()))
