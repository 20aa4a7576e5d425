"""The numbers that the documentation takes from the benchmark, counted another way."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import duckdb
import pytest

ROOT = Path(__file__).parents[2]
PARTS = ROOT / "results" / "benchmark" / "leg" / "parts" / "*.parquet"


@pytest.fixture
def benchmark(monkeypatch: pytest.MonkeyPatch):
    """The module of `docs/ext` that writes the tables."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "ext"))
    return import_module("benchmark_numbers")


def right_of(spec: str) -> tuple[float, int]:
    """Share of right answers in percent and the number of questions with a path, by SQL alone."""
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
        ("penalty", "DIRECT", "penalty[engine=direct]"),
    ],
)
def test_a_share_is_that_of_the_rows(benchmark, formulation: str, engine: str, spec: str):
    """A question that is right in two of three repeats counts 2/3, in both ways of counting."""
    line = re.search(rf"^\| {engine} .*$", benchmark.formulation(formulation), re.M)
    shown = re.search(r"([\d.]+) % of (\d+)", line[0])
    share, questions = right_of(spec)

    assert int(shown[2]) == questions
    assert float(shown[1]) == pytest.approx(share, abs=0.05)  # shown with one decimal
