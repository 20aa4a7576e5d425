"""The reduction: any split of the rows in any order gives the numbers of the whole."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from dubins_study.report.data import spread
from dubins_study.report.data.reduction import merged, of
from dubins_study.report.data.spread import ERROR, Spread
from dubins_study.report.data.tally import PROOFS, gist
from dubins_study.report.statistics import metrics
from dubins_study.report.statistics.timing import times
from dubins_study.report.topics.certificates.numbers import certificates

SOLVERS = ("analytic", "slsqp", "slsqp[count=3]")
REGIONS = ("outside", "left disc", "right disc", "circle")
_GAPS = st.none() | st.sampled_from([0.0, 1e-16, 1e-4]) | st.floats(-1e-9, 10)
_SIZES = st.none() | st.floats(0, 1e3)


@st.composite
def attempts(draw):
    """Rows with what the numbers need, in no sensible combination."""
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
            "verdict": st.sampled_from(metrics.VERDICTS),
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
    rows = pd.DataFrame(draw(st.lists(row, min_size=1, max_size=30)))
    numbers = ["gap", "lower_bound", "reference_high", "pmp_residual", "cut_margin"]
    numbers += ["costate_error", "build_s", "solve_s", "wall_s"]
    return rows.astype(dict.fromkeys(numbers, float))


def tables(found):
    """All numbers that are made of a reduction."""
    return [
        make(found) for make in (metrics.summary, metrics.failures, metrics.gap_quantiles, times)
    ] + [certificates(found)]


def alike(one, two):
    """Whether two reductions are the same, to the last bit."""
    assert one.tallies.keys() == two.tallies.keys()
    for key, tally in one.tallies.items():
        other = two.tallies[key]
        assert tally.counts == other.counts
        for name in tally.spreads.keys() | other.spreads.keys():
            same_spread(tally.spread(name), other.spread(name))


def same_spread(one, two):
    assert one.values.tobytes() == two.values.tobytes()
    assert one.counts.tolist() == two.counts.tolist()
    assert one.cut == two.cut
    ends = [(s.least, s.largest) for s in (one, two)]
    assert np.array_equal(*np.array(ends), equal_nan=True)


@given(attempts(), st.randoms(use_true_random=False), st.integers(1, 6))
def test_any_split_in_any_order_is_the_whole(rows, random, parts):
    """Merged one after another, in a tree, or at once; and tables with them."""
    which = np.array([random.randrange(parts) for _ in range(len(rows))])
    pieces = [of(rows[which == part]) for part in range(parts)]
    random.shuffle(pieces)
    chain = pieces[0]
    for piece in pieces[1:]:
        chain = chain.merge(piece)
    middle = parts // 2
    tree = merged(pieces[middle:]).merge(merged(pieces[:middle]))

    whole = of(rows)
    for other in (chain, tree, merged(pieces)):
        alike(whole, other)
        for one, two in zip(tables(whole), tables(other), strict=True):
            pd.testing.assert_frame_equal(
                one.reset_index(drop=True), two.reset_index(drop=True), check_exact=True
            )


@given(attempts())
def test_numbers_are_those_of_the_frame(rows):
    """Computed from the rows themselves, another way."""
    found = of(rows)
    for line in metrics.summary(found).to_dict("records"):
        own = rows[rows["solver"] == line["solver"]]
        assert line["attempts"] == len(own)
        right = own["verdict"].isin(["optimal", "none exists"])
        assert line["success"] == pytest.approx(right.mean())
        assert line["false_claims"] == own["false_claim"].sum()
        assert line["not_returned"] == (own["outcome"] == "timeout").sum()
        assert line["wall_s"] == pytest.approx(own["wall_s"].median(), nan_ok=True)
        assert all(line[v] == (own["verdict"] == v).sum() for v in metrics.VERDICTS)
    for line in metrics.gap_quantiles(found).to_dict("records"):
        own = rows[(rows["solver"] == line["solver"]) & rows["reference_word"].notna()]
        own = own if line["region"] == "all" else own[own["region"] == line["region"]]
        gaps = np.sort(own["gap"].fillna(np.inf).clip(lower=0))
        assert line["attempts"] == len(gaps)
        assert line["q100"] == gaps[-1]
        assert line["q50"] == gaps[int(np.ceil(len(gaps) / 2)) - 1]
    for line in times(found).to_dict("records"):
        own = rows[(rows["solver"] == line["solver"]) & (rows["initial_guess"] == "cold")]
        expected = own["solve_s"].quantile([0.25, 0.5, 0.75]).tolist()
        given = [line[f"solve_s{suffix}"] for suffix in ("_q1", "", "_q3")]
        assert given == pytest.approx(expected, nan_ok=True)
    bad = rows[~rows["verdict"].isin(["optimal", "none exists"])]
    table = metrics.failures(found)
    assert table["attempts"].sum() == len(bad)
    said = [
        m if isinstance(m, str) and m else s
        for m, s in zip(bad.message, bad.native_status, strict=True)
    ]
    assert set(table["said"]) == set(map(gist, said))


def test_texts_as_categories_are_texts():
    """As they come out of streamed parts."""
    rows = pd.DataFrame({"experiment": "e", "solver": ["a", "b", "a"], "verdict": ["none"] * 3})
    rows = rows.assign(initial_guess="cold", wall_s=[1.0, 2.0, 3.0], gap=np.nan, outcome="crashed")
    rows = rows.assign(reference_word="LS", region="outside", false_claim=False, wrong_basin=False)
    texts = dict.fromkeys(
        ("experiment", "solver", "verdict", "initial_guess", "outcome"), "category"
    )

    alike(of(rows), of(rows.astype(texts)))


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
many = arrays.arrays(np.float64, st.integers(0, 60), elements=finite | st.just(np.inf))


@given(many, st.lists(st.integers(0, 60), max_size=4), st.sampled_from([4, 2**16]))
def test_spreads_merge_to_the_whole_even_where_they_are_cut(values, cuts, most):
    """Any splits; exact up to so many different values, and within `ERROR` beyond."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(spread, "MOST_EXACT", most)
        parts = [Spread.of(part) for part in np.split(values, sorted(cuts))]
        whole = Spread.of(values)
        same_spread(whole, Spread.merged(parts))
        same_spread(whole, Spread.merged(parts[::-1]))
        nested = Spread.merged([Spread.merged(parts[:2]), *parts[2:]])
        same_spread(whole, nested)

    assert whole.cut == (np.unique(values).size > most)
    assert whole.size == values.size
    if not values.size:
        assert np.isnan([whole.median, whole.upper(0.5), whole.largest]).all()
        return
    ordered = np.sort(values)
    assert (whole.least, whole.largest) == (ordered[0], ordered[-1])
    assert whole.finite == np.isfinite(values).sum()
    for q in (0.0, 0.3, 0.5, 0.9, 1.0):
        exact = ordered[max(0, int(np.ceil(q * values.size - 1e-9)) - 1)]
        assert whole.upper(q) == (exact if not whole.cut else pytest.approx(exact, rel=ERROR))


def test_cut_values_keep_what_is_counted():
    """A million values: few are kept, and shares are right to the last attempt."""
    values = np.random.default_rng(0).lognormal(-20, 5, 10**6)
    found = Spread.merged([Spread.of(part) for part in np.split(values, 10)])
    within, share = found.shares()

    assert found.cut
    assert within.size < 2**17 * 2
    assert share[-1] == 1.0
    assert found.median == pytest.approx(np.median(values), rel=2 * ERROR)
    at = within[within.size // 2]
    assert share[within.size // 2] == pytest.approx((values <= at).mean(), abs=1e-3)
