"""The virtual best solver against leaving each solver out in turn."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.report.statistics.means import par
from dubins_study.report.statistics.virtual_best import contributions, virtual_best

INF, NAN = float("inf"), float("nan")
cost = st.one_of(st.integers(1, 8).map(float), st.just(INF))
tables = st.integers(1, 4).flatmap(
    lambda solvers: st.lists(
        st.lists(cost, min_size=solvers, max_size=solvers), min_size=1, max_size=8
    ).map(lambda rows: pd.DataFrame(rows, columns=list("abcd"[:solvers])))
)


def test_contributions_by_hand():
    """a is the cheapest of question 1 and ties at 2; only b answers 3; nobody answers 4; c is
    always second or worse. Without a question 1 costs 3 instead of 1, without b question 3 costs
    twice the limit 10 instead of 5: over four questions."""
    table = pd.DataFrame(
        {"a": [1.0, 2.0, INF, INF], "b": [4.0, 2.0, 5.0, INF], "c": [3.0, 9.0, INF, INF]}
    )
    frame = contributions(table, 10.0)

    assert virtual_best(table).tolist() == [1.0, 2.0, 5.0, INF]
    assert frame["best"].tolist() == [1.5 / 4, 1.5 / 4, 0.0]
    assert frame["alone"].tolist() == [0.0, 0.25, 0.0]
    assert frame["cost_added"].tolist() == [2 / 4, 15 / 4, 0.0]


@given(tables, st.sampled_from([1.0, 2.0, 10.0]))
def test_a_contribution_is_what_is_missing_without_the_solver(table, factor):
    """Xu et al. 2012: the virtual best without a solver against that of all, both computed from
    their tables, in mean penalised cost and in questions answered."""
    limit, frame = 6.0, contributions(table, 6.0, factor)
    everyone = virtual_best(table)

    for solver in table:
        rest = table.drop(columns=solver)
        without = virtual_best(rest) if len(rest.columns) else everyone.clip(lower=INF)
        with_all, with_rest = (par(v.to_frame(), limit, factor).item() for v in (everyone, without))
        assert frame.loc[solver, "cost_added"] == pytest.approx(with_rest - with_all, abs=1e-12)
        lost = (everyone <= limit).mean() - (without <= limit).mean()
        assert frame.loc[solver, "alone"] == pytest.approx(lost)
    assert frame["best"].sum() == pytest.approx((everyone <= limit).mean())


@given(tables)
def test_two_equal_solvers_add_nothing(table):
    """Either replaces the other, and they share what they are the best at."""
    frame = contributions(table.assign(twin=table["a"]), 9.0)

    assert frame.loc[["a", "twin"], ["alone", "cost_added"]].to_numpy().tolist() == [[0, 0], [0, 0]]
    assert frame.loc["a", "best"] == frame.loc["twin", "best"]


def test_edges():
    """One solver is worth what failing everywhere would cost; all failures are worth nothing; a
    question that was not put to all counts for nobody; without questions there is no share."""
    alone = contributions(pd.DataFrame({"a": [1.0, INF]}), 10.0).loc["a"]
    failures = contributions(pd.DataFrame({"a": [INF], "b": [INF]}), 10.0)
    partly = contributions(pd.DataFrame({"a": [1.0, 3.0], "b": [2.0, NAN]}), 10.0)

    assert alone.tolist() == [0.5, 0.5, 19 / 2]
    assert (failures == 0).all(axis=None)
    assert partly.loc["a"].tolist() == [1.0, 0.0, 1.0]
    empty = contributions(pd.DataFrame({"a": [], "b": []}), 10.0)
    assert empty.isna().all(axis=None)
    assert empty.columns.tolist() == ["best", "alone", "cost_added"]
    with pytest.raises(ValueError, match="limit of nan"):
        contributions(pd.DataFrame({"a": [1.0]}), np.nan)
