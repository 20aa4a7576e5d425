"""What evaluations and seconds go to: numbers by hand on made-up rows, and the section."""

from __future__ import annotations

from functools import partial

import pandas as pd
import pytest

from dubins_study.report.statistics.costs import KINDS
from dubins_study.report.statistics.methods import compared
from dubins_study.report.topics.cost import cost_section, factors, presolve_pairs, shares, split
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt

WORDS = ("LS", "RS", "LR", "RL")


def outside():
    """Scenarios whose shortest path is LS, to which RS exists too and LR and RL do not."""
    places = [Scenario(0, 0, 0, 8 + k, 3 + k / 2, 1, label=f"stratum {k % 2}") for k in range(4)]
    for scenario in places:
        assert shortest(scenario).word == "LS"
        exist = {word for word in WORDS if shortest(scenario, word) is not None}
        assert exist == {"LS", "RS"}
    return places


def costly(scenario, solver="ipopt", **changes):
    """Four words: 10 of the winner's 30 evaluations count, 20 lose, 50 + 100 are for nothing."""
    made = {
        "engine": "Ipopt",
        "subproblems": " ".join(WORDS),
        "subproblem_runs": [3.0, 1.0, 5.0, 5.0],
        "subproblem_evaluations": [30.0, 20.0, 50.0, 100.0],
        "subproblem_s": [0.03, 0.02, 0.05, 0.10],
        "best_run_evaluations": 10,
        "best_run_s": 0.01,
        "evaluations": 205,
        "build_s": 0.02,
        "solve_s": 0.2,
        "wall_s": 0.23,
    }
    return attempt(scenario, solver, claim=Claim.LOCAL, **(made | changes))


presolved = partial(costly, solver="ipopt[presolve=True]")


@pytest.fixture
def attempts(load_rows):
    """Attempts at a benchmark's questions, as they are compared."""
    return lambda rows: compared(load_rows("benchmark", rows))


def test_every_evaluation_and_second_has_one_kind(attempts):
    made = attempts([costly(scenario) for scenario in outside()])
    parts = split(made)
    numbers = {
        "evaluations": [10, 20, 20, 150, 0, 5, 205],
        "seconds": [0.01, 0.02, 0.02, 0.15, 0.02, 0.01, 0.23],
    }

    for amount, expected in numbers.items():
        frame = parts.amount(amount)
        assert list(frame.columns) == [*KINDS, "total"]
        assert frame.iloc[0].tolist() == pytest.approx(expected)
        summed = frame.drop(columns="total").sum(axis=1)
        assert summed.to_numpy() == pytest.approx(frame["total"].to_numpy())


def test_the_winner_is_the_word_of_the_answer_that_took_long_enough(attempts):
    """A path LS comes from the joint model's order LRS; a tie is decided by the engine's time."""
    joint = costly(
        outside()[0],
        "ipopt[model=joint]",
        formulation="joint NLP, both orders",
        subproblems="RLS LRS",
        subproblem_runs=[1.0, 1.0],
        subproblem_evaluations=[44.0, 20.0],
        subproblem_s=[0.03, 0.02],
        best_run_evaluations=20,
        best_run_s=0.02,
        evaluations=64,
    )
    made = attempts([joint])
    line = split(made).evaluations.iloc[0]

    assert (line["winning run"], line["restarts"], line["losing words"]) == (20, 0, 44)
    assert line["words without a path"] == 0


def test_factors_and_shares(load_rows):
    """205 / 10 evaluations and 0.23 / 0.01 s everywhere; the presolve's twin is known."""
    results = load_rows(
        "benchmark", [make(scenario) for scenario in outside() for make in (costly, presolved)]
    )
    made = compared(results)
    parts = split(made)
    names = [block.name for block in cost_section(results).blocks]
    line = factors(made, parts).loc["ipopt"]
    part = shares(made, parts, "evaluations").loc["ipopt"]

    assert names == ["cost-evaluations", "cost-seconds", "cost"]
    assert (line["questions"], line["evaluations"], line["seconds"]) == (4, 20.5, pytest.approx(23))
    assert line["evaluations_low"] == line["evaluations_high"] == 20.5
    assert presolve_pairs(made.engines) == [("ipopt", "ipopt[presolve=True]")]
    assert part["words without a path"] == pytest.approx(150 / 205)


def test_wrong_answers_and_engines_that_do_not_count(attempts):
    """Only right answers have a winning run; without counts the seconds still do."""
    first, second, *_ = outside()
    uncounted = costly(
        first,
        evaluations=None,
        best_run_evaluations=None,
        subproblem_evaluations=[float("nan")] * 4,
    )
    wrong = attempt(second, "ipopt", path=None, claim=Claim.FAILED, best_run_s=0.5)
    made = attempts([uncounted, wrong])
    parts = split(made)

    assert parts.evaluations["total"].isna().all()
    assert parts.seconds["total"].tolist() == [0.23]
    assert shares(made, parts, "evaluations").empty
    assert pd.isna(factors(made, parts).loc["ipopt", "evaluations"])
