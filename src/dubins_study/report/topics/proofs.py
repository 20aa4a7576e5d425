"""Proofs of routes by branch and bound.

A table has the share that each solver closes within each limit, and the gap that it leaves open.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import TRIAL, is_true, legs_of
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns
from dubins_study.report.elements.content import Section, Table, Topic
from dubins_study.report.elements.formats import seconds, share
from dubins_study.report.elements.identity import with_share
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.metrics import upper_quantile
from dubins_study.study.words import Claim

_PROVING = "disjunction"  # the formulation of routes whose engines prove a bound


def by_limit(rows: pd.DataFrame) -> pd.DataFrame:
    """Shares closed and gaps of bounds by limit.

    One row per solver, number of legs and time limit. Columns: solver, legs, limit_s; those of
    `with_share` for closed (the solver proves in time that its path is shortest, and it is);
    bound_gap (median of how far the solver's bound lies below the shortest length, relative to
    that; 1 without a bound); wall_s (median time, s).
    """
    high = rows["reference_high"]
    below = ((high - rows["lower_bound"]) / high).clip(lower=0.0).fillna(1.0)
    closed = rows["claim"].eq(Claim.OPTIMAL) & rows["verdict"].eq("optimal")
    counted = rows.assign(
        legs=legs_of(rows), closed=closed & ~is_true(rows["late"]), bound_gap=below
    )
    cell = ["solver", "legs", "limit_s"]
    medians = counted.groupby(cell)[["bound_gap", "wall_s"]].agg(upper_quantile, q=0.5)
    shares = scenario_shares(counted, by=cell, success="closed", scenario=TRIAL)
    return with_share(medians, "closed", shares["successes"], shares["trials"]).reset_index()


def proofs_section(results: Results) -> Section | None:
    """The section on proofs of routes."""
    rows = results.rows
    rows = rows[rows["formulation"].eq(_PROVING) & rows["limit_s"].notna()]
    if rows.empty:
        return None
    shown = (
        SOLVER,
        *columns(legs="legs"),
        *columns(seconds, limit_s="limit"),
        Column("closed_text", "closed", kind="cell"),
        *columns(share, bound_gap="gap of bound"),
        *columns(seconds, wall_s="median time"),
    )
    caption = (
        "Closed: the solver proves within the limit that its path is shortest, and it is. Gap of "
        "bound: the median gap between the last bound and the shortest length."
    )
    table = Table("proofs", caption, by_limit(rows), shown)
    text = (
        "A proof takes longer than a local search, so its limit is longer too. The same solver "
        "with another limit is another row."
    )
    lead = "See up to how many legs branch and bound proves a route, and how fast."
    return Section("proofs", "Proofs of routes by limit", text, (table,), lead)


TOPIC = Topic("proofs of routes", proofs_section, "routes")
