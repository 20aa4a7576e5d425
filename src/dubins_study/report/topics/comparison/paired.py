"""Paired tests of methods that share a formulation or an engine."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.statistics.paired import holm, pairwise_tests

LEVEL = 0.05


def engine_tests(table: pd.DataFrame, ranked: pd.DataFrame) -> pd.DataFrame:
    """Within each formulation: its best method against every other, by Wilcoxon's signed ranks.

    Args:
        table: a cost table in seconds.
        ranked: from `numbers.mean_ranks`.
    Returns:
        One row per pair: shared (the formulation), solver (the best by the mean), rival, pairs,
        wins, losses, ties, p, p_holm (Holm's, over all rows).
    """
    parts = []
    for formulation, group in ranked.groupby("formulation", sort=False):
        if len(group) > 1:
            tests = pairwise_tests(table[list(group.index)], base=str(group.index[0]))
            parts.append(tests.assign(shared=formulation))
    return _together(parts)


def formulation_tests(table: pd.DataFrame, ranked: pd.DataFrame) -> pd.DataFrame:
    """For each engine: its best method of each formulation, all pairs. As `engine_tests`."""
    parts = []
    for engine, group in ranked.groupby("engine", sort=False):
        best = group.drop_duplicates("formulation")
        if len(best) > 1:
            parts.append(pairwise_tests(table[list(best.index)]).assign(shared=engine))
    return _together(parts)


def _together(parts: list[pd.DataFrame]) -> pd.DataFrame:
    if not parts:
        return pd.DataFrame(columns=["shared", "solver", "rival", "p_holm"])
    frame = pd.concat(parts, ignore_index=True)
    return frame.assign(p_holm=holm(frame["p"]))


def separated(tests: pd.DataFrame) -> pd.Series[bool]:
    """Whether each pair differs by more than chance, all tests of the table together."""
    return tests["p_holm"] <= LEVEL
