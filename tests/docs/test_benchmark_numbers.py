"""The numbers that the documentation takes from the benchmark, counted another way."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import duckdb
import pytest

ROOT = Path(__file__).parents[2]
PARTS = ROOT / "results" / "benchmark" / "parts" / "*.parquet"


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
        ("grid of headings", "HiGHS", "heading-milp[presolve=True]"),
        ("disjunction", "SCIP", "disjunctive"),
        ("penalty", "differential evolution", "penalty"),
    ],
)
def test_a_share_is_that_of_the_rows(benchmark, formulation: str, engine: str, spec: str):
    """A question that is right in two of three repeats counts 2/3, in both ways of counting."""
    line = re.search(rf"^\| {engine} .*$", benchmark.formulation(formulation), re.M)
    shown = re.search(r"([\d.]+) % of (\d+)", line[0])
    share, questions = right_of(spec)

    assert int(shown[2]) == questions
    assert float(shown[1]) == pytest.approx(share, abs=0.05)  # shown with one decimal


@pytest.mark.slow
def test_what_one_order_alone_leaves_unanswered_is_counted_over_all_rows(benchmark):
    """Of the questions that an engine with both orders always answers; by SQL alone."""
    sentence = benchmark.finding("single_order")
    [(region, order, share)] = duckdb.sql(
        f"""WITH answers AS (
            SELECT scenario_id, branch, region, formulation, solver,
                bool_and(verdict = 'optimal' AND NOT presolved) AS every_time,
                bool_or(verdict = 'optimal' AND NOT presolved) AS ever
            FROM '{PARTS}' WHERE reference IS NOT NULL GROUP BY ALL),
        engines AS (
            SELECT scenario_id, branch, region, formulation,
                bool_or(every_time) AS sure, bool_or(ever) AS ever FROM answers GROUP BY ALL)
        SELECT pair.region, right(alone.formulation, 3), 100 * avg((NOT alone.ever)::INT) AS lost
        FROM engines AS pair JOIN engines AS alone USING (scenario_id, branch)
        WHERE pair.formulation = 'joint NLP, both orders' AND pair.sure
            AND alone.formulation IN ('joint NLP, LRS', 'joint NLP, RLS')
        GROUP BY ALL ORDER BY lost DESC LIMIT 1"""
    ).fetchall()

    assert f"in the {region}" in sentence
    assert f"with the order {order} alone" in sentence
    stated = re.search(r"([\d.]+)\s%", sentence)
    assert float(stated[1]) == pytest.approx(share, abs=0.05)  # shown with one decimal
