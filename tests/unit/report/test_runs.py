"""The runs in the report: how steady their machines were, in numbers and in words."""

from __future__ import annotations

import csv
import re

import numpy as np
import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.appendix import runs
from tests.unit.report.results_folder import attempt, paper_scenarios
from tests.unit.report.topic_page import topic_page

HOSTILE = "<script>alert('x')</script> & |a_b| $x^2$ \\input{y} `c` [l](u) #%~{}"


def entry(run_id="abc", probes=(), **changes):
    return {
        "run_id": run_id,
        "started": "2026-01-01T00:00:00.000+00:00",
        "ended": "2026-01-01T00:01:00.000+00:00",
        "seconds": 60.0,
        "state": "finished",
        "engine": "local",
        "jobs": 1,
        "machine": {"system": "Linux x86_64", "processor": "Z80", "cores": 4, "usable_cores": 2},
        "governor": "performance",
        "load_start": [0.25, 0.1, 0.1],
        "load_end": [1.5, 0.2, 0.1],
        "probes": [[2.0 * i, took] for i, took in enumerate(probes)],
    } | changes


STEADY = [1e-3 * (1 + 0.001 * (i % 3)) for i in range(40)]
NOISY = [1e-3 * (1 + 0.3 * (i % 2)) for i in range(40)]


@pytest.fixture
def page(results, tmp_path):
    def rendered(*entries):
        folder = results("paper", [attempt(s) for s in paper_scenarios()[:2]], runs=list(entries))
        topic_page(folder, tmp_path / "page", "the runs and their machines")
        return tmp_path / "page"

    return rendered


def test_a_noisy_run_says_so_in_words(page):
    """A machine that varied by 30 % (between two speeds) is named; a quiet one is not."""
    place = page(entry("quiet", STEADY), entry("loud", NOISY))
    text = (place / "report.md").read_text()

    # the 5th and 95th percentile are the two speeds, the median lies between them
    varied = 0.3 / np.median([1, 1.3])
    assert f"Run loud of paper varied by {100 * varied:.1f} %" in text
    assert "Run quiet" not in text
    with (place / "tables" / "runs.csv").open() as stream:
        rows = {row["run"]: row for row in csv.DictReader(stream)}
    assert float(rows["loud"]["spread"]) == pytest.approx(varied)
    assert float(rows["quiet"]["spread"]) == pytest.approx(0.002, rel=0.01)
    where = "Z80, Linux x86_64, 2 of 4 cores; governor performance"
    assert rows["loud"]["where"] == where
    assert rows["loud"]["load"] == "0.25 to 1.50"


@pytest.mark.slow
def test_a_run_on_several_machines_is_as_noisy_as_the_worst(page):
    """A second machine, twice as fast, is no noise."""
    listed = [[2.0 * i, took, 1] for i, took in enumerate(NOISY)]
    listed += [[2.0 * i, took / 2, 2] for i, took in enumerate(STEADY)]
    place = page(entry("both") | {"probes": listed})

    varied = 0.3 / np.median([1, 1.3])
    assert f"Run both of paper varied by {100 * varied:.1f} %" in (place / "report.md").read_text()


@pytest.mark.slow
def test_a_quiet_run_says_so(page):
    place = page(entry("quiet", STEADY))

    assert "No run varied by more than 5.0 %" in (place / "report.md").read_text()


@pytest.mark.slow
def test_a_short_run_does_not_pretend_to_know(page):
    place = page(entry("short", NOISY[:4]))

    assert "No run here was long enough to tell." in (place / "report.md").read_text()


def test_a_run_without_an_end_is_running_or_killed(results):
    found = load([results("paper", [attempt(paper_scenarios()[0])], runs=[entry(state="running")])])

    assert runs(found.folders)["state"].tolist() == ["running, or killed"]


def test_hostile_text_of_a_run_is_shown_as_it_stands(page):
    fields = ("run_id", "started", "state", "engine", "governor")
    hostile = {**dict.fromkeys(fields, HOSTILE), "machine": {"processor": HOSTILE}}
    place = page(entry(**hostile, probes=NOISY))

    html, text = ((place / name).read_text() for name in ("index.html", "report.md"))
    tex = (place / "tables" / "runs.tex").read_text()
    assert "<script>alert" not in html
    assert html.count("&lt;script&gt;") >= len(fields) + 1
    assert "<script" not in text
    assert "\\|a\\_b\\|" in text
    assert not re.search(r"(?<!\\)\|a", text)
    assert "\\input" not in tex.replace("\\textbackslash{}input", "")
