"""Numbers against rows worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from dubins_study.report.statistics import metrics
from dubins_study.report.topics.certificates import proofs
from dubins_study.report.topics.failures import failures
from dubins_study.report.topics.success import gap_quantiles
from dubins_study.report.topics.summary import solver_summary
from dubins_study.study.scenario import NUMBERS
from tests.unit.report.results_folder import attempts_of

NAN = float("nan")


def frame(**columns):
    """Rows with what the metrics need, one value for all where a scalar is given."""
    n = max(len(value) for value in columns.values() if isinstance(value, list))
    base = {
        **{"experiment": "random", "scenario_id": [str(i) for i in range(n)], "solver": "a"},
        **{"branch": "best", "initial_guess": "cold", "repeat": 0, "radius": 1.0},
        **{"outcome": "returned", "claim": "local", "presolved": False, "verdict": "optimal"},
        **{"false_claim": False, "wrong_basin": False, "message": "", "native_status": ""},
        **{"region": "outside", "reference_word": "LS", "answerable": True, "late": False},
        **{"gap": 0.0, "reference": 1.0, "length": 1.0, "iterations": 1.0},
        **{"build_s": 0.001, "solve_s": 0.002, "wall_s": 0.003},
    }
    return pd.DataFrame({**base, **columns})


def wilson(successes, trials):
    """Wilson's 95 % interval, from its quadratic (p - k/n)^2 = z^2 p (1 - p) / n."""
    share, z2 = successes / trials, 1.959963984540054**2 / trials
    return sorted(np.roots([1 + z2, -(2 * share + z2), share**2]))


SUMMARIES = {
    # Four questions with a path, two answered optimally: half are right, whatever came of the
    # others. What was asked where no path exists is not counted.
    "failures stay in every denominator": (
        {
            "scenario_id": list("01234"),
            "verdict": ["optimal", "optimal", "misses", "none", "misses"],
            "outcome": ["returned", "returned", "returned", "timeout", "crashed"],
            "false_claim": [False, False, True, False, True],
            "reference_word": ["LS"] * 4 + [None],
        },
        {"attempts": 4, "questions": 4, "right_share": 0.5, "misses": 1, "none": 1}
        | {"false_claims": 1, "not_returned": 1, "right_text": "50.0 % of 4,\n15.0 to 85.0 %"}
        | dict(zip(("right_low", "right_high"), wilson(2, 4), strict=True)),
    ),
    # Right in two of three repeats counts 2/3.
    "repeats are parts of a question": (
        {"scenario_id": list("000111"), "verdict": ["optimal"] * 5 + ["longer"]}
        | {"repeat": [0, 1, 2] * 2},
        {"attempts": 6, "questions": 2, "right": 5 / 3, "right_share": 5 / 6},
    ),
    # Counted as twenty trials the interval would be narrower by a factor of about the root of two.
    "cold and warm attempts at a question are one trial": (
        {"scenario_id": [*"0123456789"] * 2, "initial_guess": ["cold"] * 10 + ["warm"] * 10}
        | {"verdict": (["optimal"] * 7 + ["longer"] * 3) * 2},
        {"attempts": 20, "questions": 10, "right": 7}
        | dict(zip(("right_low", "right_high"), wilson(7, 10), strict=True)),
    ),
    "every attempt is in one verdict column": (
        {"verdict": ["optimal", "longer", "longer", "misses", *["none exists"] * 2]}
        | {"presolved": [False] * 5 + [True]},
        {"optimal": 1, "longer": 2, "misses": 1, "none": 0, "none exists": 1, "by presolve": 1},
    ),
}


@pytest.mark.parametrize("name", SUMMARIES)
def test_the_summary_by_hand(tmp_path, name):
    columns, expected = SUMMARIES[name]
    line = solver_summary(attempts_of(tmp_path, frame(**columns))).iloc[0]

    assert line[list(expected)].to_dict() == pytest.approx(expected)


def test_what_the_presolve_answered_is_no_success_of_an_engine(tmp_path):
    """Nor a failure, but where it denies a path; by rows and by counting alike."""
    rows = frame(
        verdict=["none exists"] * 3 + ["none"],
        proof=["proved", "none", "proved", "none"],
        presolved=[False, True, None, True],
        false_claim=[False] * 3 + [True],
        gap=NAN,
    )
    counted = attempts_of(tmp_path, rows)
    line, proven = solver_summary(counted).iloc[0], proofs(counted).iloc[0]

    assert metrics.success(rows).tolist() == [True, False, True, False]
    assert metrics.proof(rows).tolist() == ["proved", "none", "proved", "none"]
    assert (line["attempts"], line["none exists"], line["by presolve"]) == (4, 2, 1)
    assert (line["right_share"], line["none"], line["false_claims"]) == (0.5, 1, 1)
    assert (proven["proved"], proven["none"]) == (2, 2)
    assert failures(counted)["attempts"].tolist() == [1]


