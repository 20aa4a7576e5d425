"""A run on a machine without compiled loops."""

import os
import subprocess
import sys

import pytest

from dubins_study import load_results

TOUR = """
title = "A tour"
question = "Is it proved, though its loops take longer to compile than its limit?"
section = "tours"
time_limit_s = 1
seed = 1
solvers = ["analytic"]

[[scenarios]]
[scenarios.tour]
points = [5]
density = "8R"
count = 2
seed = 34
"""


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_no_limit_counts_what_is_compiled(tmp_path):
    """No limit counts the time of compiling.

    The loops of tours take some 40 s to compile, and the limit of the run is a second.
    """
    (tmp_path / "tour.toml").write_text(TOUR)
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-m", "dubins_study", "run", "tour.toml", "--out", "folder"]

    subprocess.run(command, cwd=tmp_path, env=cold, check=True, capture_output=True)

    rows = load_results(tmp_path / "folder")
    assert rows["outcome"].tolist() == ["returned"] * 2
    assert rows["proof"].tolist() == ["proved"] * 2
