"""Numbers against rows worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from dubins_study.report.data.attempts import VERDICTS
from dubins_study.report.data.failures import failures as failure_counts
from dubins_study.report.data.verdicts import starts
from dubins_study.report.statistics import metrics
from dubins_study.report.statistics.costs import performance_ratios
from dubins_study.report.topics.agreement import agreement
from dubins_study.report.topics.convergence import work_precision
from dubins_study.report.topics.success import gap_quantiles
from dubins_study.report.topics.summary import by_start, solver_summary
from dubins_study.report.topics.time import mean_times, right_times
from dubins_study.study.path import Path
from dubins_study.study.scenario import COLUMNS, Pose
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
        **{"region": "outside", "reference_word": "LS", "answerable": True},
        **{"gap": 0.0, "reference": 1.0, "length": 1.0, "iterations": 1.0},
        **{"build_s": 0.001, "solve_s": 0.002, "wall_s": 0.003},
    }
    return pd.DataFrame({**base, **columns})


def test_failures_stay_in_every_denominator(tmp_path):
    """Four questions with a path, two answered optimally: half are right, whatever came of the
    others. What was asked where no path exists is not counted."""
    rows = frame(
        scenario_id=list("01234"),
        verdict=["optimal", "optimal", "misses", "none", "misses"],
        outcome=["returned", "returned", "returned", "timeout", "crashed"],
        false_claim=[False, False, True, False, True],
        reference_word=["LS"] * 4 + [None],
    )
    line = solver_summary(attempts_of(tmp_path, rows)).iloc[0]

    assert (line["attempts"], line["questions"], line["right_share"]) == (4, 4, 0.5)
    # Wilson's interval of 2 of 4 by hand: 1/2 -+ (1.96 / sqrt(4 + 1.96^2)) / 2
    assert line["right_low"] == pytest.approx(0.1500, abs=5e-5)
    assert line["right_text"] == "50.0 % of 4,\n15.0 to 85.0 %"
    assert (line["misses"], line["none"]) == (1, 1)
    assert (line["false_claims"], line["not_returned"]) == (1, 1)


def test_repeats_are_parts_of_a_question(tmp_path):
    """Right in two of three repeats counts 2/3; the interval is that of two questions, not six."""
    rows = frame(
        scenario_id=["0"] * 3 + ["1"] * 3,
        verdict=["optimal"] * 5 + ["longer"],
        repeat=[0, 1, 2] * 2,
    )
    attempts = attempts_of(tmp_path, rows)
    line = solver_summary(attempts).iloc[0]

    assert (line["attempts"], line["questions"]) == (6, 2)
    assert line["right"] == pytest.approx(5 / 3)
    assert line["right_share"] == pytest.approx(5 / 6)
    assert line["right_low"] < 0.3  # of six trials it would be 0.44


def test_every_attempt_is_in_one_verdict_column(tmp_path):
    rows = frame(
        verdict=["optimal", "longer", "longer", "misses", "none", "none exists", "none exists"],
        presolved=[False] * 6 + [True],
    )
    line = solver_summary(attempts_of(tmp_path, rows)).iloc[0]

    assert (line["none exists"], line["by presolve"]) == (1, 1)
    assert sum(line[verdict] for verdict in VERDICTS) == line["attempts"]


def test_what_the_presolve_answered_is_no_success_of_an_engine(tmp_path):
    """Nor a failure; by rows and by counting alike."""
    rows = frame(
        verdict=["none exists"] * 3,
        proof=["proved", "none", "proved"],
        presolved=[False, True, None],
        gap=NAN,
    )
    counted = attempts_of(tmp_path, rows)
    line, proofs = solver_summary(counted).iloc[0], counted.proofs().iloc[0]

    assert metrics.success(rows).tolist() == [True, False, True]
    assert metrics.proof(rows).tolist() == ["proved", "none", "proved"]
    assert (line["attempts"], line["none exists"], line["by presolve"]) == (3, 2, 1)
    assert line["right_share"] == pytest.approx(2 / 3)
    assert (proofs["proved"], proofs["none"]) == (2, 1)
    assert failure_counts(counted).empty


def test_a_presolve_that_denies_a_path_is_a_failure(tmp_path):
    """It is wrong, and no success is credited to anybody."""
    rows = frame(verdict=["none"], claim=["infeasible"], presolved=True, false_claim=True, gap=NAN)
    counted = attempts_of(tmp_path, rows)
    line = solver_summary(counted).iloc[0]

    assert (line["by presolve"], line["none"], line["false_claims"]) == (0, 1, 1)
    assert len(failure_counts(counted)) == 1


def test_gap_quantiles_count_what_did_not_arrive_as_infinite(tmp_path):
    """Of ten attempts nine arrive: the median is a number, the worst is not."""
    rows = frame(gap=[0.1 * i for i in range(9)] + [NAN])
    line = gap_quantiles(attempts_of(tmp_path, rows).gap_quantiles()).iloc[0]

    assert line["attempts"] == 10
    assert line["arrived"] == 0.9
    assert line["q50"] == pytest.approx(0.4)  # the fifth of ten
    assert line["q90"] == pytest.approx(0.8)
    assert line["q100"] == math.inf


def test_questions_without_an_answer_have_no_gap_to_measure(tmp_path):
    """LS inside the left disc does not exist; refusing it must not look like an infinite gap."""
    rows = frame(gap=[0.0, NAN], reference_word=["LS", None], verdict=["optimal", "none exists"])
    assert gap_quantiles(attempts_of(tmp_path, rows).gap_quantiles()).iloc[0]["attempts"] == 1


def test_a_crash_counts_where_an_answer_exists(tmp_path):
    """A row that lost everything still belongs to a question that has an answer, or has none: the
    target in the left disc is reached by RS and not by LS."""
    lost = {"reference_word": None, "region": None, "gap": NAN}
    lost |= {"verdict": "none", "outcome": "crashed"}
    place = dict(zip(COLUMNS, (0.0, 0.0, 0.0, 0.5, 0.8, 1.0, 1.0, ""), strict=True))
    rows = frame(solver=["a", "b"], branch=["LS", "RS"], **(place | lost))
    table = gap_quantiles(attempts_of(tmp_path, rows).gap_quantiles()).set_index(
        ["solver", "region"]
    )

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


def test_mean_times_use_only_what_every_solver_got_right():
    """Solver b fails question 1, so question 1 counts for neither."""
    rows = frame(
        scenario_id=["0", "0", "1", "1"],
        solver=["a", "b", "a", "b"],
        wall_s=[1.0, 2.0, 100.0, 1.0],
        verdict=["optimal", "optimal", "optimal", "longer"],
    )
    table, shift = mean_times(rows)

    assert shift == pytest.approx(1.25)
    assert table["questions"].tolist() == [1, 1]
    assert table["mean_s"].tolist() == pytest.approx([1.0, 2.0])
    assert table["rank"].tolist() == [1, 2]


def test_time_ratios_keep_failures_as_never_solved():
    """Question 0: b is right in twice the time; 1: only a is right; 2 was never put to b."""
    rows = frame(
        scenario_id=["0", "0", "1", "1", "2"],
        solver=["a", "b", "a", "b", "a"],
        wall_s=[1.0, 2.0, 3.0, 1.0, 1.0],
        verdict=["optimal", "optimal", "optimal", "longer", "optimal"],
    )
    ratios = performance_ratios(right_times(rows))

    assert ratios["a"].tolist() == [1.0, 1.0]
    assert ratios["b"].tolist() == [2.0, math.inf]


def test_agreement_by_hand():
    """Two questions put to both, one answered by both: 10 against 11 long, on one straight line."""
    rows = frame(
        scenario_id=["0", "0", "1", "1"],
        solver=["a", "b", "a", "b"],
        length=[10.0, 11.0, 5.0, NAN],
        reference=[10.0, 10.0, 5.0, 5.0],
        gap=[0.0, 0.1, 0.0, NAN],
    )
    paths = {i: Path(Pose(0, 0, 0), [0.0], [length]) for i, length in enumerate((10, 11, 5, 1))}
    line = agreement(rows, paths.get).iloc[0]

    assert (line["questions"], line["both"]) == (2, 1)
    assert line["largest"] == line["median"] == pytest.approx(0.1)
    assert line["within"] == 0.0
    assert line["apart_largest"] == pytest.approx(0.1)


def test_agreement_divides_by_the_radius_of_a_short_path():
    """max(reference, R): a target at the start has no length to divide by."""
    rows = frame(
        scenario_id=["0", "0"], solver=["a", "b"], length=[0.0, 1e-3], reference=0.0, radius=2.0
    )
    paths = [Path(Pose(0, 0, 0), [0.0], [length]) for length in (0.0, 1e-3)]

    assert agreement(rows, paths.__getitem__).iloc[0]["largest"] == pytest.approx(5e-4)


def settings_of(*specs):
    """What a manifest says of them."""
    defaults = {"n": 50, "engine": "piqp", "mesh": "equal"}
    return {
        spec: defaults | {k: type(defaults[k])(v) for k, v in metrics.parse_spec(spec)[1].items()}
        for spec in specs
    }


def test_work_precision_knows_the_settings_that_specs_leave_out():
    """They are the manifest's, since a profile may have changed them; other solvers do not count,
    and a mesh of another kind is another curve."""
    rows = frame(
        solver=[
            "turn-rate-qp",
            "turn-rate-qp[n=100]",
            "turn-rate-qp[engine=osqp]",
            "turn-rate-qp[mesh=graded]",
            "ipopt",
        ],
        gap=[4e-5, 1e-5, NAN, 1e-7, 0.0],
    )
    table = work_precision(rows, settings_of(*rows["solver"][:4])).set_index(["engine", "n"])

    graded = ("piqp, mesh=graded", 50)
    assert set(table.index) == {("piqp", 50), ("piqp", 100), ("osqp", 50), graded}
    assert table.loc[("piqp", 50), "order"] == pytest.approx(2.0)
    assert table.loc[("osqp", 50), "gap"] == math.inf


def test_the_order_is_fitted_as_far_as_the_gap_falls():
    """An engine that reaches its own accuracy at n=40 is not charged for what follows."""
    rows = frame(
        solver=[f"turn-rate-qp[n={n}]" for n in (10, 20, 40, 80)], gap=[1.6e-3, 4e-4, 1e-4, 5e-2]
    )
    found = work_precision(rows, settings_of(*rows["solver"]))

    assert found["order"].tolist() == pytest.approx([2.0] * 4)


def test_cold_and_warm_attempts_at_a_question_are_one_trial(tmp_path):
    """Of ten questions asked cold and warm, a solver that is right on seven has seven of ten.

    Counted as twenty trials the interval would be narrower by a factor of about the root of two.
    """
    rows = pd.DataFrame(
        [
            {
                **{"experiment": "e", "solver": "b", "branch": "best", "scenario_id": f"{place}"},
                **{"initial_guess": start, "reference_word": "LS", "outcome": "returned"},
                "verdict": "optimal" if place < 7 else "longer",
            }
            for place in range(10)
            for start in ("cold", "warm")
        ]
    )
    line = solver_summary(attempts_of(tmp_path, rows)).iloc[0]

    assert (line["attempts"], line["questions"], line["right"]) == (20, 10, 7)
    # Wilson's interval of 7 in 10, from the quadratic (p - 0.7)^2 = z^2 p (1 - p) / 10
    z = 1.959963984540054
    ends = np.roots([1 + z * z / 10, -(1.4 + z * z / 10), 0.49])
    assert [line["right_low"], line["right_high"]] == pytest.approx(sorted(ends), abs=1e-12)


def test_cold_and_warm_starts_apart(tmp_path):
    """At the questions that were asked both ways; of two cold repeats one right is a half."""
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
    counted = attempts_of(tmp_path, rows)
    (line,) = by_start(starts(counted)).to_dict("records")

    assert (line["cold_of"], line["cold_share"]) == (2, 0.25)
    assert (line["warm_of"], line["warm_share"]) == (2, 1)
    # all in all: question 0 is right in two of three attempts, 1 in one of two, 2 in the only one
    whole = solver_summary(counted).iloc[0]
    assert whole["right"] == pytest.approx(2 / 3 + 1 / 2 + 1, abs=1e-6)
    assert starts(attempts_of(tmp_path / "cold", rows[rows["initial_guess"] == "cold"])).empty