def test_gap_quantiles_count_what_did_not_arrive_as_infinite(tmp_path):
    """Of ten attempts nine arrive: the median is a number, the worst is not.

    The eleventh is at a question without a path: refusing it must not look like an infinite gap.
    """
    rows = frame(gap=[0.1 * i for i in range(9)] + [NAN] * 2, reference_word=["LS"] * 10 + [None])
    line = gap_quantiles(attempts_of(tmp_path, rows)).iloc[0]

    assert line["attempts"] == 10
    assert line["arrived"] == 0.9
    assert line["q50"] == pytest.approx(0.4)  # the fifth of ten
    assert line["q90"] == pytest.approx(0.8)
    assert line["q100"] == math.inf


def test_a_crash_counts_where_an_answer_exists(tmp_path):
    """A row that lost everything still belongs to a question that has an answer, or has none: the
    target in the left disc is reached by RS and not by LS."""
    lost = {"reference_word": None, "region": None, "gap": NAN}
    lost |= {"verdict": "none", "outcome": "crashed"}
    place = dict(zip(NUMBERS, (0.0, 0.0, 0.0, 0.5, 0.8, 1.0, 1.0), strict=True))
    rows = frame(solver=["a", "b"], branch=["LS", "RS"], **(place | lost))
    table = gap_quantiles(attempts_of(tmp_path, rows)).set_index(["solver", "region"])

    assert list(table.index) == [("b", "all")]
    assert table.loc[("b", "all"), "q50"] == math.inf


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("ipopt", ("ipopt", {})),
        ("turn-rate-qp[n=10,engine=osqp]", ("turn-rate-qp", {"n": "10", "engine": "osqp"})),
        ("my file.py:Class[a=1]", ("my file.py:Class", {"a": "1"})),
        ("odd]name[", ("odd]name[", {})),
    ],
)
def test_parse_spec(spec, expected):
    assert metrics.parse_spec(spec) == expected


def test_closed_form_comes_first_and_variants_after_their_solver():
    names = ["zeta", "ipopt[model=joint]", "turn-rate-qp", "ipopt", "analytic", "ipopt"]

    assert metrics.solver_order(names) == [
        "analytic",
        "ipopt",
        "ipopt[model=joint]",
        "turn-rate-qp",
        "zeta",
    ]


def test_circle_radius_of_problem_5():
    """Test problem 5 of the paper: its target enters the left disc for R above 57.352960."""
    found = metrics.circle_radius(0, 0, 2 * math.pi / 3, -80, 20)

    assert found == pytest.approx(57.352960, abs=5e-7)
    assert metrics.circle_radius(0, 0, 0, 3, 0) == math.inf


def test_fitted_order_recovers_a_power():
    """gap = 3 n^-2 exactly; a value at rounding level is left out."""
    n = np.array([10, 20, 40, 80])
    assert metrics.fitted_order([*n, 640], [*(3.0 / n**2), 1e-16]) == pytest.approx(2)
    assert math.isnan(metrics.fitted_order([10], [0.1]))


def test_runs_of_equal_words():
    assert metrics.runs_of(["LS", "LS", "RL"]) == [(0, 2, "LS"), (2, 3, "RL")]
    assert metrics.runs_of([]) == []


def test_cold_and_warm_starts_and_repeats_are_parts_of_a_question(tmp_path):
    """One question is right in two of three attempts, one in one of two, one in the only one."""
    cell = {"experiment": "e", "solver": "b", "branch": "best", "reference_word": "LS"}
    kinds = [
        *(("0", "cold", v) for v in ("optimal", "longer")),
        *(("1", "cold", "longer"), ("2", "cold", "optimal")),
        *(("0", "warm", "optimal"), ("1", "warm", "optimal")),
    ]
    rows = pd.DataFrame(
        [
            {**cell, "scenario_id": name, "initial_guess": start, "verdict": verdict}
            for name, start, verdict in kinds
        ]
    )
    whole = solver_summary(attempts_of(tmp_path, rows)).iloc[0]

    assert whole["right"] == pytest.approx(2 / 3 + 1 / 2 + 1, abs=1e-6)
