"""The comparison's pictures: which methods and points they show."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dubins_study.report.elements.content import Picture
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette
from dubins_study.report.statistics.compared import Compared
from dubins_study.report.statistics.cost_table import shared_questions
from dubins_study.report.statistics.profiles import (
    data_profile,
    pairwise_profile,
    performance_profile,
    performance_ratios,
    target_ecdf,
)
from dubins_study.report.topics.comparison.figures import (
    factors_up_to,
    method_looks,
    plot_profiles,
    plot_wide,
)
from dubins_study.report.topics.comparison.numbers import best_of_formulations, evaluations
from dubins_study.study.path import FloatArray

# Curves of a panel: more cannot be told apart.
_MOST, _MOST_WIDE = 8, 10


def pictures(attempts: Compared, table: pd.DataFrame, ranked: pd.DataFrame) -> Iterator[Picture]:
    """Profiles by formulation, of the best two, in evaluations, and gap targets over time."""
    if (ranked["formulation"].value_counts() > 1).any():
        yield _profiles(table, ranked)
    yield _pair(table, ranked)
    counted = ranked[ranked.index.isin(evaluations(attempts).columns)]
    if len(counted):
        yield _evaluations(attempts, best_of_formulations(counted)[:_MOST_WIDE])
    yield _targets(attempts, best_of_formulations(ranked)[:_MOST_WIDE])


def _profiles(table: pd.DataFrame, ranked: pd.DataFrame) -> Picture:
    profiles, left_out = {}, 0
    shared = shared_questions(table)
    order = ranked["formulation"].reindex(table.columns)
    for name in order.dropna().unique():
        group = ranked[ranked["formulation"] == name]
        if len(group) < 2:
            continue
        chosen = [solver for solver in table if solver in set(group.index[:_MOST])]
        left_out += len(group) - len(chosen)
        ratios = performance_ratios(shared[list(group.index)]).to_numpy()
        largest = np.max(ratios[np.isfinite(ratios)], initial=1.0)
        every = performance_profile(shared[list(group.index)], factors_up_to(float(largest)))
        profiles[name] = every[chosen]
    palette = Palette.of(ranked["engine"])
    rest = f" The {_MOST} with the least means in each; {count(left_out)} more are left out."
    caption = (
        "Performance profiles, formulation by formulation: the share of questions answered "
        "correctly within a factor of the formulation's fastest right answer (Dolan and Moré). At "
        "the left: how often a method is the fastest; at the right: how often it is right at all. "
        "Read only the highest curve as best. Formulations with a single method are in the "
        f"figures below.{rest if left_out else ''}"
    )
    figure = plot_profiles(profiles, ranked, palette)
    alt = "Performance profiles in small panels, one per formulation"
    return Picture("comparison-profiles", caption, figure, alt)


def _pair(table: pd.DataFrame, ranked: pd.DataFrame) -> Picture:
    first, second = (str(solver) for solver in ranked.index[:2])
    ratios = performance_ratios(table[[first, second]]).to_numpy()
    largest = float(np.max(ratios[np.isfinite(ratios)], initial=1.0))
    profile = pairwise_profile(table, first, second, factors_up_to(largest))
    methods = ranked.loc[[first, second]]
    looks = method_looks(methods, "engine", Palette.of(ranked["engine"]))
    caption = (
        "The two methods with the least mean times, alone: a third method cannot change this "
        "profile, and the higher curve at a factor is the better one there."
    )
    figure = plot_wide(
        profile,
        looks,
        _labels(methods),
        "time / time of the faster right answer",
        "share of questions",
    )
    return Picture("comparison-pair", caption, figure, "Pairwise performance profile")


def _evaluations(attempts: Compared, best: pd.DataFrame) -> Picture:
    table = evaluations(attempts)[list(best.index)]
    shares = data_profile(table, 0.0, _points(table))
    caption = (
        "Data profile: the share of questions that a method answers correctly within a number of "
        "function evaluations, restarts and all subproblems included; the best method of each "
        "formulation whose engine counts them. One evaluation costs more in some formulations "
        "than in others."
    )
    looks = method_looks(best, "formulation", Palette.of(attempts.engines["formulation"]))
    figure = plot_wide(shares, looks, _labels(best), "function evaluations", "share of questions")
    return Picture("comparison-evaluations", caption, figure, "Data profiles in evaluations")


def _targets(attempts: Compared, best: pd.DataFrame) -> Picture:
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
    looks = method_looks(best, "formulation", Palette.of(attempts.engines["formulation"]))
    figure = plot_wide(
        shares, looks, _labels(best), "time of an attempt", "share of (question, target)"
    )
    return Picture("comparison-targets", caption, figure, "Shares of gap targets over time")


def _points(table: pd.DataFrame) -> FloatArray:
    """Points of a logarithmic axis over the finite values of a table."""
    values = table.to_numpy(dtype=np.float64)
    finite = values[np.isfinite(values) & (values > 0)]
    low, high = (finite.min(), finite.max()) if finite.size else (1.0, 10.0)
    return np.geomspace(low, max(1.2 * high, 2 * low), 160)


def _labels(methods: pd.DataFrame) -> pd.Series[str]:
    """Short names for a legend that holds several formulations."""
    return methods["formulation"] + ":\n" + methods["short"]
