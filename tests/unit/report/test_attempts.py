"""Counts of attempts, in any split and order.

Any split of the rows in any order gives the numbers of the whole. Numbers are those of the rows
counted another way, and of rows worked by hand.
"""

import math
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from dubins_study.report.data.attempts import PRESOLVED, PROOFS, VERDICTS
from dubins_study.report.statistics import metrics
from dubins_study.report.topics.certificates import proofs
from dubins_study.report.topics.existence import existence
from dubins_study.report.topics.failures import failures, gist
from dubins_study.report.topics.success import gap_shares
from dubins_study.report.topics.summary import solver_summary
from dubins_study.report.topics.time import solver_times
from dubins_study.study.closed_form.shortest import REGIONS
from dubins_study.study.scenario import NUMBERS
from tests.unit.report.results_folder import attempts_of

SOLVERS = ("analytic", "slsqp", "slsqp[count=3]")
_GAPS = st.none() | st.sampled_from([0.0, 1e-16, 1e-4]) | st.floats(-1e-9, 10)
_SIZES = st.none() | st.floats(0, 1e3)

# Loading a folder and asking for its tables takes half a second: a twentieth of the usual examples.
FEW = settings(max_examples=settings.default.max_examples // 20)


@st.composite
def attempts(draw):
    """Rows with what the numbers need.

    Their combination makes no sense.
    """
    text = st.sampled_from(["", "off by 2.5", "off by 7", "singular"])
    row = st.fixed_dictionaries(
        {
            "experiment": st.sampled_from(["random", "paper"]),
            "solver": st.sampled_from(SOLVERS),
            "branch": st.sampled_from(["best", "LS"]),
            "initial_guess": st.sampled_from(["cold", "warm"]),
            "region": st.sampled_from(REGIONS),
            "word": st.sampled_from(["LS", "L", None]),
            "reference_word": st.sampled_from(["LS", None]),
            "outcome": st.sampled_from(["returned", "timeout"]),
            "claim": st.sampled_from(["optimal", "none"]),
            "presolved": st.sampled_from([False, False, True, None]),
            "verdict": st.sampled_from([v for v in VERDICTS if v != PRESOLVED]),
            "false_claim": st.booleans(),
            "wrong_basin": st.booleans(),
            "native_status": text,
            "message": text | st.none(),
            "gap": _GAPS,
            "proof": st.sampled_from([*PROOFS, None]),
            "lower_bound": _SIZES,
            "reference_low": st.just(1.0),
            "reference_high": st.sampled_from([1.0, 1.5, None]),
            "false_bound": st.booleans() | st.none(),
            "pmp_residual": st.sampled_from([1e-15, 1e-3, None]),
            "cut_margin": _SIZES,
            "costate_error": _SIZES,
            **dict.fromkeys(("build_s", "solve_s", "wall_s"), _SIZES),
            "jobs": st.sampled_from([1, 2]),
            "threads": st.just(1),
        }
    )
    rows = pd.DataFrame(draw(st.lists(row, min_size=12, max_size=40)))
    numbers = ["gap", "lower_bound", "reference_high", "pmp_residual", "cut_margin"]
    numbers += ["costate_error", "build_s", "solve_s", "wall_s"]
    return rows.astype(dict.fromkeys(numbers, float))


def tables(counted):
    """All numbers that are made of attempts."""
    frames = {
        "summary": solver_summary(counted),
        "existence": existence(counted),
        "failures": failures(counted),
        "times": solver_times(counted),
        "proofs": proofs(counted),
        "gap shares": gap_shares(counted),
    }
    return {name: frame.reset_index(drop=True) for name, frame in frames.items()}


def alike(one, two):
    """Whether attempts give the same numbers.

    They are compared to the last bit.
    """
    assert len(one) == len(two)
    expected = tables(one)
    given = tables(two)
    assert expected.keys() == given.keys()
    for name, frame in expected.items():
        pd.testing.assert_frame_equal(frame, given[name], check_exact=True)


@pytest.mark.slow
@FEW
@given(attempts(), st.randoms(use_true_random=False), st.integers(1, 6))
def test_any_split_in_any_order_is_the_whole(rows, random, parts):
    """Any split in any order is the whole.

    Rows go to any parts, and experiments to folders in any order.
    """
    shuffled = rows.sample(frac=1, random_state=random.randrange(2**32))
    which = [random.randrange(parts) for _ in range(len(rows))]
    with tempfile.TemporaryDirectory() as place:
        whole = attempts_of(Path(place, "whole"), rows)
        alike(whole, attempts_of(Path(place, "split"), shuffled, which))


@FEW
@given(attempts())
def test_numbers_are_those_of_the_frame(rows):
    """Computed from the rows themselves, another way."""
    with tempfile.TemporaryDirectory() as place:
        found = attempts_of(Path(place), rows)
        numbers_are_those_of(found, rows)


def numbers_are_those_of(found, rows):
    presolved = (rows["presolved"] == True) & (rows["verdict"] == "none exists")  # noqa: E712 (None)
    rows = rows.assign(verdict=rows["verdict"].mask(presolved, PRESOLVED))
    # Every row is another attempt at one scenario; whether that has a path is drawn for each row. A
    # trial is the scenario with a branch: experiments, initial guesses and repeats are its parts.
    weight = 1 / rows.groupby(["solver", "branch"])["solver"].transform("size")
    rows = rows.assign(weight=weight)
    every = rows
    rows = rows[rows["reference_word"].notna()]
    lines = solver_summary(found).to_dict("records")
    # solvers that were asked nothing that has a path are left out, unless none was
    asked = set(rows["solver"]) or set(every["solver"])
    assert {line["solver"] for line in lines} == asked
    for line in lines:
        solver_rows = rows[rows["solver"] == line["solver"]]
        assert line["attempts"] == len(solver_rows)
        right = solver_rows["verdict"].isin(["optimal", "none exists"])
        assert line["questions"] == pytest.approx(solver_rows["weight"].sum(), abs=1e-5)
        assert line["right"] == pytest.approx(solver_rows.loc[right, "weight"].sum(), abs=1e-5)
        assert line["false_claims"] == solver_rows["false_claim"].sum()
        assert line["not_returned"] == (solver_rows["outcome"] == "timeout").sum()
        # a solver that never returned has solved nothing that could be timed
        timed = (
            solver_rows if (solver_rows["outcome"] == "returned").any() else solver_rows.iloc[:0]
        )
        assert line["wall_s"] == pytest.approx(timed["wall_s"].median(), nan_ok=True)
        assert all(line[v] == (solver_rows["verdict"] == v).sum() for v in VERDICTS)
    for solver, shares in gap_shares(found).items():
        gaps = rows.loc[rows["solver"] == solver, "gap"].fillna(np.inf).clip(lower=0)
        for gap in (1e-10, 1e-4, 10.0):
            assert shares.loc[gap] == pytest.approx((gaps <= gap * (1 + 1e-12)).mean())
    for line in solver_times(found).to_dict("records"):
        solver_rows = rows[(rows["solver"] == line["solver"]) & (rows["initial_guess"] == "cold")]
        expected = solver_rows["solve_s"].quantile([0.25, 0.5, 0.75]).tolist()
        given = [line[f"solve_s{suffix}"] for suffix in ("_q1", "", "_q3")]
        assert given == pytest.approx(expected, nan_ok=True)
    bad = rows[~rows["verdict"].isin(["optimal", "none exists", PRESOLVED])]
    table = failures(found)
    assert table["attempts"].sum() == len(bad)
    messages = [
        m if isinstance(m, str) and m else s
        for m, s in zip(bad.message, bad.native_status, strict=True)
    ]
    assert set(table["message"]) == set(map(gist, messages))


def of_gaps(gaps):
    """Rows of one solver and one region.

    An infinite gap is that of a path that does not arrive.
    """
    gaps = np.where(np.isfinite(gaps), gaps, np.nan)
    base = {"experiment": "e", "verdict": "longer", "outcome": "returned", "reference_word": "LS"}
    return pd.DataFrame({**base, "gap": gaps, "region": "outside", "wall_s": 1.0})


@pytest.mark.slow
def test_the_gap_profile_of_many_gaps_is_right_to_the_last_attempt(tmp_path):
    """The gap profile of many gaps is exact.

    Of 20 000 different gaps the share within each end is exact, to the last attempt.
    """
    gaps = np.random.default_rng(0).lognormal(-12, 4, 20_000)
    gaps[:7] = np.inf
    counted = attempts_of(tmp_path, of_gaps(gaps))
    (shares,) = gap_shares(counted).to_numpy().T.tolist()

    assert shares[-1] == (gaps <= 10).mean() < 1
    for within, share in zip(np.geomspace(1e-16, 10.0, 171), shares, strict=True):
        assert share == pytest.approx((gaps <= within * (1 + 1e-12)).mean(), abs=1e-12)


def frame(**columns):
    """Rows with what the metrics need.

    A scalar is the value of all rows.
    """
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
    """The ends of Wilson's 95 % interval, by scipy."""
    low, high = binomtest(successes, trials).proportion_ci(method="wilson")
    return {"right_low": low, "right_high": high}


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
        | wilson(2, 4),
    ),
    # Counted as twenty trials the interval would be narrower by a factor of about the root of two.
    "cold and warm attempts at a question are parts of one trial": (
        {"scenario_id": [*"0123456789"] * 2, "initial_guess": ["cold"] * 10 + ["warm"] * 10}
        | {"verdict": ["optimal"] * 7 + ["longer"] * 6 + ["optimal"] * 7},
        {"attempts": 20, "questions": 10, "right": 7} | wilson(7, 10),
    ),
}


