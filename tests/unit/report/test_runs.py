"""The runs in the report: how steady their machines were, in numbers and in words."""

from __future__ import annotations

import numpy as np
import pytest

from dubins_study.report.topics.appendix import runs_section
from tests.unit.report.results_folder import attempt, paper_scenarios


def entry(run_id="abc", probes=(), **changes):
    return {
        "run_id": run_id,
        "state": "finished",
        "machine": {"system": "Linux x86_64", "processor": "Z80", "cores": 4, "usable_cores": 2},
        "governor": "performance",
        "load_start": [0.25, 0.1, 0.1],
        "load_end": [1.5, 0.2, 0.1],
        "probes": [[2.0 * i, took] for i, took in enumerate(probes)],
    } | changes


STEADY = [1e-3 * (1 + 0.001 * (i % 3)) for i in range(40)]
NOISY = [1e-3 * (1 + 0.3 * (i % 2)) for i in range(40)]


@pytest.fixture
def section(load_rows):
    def written(*entries):
        return runs_section(load_rows("paper", [attempt(paper_scenarios()[0])], runs=entries))

    return written


def test_a_noisy_run_says_so_in_words(section):
    """A machine that varied by 30 % (between two speeds) is named; a quiet one is not."""
    written = section(entry("quiet", STEADY), entry("loud", NOISY))

    # the 5th and 95th percentile are the two speeds, the median lies between them
    varied = 0.3 / np.median([1, 1.3])
    assert f"Run loud of paper varied by {100 * varied:.1f} %" in written.text
    assert "Run quiet" not in written.text
    (table,) = written.blocks
    rows = table.frame.set_index("run")
    assert rows["spread"].to_dict() == pytest.approx({"quiet": 0.002, "loud": varied}, rel=0.01)
    assert rows.loc["loud", "where"] == "Z80, Linux x86_64, 2 of 4 cores; governor performance"
    assert rows.loc["loud", "load"] == "0.25 to 1.50"
    assert table.marks == {(1, "spread"): "bad"}


@pytest.mark.parametrize(
    ("probes", "sentence"),
    [
        (STEADY, "No run varied by more than 5.0 %"),
        (NOISY[:4], "No run here was long enough to tell."),
    ],
    ids=["quiet", "short"],
)
def test_a_run_that_is_not_known_to_be_noisy(section, probes, sentence):
    assert sentence in section(entry(probes=probes)).text


def test_a_run_without_an_end_is_running_or_killed(section):
    """How long a killed one took is not known."""
    (table,) = section(entry(state="running", seconds=0.001), entry(seconds=3.0)).blocks

    assert table.frame["state"].tolist() == ["running, or killed", "finished"]
    assert table.frame["seconds"].tolist() == pytest.approx([float("nan"), 3.0], nan_ok=True)
