"""Findings about engines and their cost."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.elements.formats import digits, some
from dubins_study.report.topics.comparison.paired import engine_tests, separated
from dubins_study.report.topics.cost import presolve_pairs
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.finding import TIMES, Finding
from dubins_study.report.topics.findings.formulation import RANKS

STOCHASTIC = "penalty"
_RIGHT_ENOUGH = 0.9


def slowest_engine(evidence: Evidence) -> Finding | None:
    """Within one formulation, the slowest against the fastest engine that is right everywhere."""
    alike = ["formulation", "guess", "settings"]  # else the presolve would count as an engine's
    groups = [
        (name, group.drop_duplicates("engine"))
        for (name, *_), group in evidence.reliable.groupby(alike)
    ]
    groups = [(name, group) for name, group in groups if len(group) > 1]
    if not groups:
        return None
    name, group = max(groups, key=lambda pair: len(pair[1]))
    medians = evidence.times[list(group.index)].median()
    fastest, slowest = str(medians.idxmin()), str(medians.idxmax())
    ratio = evidence.time_ratio(slowest, fastest)
    if ratio is None or not ratio.low > 1:
        return None
    return Finding(
        f"Choose the engine for its speed once the formulation is good: of {len(group)} engines "
        f"that are right on at least 99 % of the questions with {name}, "
        f"{group['engine'][slowest]} takes {ratio.text()} times the median time of "
        f"{group['engine'][fastest]}.",
        ratio,
        TIMES,
        f"{evidence.medians_of(slowest, fastest)}; {name}, one guess, the same settings",
        RANKS,
    )


def presolve(evidence: Evidence) -> Finding | None:
    """What dropping words by geometry divides the evaluations by."""
    table = evidence.evaluations.replace(np.inf, np.nan)
    pairs = [p for p in presolve_pairs(evidence.methods) if set(p) <= set(table.columns)]
    if not pairs:
        return None
    off, on = [a for a, _ in pairs], [b for _, b in pairs]
    ratios = table[off].to_numpy() / table[on].to_numpy()
    factor = evidence.median_of(pd.DataFrame(ratios, table.index).median(axis=1))
    if factor is None or not factor.excludes(1):
        return None
    question = (
        f"{some(factor.questions, 'question')} with a path, {some(len(pairs), 'method')} with and "
        "without it"
    )
    if factor.value > 1:
        sentence = (
            "Drop the words that geometry excludes before any engine is called: that divides the "
            f"function evaluations of a question by {factor.text()} in the median."
        )
    else:
        factor = factor.inverse()
        sentence = (
            "Do not drop words by geometry: that multiplies the function evaluations of "
            f"a question by {factor.text()} in the median."
        )
    return Finding(sentence, factor, TIMES, question, "Cost where it arises: the presolve")


def derivative_free_search(evidence: Evidence) -> Finding | None:
    """The most reliable search without derivatives against the best of other formulations."""
    ranked = evidence.ranked
    on_penalty = ranked["formulation"] == STOCHASTIC
    if on_penalty.all() or not on_penalty.any():
        return None
    solver, rival = str(ranked["right"][on_penalty].idxmax()), str(ranked.index[~on_penalty][0])
    ratio, right = evidence.time_ratio(solver, rival), evidence.share_of(evidence.rates[solver])
    if ratio is None or right is None or not ratio.excludes(1):
        return None
    advice = "Keep search without derivatives for problems that have none"
    if ratio.value < 1:
        advice = "Try search without derivatives first"
    return Finding(
        f"{advice}: the most reliable of it, {evidence.name(solver)}, is right on "
        f"{right.percent_text()} of the questions, and takes {ratio.text()} times the median time "
        f"of {evidence.name(rival)} where both are right.",
        ratio,
        TIMES,
        f"{some(right.questions, 'question')} with a path; {evidence.medians_of(solver, rival)}; "
        f"{some(int(on_penalty.sum()), 'method')} on the penalty",
        RANKS,
    )


def no_rank(evidence: Evidence) -> Finding | None:
    """Two methods of one formulation, right nearly everywhere, that the tests do not separate."""
    ranked = evidence.ranked[evidence.ranked["right"] >= _RIGHT_ENOUGH]
    if len(ranked) < 2:
        return None
    tests = engine_tests(evidence.times, ranked)
    if tests.empty:
        return None
    ties = [
        (abs(np.log(ratio.value)), ratio, line)
        for line in tests[~separated(tests) & tests["p"].notna()].to_dict("records")
        if ranked["engine"][line["solver"]] != ranked["engine"][line["rival"]]
        and (ratio := evidence.time_ratio(str(line["rival"]), str(line["solver"]))) is not None
        and not ratio.excludes(1)
    ]
    if not ties:
        return None
    _, ratio, line = min(ties, key=lambda tie: tie[0])
    end = f" on {line['shared']}"
    names = [evidence.name(str(line[key])).removesuffix(end) for key in ("solver", "rival")]
    return Finding(
        f"Do not conclude a rank between {' and '.join(names)}{end}: the ratio of their median "
        f"times is {ratio.text()}, and the paired test does not separate them "
        f"(p = {digits(2)(line['p_holm'])}). Undecided like that: {len(ties)} of "
        f"{some(len(tests), 'pair')}.",
        ratio,
        TIMES,
        f"{some(ratio.questions, 'question')} that both answer; Wilcoxon's test with Holm's "
        f"correction for {some(len(tests), 'pair')}",
        "Comparison of methods: paired tests",
    )