@pytest.mark.parametrize("name", SUMMARIES)
def test_the_summary_by_hand(tmp_path, name):
    columns, expected = SUMMARIES[name]
    line = solver_summary(attempts_of(tmp_path, frame(**columns))).iloc[0]

    assert line[list(expected)].to_dict() == pytest.approx(expected)


def test_what_the_presolve_answered_is_no_success_of_an_engine(tmp_path):
    """Answers of the presolve are no engine's success.

    Nor are they its failure, but where it denies a path; by rows and by counting alike.
    """
    rows = frame(
        verdict=["none exists"] * 3 + ["none"],
        proof=["proved", "none", "proved", "none"],
        presolved=[False, True, None, True],
        false_claim=[False] * 3 + [True],
        gap=np.nan,
    )
    counted = attempts_of(tmp_path, rows)
    line = solver_summary(counted).iloc[0]
    proven = proofs(counted).iloc[0]

    assert metrics.success(rows).tolist() == [True, False, True, False]
    assert metrics.proof(rows).tolist() == ["proved", "none", "proved", "none"]
    assert (line["attempts"], line["none exists"], line["by presolve"]) == (4, 2, 1)
    assert (line["right_share"], line["none"], line["false_claims"]) == (0.5, 1, 1)
    assert (proven["proved"], proven["none"]) == (2, 2)
    assert failures(counted)["attempts"].tolist() == [1]


