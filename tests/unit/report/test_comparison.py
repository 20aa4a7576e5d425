"""The comparison of methods and of their costs.

Numbers are worked by hand on made-up rows: what evaluations and seconds go to.
"""

from functools import partial

import numpy as np
import pytest

from dubins_study.report.statistics.costs import KINDS
from dubins_study.report.statistics.methods import compared, methods_of
from dubins_study.report.topics.comparison import (
    comparison_section,
    formulation_tests,
    mean_ranks,
    times,
)
from dubins_study.report.topics.cost import cost_section, shares, split
from dubins_study.report.topics.failures import failures
from dubins_study.report.topics.findings import presolve_pairs
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt

WORD, JOINT = "one NLP a word", "joint NLP, both orders"
QUESTIONS = [Scenario(0, 0, 0, 4 + k, 2, 1, label="far" if k > 3 else "near") for k in range(12)]


def answer(scenario, solver, seconds, right=True, **changes):
    path, claim = ("exact", Claim.LOCAL) if right else (None, Claim.FAILED)
    changes = {"wall_s": seconds, "evaluations": round(1e4 * seconds), **changes}
    return attempt(scenario, solver, path=path, claim=claim, **changes)


def answers():
    """Answers of Ipopt and SLSQP on two formulations.

    They take 2 and 1 ms on words; jointly they take 4 ms and half are wrong.
    """
    rows = []
    for number, scenario in enumerate(QUESTIONS):
        ipopt, slsqp = {"engine": "Ipopt"}, {"engine": "SLSQP"}
        noise = 1 + number / 100
        rows += [
            answer(scenario, "analytic", 1e-6, formulation="closed form", guess="none"),
            answer(scenario, "ipopt", 2e-3 * noise, **ipopt),
            answer(scenario, "slsqp", 1e-3 * noise, **slsqp),
            answer(
                scenario,
                "ipopt[model=joint]",
                4e-3 * noise,
                right=number % 2 == 0,
                formulation=JOINT,
                **ipopt,
            ),
        ]
    return rows


@pytest.fixture
def asked(load_rows):
    """Results of a run with 2 s an attempt."""
    return lambda rows, name="benchmark": load_rows(name, rows, time_limit_s=2.0)


def test_costs_leave_out_the_closed_form_and_who_met_too_few(asked):
    rows = [*answers(), answer(QUESTIONS[0], "rare", 1.0)]
    table = times(compared(asked(rows)))

    assert list(table.columns) == ["ipopt", "slsqp", "ipopt[model=joint]"]
    assert np.isinf(table["ipopt[model=joint]"]).sum() == 6


def test_means_ranks_and_shares(asked):
    """Means, ranks and shares by hand.

    Half the questions are at the limit of 2 s.
    """
    comparison = compared(asked(answers()))
    ranked, shift = mean_ranks(comparison)
    joint = ranked.loc["ipopt[model=joint]"]
    joint_times = [4e-3 * (1 + n / 100) for n in range(0, 12, 2)]

    assert list(ranked.index) == ["slsqp", "ipopt", "ipopt[model=joint]"]
    assert ranked["rank"].tolist() == [1, 2, 3]
    assert (joint["questions"], joint["right"]) == (12, 0.5)
    logs = np.log(np.array([*joint_times, *[2.0] * 6]) + shift)
    assert joint["mean"] == pytest.approx(np.exp(logs.mean()) - shift)
    assert joint["mean_low"] < joint["mean"] < joint["mean_high"]


@pytest.mark.parametrize("limit_s", [None, 4.0])
def test_a_late_answer_is_a_failure_everywhere(asked, limit_s):
    """A late answer is a failure everywhere.

    Right after 3 s counts as wrong after 2 s, in shares, counts and means; a row's own limit goes
    before the run's.
    """
    rows = [answer(q, "slsqp", 1e-3, right=True, limit_s=limit_s) for q in QUESTIONS]
    rows += [answer(q, "ipopt", 3.0, right=True, limit_s=limit_s) for q in QUESTIONS[:3]]
    rows += [answer(q, "ipopt", 1e-3, right=True, limit_s=limit_s) for q in QUESTIONS[3:]]
    results = asked(rows)
    comparison = compared(results)
    counts = solver_summary(results.attempts).set_index("solver").loc["ipopt"]
    lost = 3 if limit_s is None else 0

    assert comparison.rows.groupby("solver")["right"].sum().to_dict() == {
        "ipopt": 12 - lost,
        "slsqp": 12,
    }
    assert np.isinf(times(comparison)["ipopt"]).sum() == lost
    assert mean_ranks(comparison)[0].loc["ipopt", "right"] == pytest.approx(1 - lost / 12)
    assert (counts["right"], counts["late"], counts["optimal"]) == (12 - lost, lost, 12 - lost)
    assert failures(results.attempts)["attempts"].sum() == lost


