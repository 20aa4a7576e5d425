"""`report.tex` and the tables of a hostile report, as pdflatex and pdffonts see them."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from dubins_study import render
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, write_folder
from tests.unit.report.test_tex import HOSTILE


def needed(program: str) -> str:
    """The program; without it the test is skipped, except in CI."""
    found = shutil.which(program)
    if found is None and "CI" not in os.environ:
        pytest.skip(f"{program} is not installed")
    assert found is not None, f"{program} is not installed; expected it in CI"
    return found


def compiled(file: Path) -> str:
    """The log of pdflatex, which must succeed."""
    line = [needed("pdflatex"), "-interaction=nonstopmode", "-halt-on-error", file.name]
    done = subprocess.run(line, cwd=file.parent, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:].decode("latin-1")
    return file.with_suffix(".log").read_text(encoding="latin-1")


@pytest.fixture(scope="module")
def hostile_report(tmp_path_factory):
    """A report with hostile labels, solvers, messages and titles, and figures."""
    base = tmp_path_factory.mktemp("tex")
    spec = f"{HOSTILE}[{HOSTILE}]"
    rows = [
        attempt(Scenario(0, 0, 0, 5, 5, r, label=HOSTILE), name, message=HOSTILE)
        for r in (1.0, 2.0, 3.0, 9.0)
        for name in ("analytic", spec, "[1]")
    ]
    lost = Scenario(0, 0, 0, 5, 6, 1, label=HOSTILE)
    rows.append(attempt(lost, spec, path=None, claim=Claim.FAILED, message=HOSTILE))
    experiment = {"name": "x", "title": HOSTILE, "question": HOSTILE, "text": HOSTILE}
    extra = {"command": HOSTILE, "machine": {HOSTILE: HOSTILE}, "git": {"branch": HOSTILE}}
    folder = write_folder(base / "hostile", "x", rows, experiment=experiment, **extra)
    return render([folder], out=base / "report").parent


@pytest.mark.slow
def test_pdflatex_compiles_the_report(hostile_report):
    """Twice, as the file says: no error, no missing letter, no line that sticks out."""
    for _ in range(2):
        log = compiled(hostile_report / "report.tex")
    # pt; a hyphen or a comma in the margin is no harm, a column would be
    sticking_out = [float(pt) for pt in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]

    assert "Missing character" not in log
    assert "Undefined control sequence" not in log
    assert "undefined references" not in log
    assert max(sticking_out, default=0.0) < 5.0
    assert "Overfull \\vbox" not in log


@pytest.mark.slow
def test_a_table_needs_only_the_packages_that_it_names(hostile_report, tmp_path):
    """Each stands in a document of its own settings, with the packages of its first line."""
    tables = sorted((hostile_report / "tables").glob("*.tex"))
    lines = [table.read_text(encoding="utf-8").partition("\n")[0] for table in tables]
    packages = {line.removeprefix("% Needs the packages ").rstrip(".") for line in lines}
    for place, chosen in enumerate(sorted(packages)):
        own = [t for t, line in zip(tables, lines, strict=True) if line.endswith(f" {chosen}.")]
        inputs = "\n\n".join(rf"\input{{{table}}}" for table in own)
        text = rf"\documentclass{{article}}\usepackage{{{chosen}}}\begin{{document}}" + "\n"
        file = tmp_path / f"alone-{place}.tex"
        file.write_text(f"{text}{inputs}\n\\end{{document}}\n", encoding="utf-8")
        assert "Missing character" not in compiled(file)


@pytest.mark.slow
def test_no_font_of_a_figure_or_the_report_is_type_3(hostile_report):
    """Journals refuse bitmap and drawn letters; pdffonts sees what they see."""
    pdffonts = needed("pdffonts")
    figures = sorted((hostile_report / "figures").glob("*.pdf"))
    listed = [
        subprocess.run([pdffonts, str(file)], capture_output=True, check=True, text=True).stdout
        for file in figures
    ]

    assert listed
    assert not any("Type 3" in fonts for fonts in listed)
    assert any("TrueType" in fonts for fonts in listed)


@pytest.mark.slow
def test_a_compiled_report_is_replaced(hostile_report, tmp_path):
    """What pdflatex leaves beside report.tex does not keep the next report from its place."""
    folder = write_folder(tmp_path / "run", "x", [attempt(Scenario(0, 0, 0, 5, 5, 1))])
    for name in ("report.aux", "report.log", "report.pdf"):
        (hostile_report / name).write_text("")

    render([folder], out=hostile_report)

    assert not (hostile_report / "report.pdf").exists()