def test_a_crash_counts_where_an_answer_exists(tmp_path):
    """A crash counts where an answer exists.

    A row that lost everything still belongs to a question that has an answer, or has none: the
    target in the left disc is reached by RS and not by LS.
    """
    lost = {"reference_word": None, "region": None, "gap": np.nan}
    lost |= {"verdict": "none", "outcome": "crashed"}
    place = dict(zip(NUMBERS, (0.0, 0.0, 0.0, 0.5, 0.8, 1.0, 1.0), strict=True))
    rows = frame(solver=["a", "b"], branch=["LS", "RS"], **(place | lost))
    shares = gap_shares(attempts_of(tmp_path, rows))

    assert list(shares.columns) == ["b"]
    assert (shares["b"] == 0).all()


def test_closed_form_comes_first_and_variants_after_their_solver():
    names = ["zeta", "ipopt[model=joint]", "turn-rate-qp", "ipopt", "analytic", "ipopt"]

    assert metrics.solver_order(names) == [
        "analytic",
        "ipopt",
        "ipopt[model=joint]",
        "turn-rate-qp",
        "zeta",
    ]


def test_fitted_order_recovers_a_power():
    """The fitted order recovers a power.

    gap = 3 n^-2 exactly; a value at rounding level is left out.
    """
    n = np.array([10, 20, 40, 80])
    assert metrics.fitted_order([*n, 640], [*(3.0 / n**2), 1e-16]) == pytest.approx(2)
    assert math.isnan(metrics.fitted_order([10], [0.1]))
