"""The comparison's pictures: which methods and points they show."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dubins_study.report.elements.content import Picture
from dubins_study.report.elements.formats import sentences, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.statistics.compared import Compared
from dubins_study.report.statistics.costs import (
    performance_profile,
    performance_ratios,
    shared_questions,
    shares_within,
    target_ecdf,
)
from dubins_study.report.statistics.methods import MOST_ENGINES, foremost
from dubins_study.report.topics.comparison.figures import (
    factors_up_to,
    plot_profiles,
    plot_wide,
)
from dubins_study.report.topics.comparison.numbers import best_of_formulations, evaluations
from dubins_study.study.path import FloatArray

# Curves with a colour and a name in a panel: more cannot be told apart.
_MOST = 8


def pictures(
    attempts: Compared, table: pd.DataFrame, ranked: pd.DataFrame, palette: Palette
) -> Iterator[Picture]:
    """Profiles by formulation, in evaluations, and gap targets over time."""
    if (ranked["formulation"].value_counts() > 1).any():
        yield _profiles(table, ranked, palette)
    counted = ranked[ranked.index.isin(evaluations(attempts).columns)]
    if len(counted):
        yield _evaluations(attempts, best_of_formulations(counted)[:MOST_ENGINES], palette)
    yield _targets(attempts, best_of_formulations(ranked)[:MOST_ENGINES], palette)


def _profiles(table: pd.DataFrame, ranked: pd.DataFrame, palette: Palette) -> Picture:
    profiles, named = {}, {}
    shared = shared_questions(table)
    order = ranked["formulation"].reindex(table.columns)
    for name in order.dropna().unique():
        group = list(ranked.index[ranked["formulation"] == name])
        if len(group) < 2:
            continue
        best = pd.concat([ranked["mean"][group].rank(), -ranked["right"][group]], axis=1)
        named[name] = foremost(-best.rank(method="first").min(axis=1), _MOST)
        ratios = performance_ratios(shared[group]).to_numpy()
        largest = np.max(ratios[np.isfinite(ratios)], initial=1.0)
        profiles[name] = performance_profile(shared[group], factors_up_to(float(largest)))
    grey = sum(len(profile.columns) - len(named[name]) for name, profile in profiles.items())
    caption = sentences(
        "Performance profiles, formulation by formulation: the share of questions answered "
        "correctly within a factor of the formulation's fastest right answer (Dolan and Moré). At "
        "the left: how often a method is the fastest; at the right: how often it is right at all. "
        "Read only the highest curve as best. Formulations with a single method are in the "
        "figures below.",
        f"Named: in each the {_MOST} with the least means or most often right; grey: "
        f"{some(grey, 'method')} more."
        if grey
        else "",
    )
    figure = plot_profiles(profiles, named, ranked, palette)
    alt = "Performance profiles in small panels, one per formulation"
    return Picture("comparison-profiles", caption, figure, alt)


def _evaluations(attempts: Compared, best: pd.DataFrame, palette: Palette) -> Picture:
    table = evaluations(attempts)[list(best.index)]
    shares = shares_within(table, _points(table))
    caption = (
        "Data profile: the share of questions that a method answers correctly within a number of "
        "function evaluations, restarts and all subproblems included; the best method of each "
        "formulation whose engine counts them. One evaluation costs more in some formulations "
        "than in others."
    )
    figure = plot_wide(shares, palette, "function evaluations")
    return Picture("comparison-evaluations", caption, figure, "Data profiles in evaluations")


def _targets(attempts: Compared, best: pd.DataFrame, palette: Palette) -> Picture:
    rows = attempts.answerable
    rows = rows[rows["solver"].isin(best.index)]
    groups = rows.groupby(["question", "solver"])
    # The worst gap of the repeats, so that a target is reached only if all repeats reach it.
    gaps = rows.assign(gap=rows["gap"].fillna(np.inf).clip(lower=0.0))
    worst = gaps.groupby(["question", "solver"])["gap"].max().unstack()[list(best.index)]
    paid = groups["wall_s"].median().unstack().reindex_like(worst)
    paid = paid.mask(paid.isna() & worst.notna(), attempts.limit_s)
    shares = target_ecdf(worst, paid, _points(paid))
    caption = (
        "Runtime distribution as COCO draws it: the share of pairs of a question and a gap target "
        "(41 targets from 1 to 1e-8, five to a decade) that the best method of each formulation "
        "reaches within a time. A run's time counts for all targets that its answer reaches, the "
        "worst of its repeats. A curve that ends below 100 % belongs to a method whose answers "
        "stay too coarse, or do not arrive."
    )
    figure = plot_wide(shares, palette, "time of an attempt", "share of (question, target)")
    return Picture("comparison-targets", caption, figure, "Shares of gap targets over time")


def _points(table: pd.DataFrame) -> FloatArray:
    """Points of a logarithmic axis over the finite values of a table."""
    values = table.to_numpy(dtype=np.float64)
    finite = values[np.isfinite(values) & (values > 0)]
    low, high = (finite.min(), finite.max()) if finite.size else (1.0, 10.0)
    return np.geomspace(low, max(1.2 * high, 2 * low), 160)
