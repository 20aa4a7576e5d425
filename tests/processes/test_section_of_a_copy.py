"""A run keeps the key that chooses its section in the report."""

from __future__ import annotations

import re

import pytest

from dubins_study import render, run
from dubins_study.experiments.definition.experiment import read


@pytest.mark.slow
def test_a_copied_study_keeps_its_section(tmp_path):
    """The TOML file's `section` reaches the page through the manifest, whatever the file's name."""
    text = read("basins").text.replace(", 25]", ", 2]")
    solvers = '["slsqp[model=joint,order=LRS,initial_guess=given,maxiter=200]"]'
    text = re.sub(r"(?ms)^solvers = \[.*?^\]", f"solvers = {solvers}", text)
    file = tmp_path / "first-guesses.toml"
    file.write_text(text, encoding="utf-8")

    page = render([run(str(file), tmp_path / "out", jobs=1)], tmp_path / "report")

    assert re.search('<section id="basins"[ >]', page.read_text(encoding="utf-8"))
