"""The section that compares methods: profiles, means and ranks, tests, spread."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, Table
from dubins_study.report.elements.formats import count, seconds, sentences, share, some
from dubins_study.report.elements.identity import best_first, with_interval
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.topic import BENCHMARK, Topic
from dubins_study.report.statistics.compared import Compared, compared
from dubins_study.report.statistics.costs import shared_questions
from dubins_study.report.statistics.metrics import question_spread, solver_spread
from dubins_study.report.topics.comparison.numbers import best_of_formulations, mean_ranks, times
from dubins_study.report.topics.comparison.paired import engine_tests, formulation_tests
from dubins_study.report.topics.comparison.pictures import pictures
from dubins_study.report.topics.comparison.tables import (
    rank_table,
    spread_table,
    test_table,
)


def comparison_section(results: Results) -> Section | None:
    """Profiles, means and ranks, paired tests, and spread over repeats."""
    attempts = compared(results)
    if attempts is None:
        return None
    table = times(attempts)
    shared = shared_questions(table)
    if shared.empty or len(shared.columns) < 2:
        return None
    ranked, shift, common = mean_ranks(attempts)
    palette = Palette.of_page(results)
    blocks: list[Picture | Table] = [*pictures(attempts, table, ranked, palette)]
    ranks = rank_table(ranked, shift, common, attempts.limit_s)
    best = set(best_of_formulations(ranked).index)
    which = "Of each formulation the method with the least mean."
    blocks += best_first(ranks, ranked.index, best, which)
    engines, formulations = engine_tests(table, ranked), formulation_tests(table, ranked)
    if len(engines):
        blocks.append(test_table(engines, ranked, "formulation"))
    if len(formulations):
        blocks.append(test_table(formulations, ranked, "engine"))
    repeats = spread(attempts)
    if len(repeats):
        blocks.append(spread_table(repeats, attempts.methods))
    text = sentences(
        f"{count(len(shared))} questions with a path, put to {count(len(shared.columns))} methods; "
        "failures stay in every denominator. The closed form is left out.",
        _first(ranked),
        _unranked(ranked),
        _left_out(attempts, table),
    )
    lead = (
        "See in the profiles which method is fast (high at the left) and which is right at all "
        "(high at the right)."
    )
    return Section("comparison", "Comparison of methods", text, tuple(blocks), lead)


def _first(ranked: pd.DataFrame) -> str:
    first = ranked.to_dict("records")[0]
    mean = with_interval(seconds, first["mean"], first["mean_low"], first["mean_high"])
    right = with_interval(share, first["right"], first["right_low"], first["right_high"])
    return f"The least mean time has {first['name']}: {mean}, right on {right} of the questions."


def _unranked(ranked: pd.DataFrame) -> str:
    unranked = int(ranked["rank"].isna().sum())
    if not unranked:
        return "Every rank stays at any shift and penalty tried."
    return (
        f"{count(unranked)} of {count(len(ranked))} methods have no rank: it changes with the "
        "shift or with the penalty for failures."
    )


def _left_out(attempts: Compared, table: pd.DataFrame) -> str:
    left_out = sum(solver not in table for solver in attempts.engines.index)
    if not left_out:
        return ""
    return (
        f"{some(left_out, 'method')} that met less than nine tenths of the questions, or whose "
        "right answers have no time, take no part."
    )


def spread(attempts: Compared) -> pd.DataFrame:
    """Spread over repeats at questions with a path, by solver, those that change most first."""
    rows = attempts.answerable
    rows = rows[rows["solver"].isin(attempts.engines.index)]
    if not len(rows) or rows["repeat"].nunique() < 2:
        return pd.DataFrame()
    frame = solver_spread(question_spread(rows, question=["question"]))
    return frame.sort_values(["changing", "cv"], ascending=False, kind="stable")


TOPIC = Topic("the comparison of methods", comparison_section, BENCHMARK)