def test_paired_tests_share_a_formulation(asked):
    """Paired tests share a formulation.

    Twelve wins of twelve: p = 2 / 2^12 by the exact sign test.
    """
    comparison = compared(asked(answers()))
    (test,) = formulation_tests(times(comparison), mean_ranks(comparison)[0]).to_dict("records")

    assert (test["formulation"], test["solver"], test["rival"]) == (WORD, "slsqp", "ipopt")
    assert (test["wins"], test["losses"]) == (12, 0)
    assert test["p_holm"] == pytest.approx(2 / 2**12)


def test_methods_are_named_by_the_settings_that_differ(asked):
    rows = [
        answer(QUESTIONS[0], spec, 1e-3, engine="Ipopt")
        for spec in ("ipopt", "ipopt[presolve=True]", "ipopt[presolve=True,polish=False]")
    ]
    rows.append(answer(QUESTIONS[0], "slsqp[presolve=True]", 1e-3, engine="SLSQP"))
    names = methods_of(asked(rows).rows)["short"]

    assert names.to_dict() == {
        "ipopt": "Ipopt",
        "ipopt[presolve=True,polish=False]": "Ipopt, presolve, polish off",
        "ipopt[presolve=True]": "Ipopt, presolve",
        "slsqp[presolve=True]": "SLSQP, presolve",
    }


def test_the_section_and_what_has_none(asked):
    section = comparison_section(asked(answers()))
    single = asked([answer(s, "slsqp", 1e-3) for s in QUESTIONS], "single")
    failed = [
        answer(s, solver, 1e-3, right=False) for s in QUESTIONS for solver in ("slsqp", "ipopt")
    ]

    assert len(section.blocks) == 3  # profiles, ranks, tests
    assert "12 questions with a path, put to 3 methods" in section.text
    assert comparison_section(single) is None
    assert comparison_section(asked(failed, "failed")) is not None


def outside():
    """Scenarios whose shortest path is LS."""
    return [Scenario(0, 0, 0, 8 + k, 3 + k / 2, 1, label=f"stratum {k % 2}") for k in range(4)]


def costly(scenario, solver="ipopt", **changes):
    """Four words with counted evaluations.

    10 of 200 are those of the winning run, 5 lie outside of all.
    """
    columns = {
        "engine": "Ipopt",
        "subproblems": "LS RS LR RL",
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
    return attempt(scenario, solver, claim=Claim.LOCAL, **(columns | changes))


presolved = partial(costly, solver="ipopt[presolve=True]")


@pytest.fixture
def attempts(load_rows):
    """Attempts at a benchmark's questions, as they are compared."""
    return lambda rows: compared(load_rows("benchmark", rows))


def test_every_evaluation_and_second_has_one_kind(attempts):
    comparison = attempts([costly(scenario) for scenario in outside()])
    parts = split(comparison)
    numbers = {
        "evaluations": [10, 190, 0, 5, 205],
        "seconds": [0.01, 0.19, 0.02, 0.01, 0.23],
    }

    for amount, expected in numbers.items():
        frame = parts[amount].drop(columns="solver")
        assert list(frame.columns) == [*KINDS, "total"]
        assert frame.iloc[0].tolist() == pytest.approx(expected)
        summed = frame.drop(columns="total").sum(axis=1)
        assert summed.to_numpy() == pytest.approx(frame["total"].to_numpy())


def test_shares(load_rows):
    """Shares of evaluations.

    Other runs have 190 of 205 evaluations in all; the presolve's twin is known.
    """
    results = load_rows(
        "benchmark", [make(scenario) for scenario in outside() for make in (costly, presolved)]
    )
    comparison = compared(results)
    names = [block.name for block in cost_section(results).blocks]
    part = shares(comparison, split(comparison)["evaluations"]).loc["ipopt"]

    assert names == ["cost-evaluations", "cost-seconds"]
    assert presolve_pairs(comparison.engines) == [("ipopt", "ipopt[presolve=True]")]
    assert part["other runs"] == pytest.approx(190 / 205)


def test_wrong_answers_and_engines_that_do_not_count(attempts):
    """Wrong answers have no winning run.

    Only right answers have one; without an engine's counts the seconds still do.
    """
    first, second, *_ = outside()
    uncounted = costly(
        first,
        evaluations=None,
        best_run_evaluations=None,
        subproblem_evaluations=[float("nan")] * 4,
    )
    wrong = attempt(second, "ipopt", path=None, claim=Claim.FAILED, best_run_s=0.5)
    comparison = attempts([uncounted, wrong])
    parts = split(comparison)

    assert parts["evaluations"]["total"].isna().all()
    assert parts["seconds"]["total"].tolist() == [0.23]
    assert shares(comparison, parts["evaluations"]).empty
