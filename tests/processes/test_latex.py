"""A hostile report in LuaLaTeX and pdffonts.

Its tables and figures are read.
"""

import os
import shutil
import subprocess

import pytest

from dubins_study import render
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, write_folder

# What TeX obeys, letters of other alphabets, and a mark that turns the direction of writing.
HOSTILE = (
    '\\input{/etc/passwd} $x^2$ a_b & 50% #1 ~^ `q\' "d" --x ,, {un}balanced} \u202eltr\u202c '
    "\u6f22 \u0645 \U0001f600 ñ Ł ζ₁ ≤ 10⁻⁹ α\u0302 line\nbreak [n=50,engine=x]"
)


def needed(program: str) -> str:
    """The program, or a skipped test.

    In CI the test is not skipped.
    """
    found = shutil.which(program)
    if found is None and "CI" not in os.environ:
        pytest.skip(f"{program} is not installed")
    assert found is not None, f"{program} is not installed; expected it in CI"
    return found


@pytest.fixture(scope="module")
def hostile_report(tmp_path_factory):
    """A report with hostile texts and figures.

    They are labels, solvers, messages and titles.
    """
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
def test_lualatex_compiles_every_table(hostile_report, tmp_path):
    """LuaLaTeX compiles every table.

    It needs booktabs and longtable alone; what is hostile is printed.
    """
    tables = sorted((hostile_report / "tables").glob("*.tex"))
    inputs = "\n".join(rf"\input{{{table}}}" for table in tables)
    packages = r"\documentclass{article}\usepackage{booktabs,longtable}"
    file = tmp_path / "tables.tex"
    file.write_text(rf"{packages}\begin{{document}}{inputs}\end{{document}}", encoding="utf-8")
    line = [needed("lualatex"), "-interaction=nonstopmode", "-halt-on-error", file.name]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, check=False)

    assert tables
    assert done.returncode == 0, done.stdout[-3000:].decode("utf-8", "replace")


@pytest.mark.slow
def test_no_font_of_a_figure_is_type_3(hostile_report):
    """No font of a figure is type 3.

    Journals refuse bitmap and drawn letters; pdffonts sees what they see.
    """
    pdffonts = needed("pdffonts")
    figures = sorted((hostile_report / "figures").glob("*.pdf"))
    listed = [
        subprocess.run([pdffonts, str(file)], capture_output=True, check=True, text=True).stdout
        for file in figures
    ]

    assert listed
    assert not any("Type 3" in fonts for fonts in listed)
    assert any("TrueType" in fonts for fonts in listed)
