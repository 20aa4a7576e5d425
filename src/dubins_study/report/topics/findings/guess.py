"""Findings about initial guesses and repeats."""

from __future__ import annotations

from dubins_study.report.elements.formats import digits, some
from dubins_study.report.statistics.metrics import question_spread, solver_spread
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.finding import (
    ENOUGH,
    PERCENT,
    POINTS,
    Estimate,
    Finding,
    percent,
)
from dubins_study.report.topics.findings.formulation import MATRIX

_SAME = ["formulation", "engine"]


def zero_start(evidence: Evidence) -> Finding | None:
    """The guess along the bearing against the zero point: same engine, same formulation."""
    pairs = evidence.pairs(_SAME, "guess", "bearing", "zero")
    points = evidence.rate_difference(pairs)
    if points is None or not points.excludes(0):
        return None
    better, worse = "the bearing of the target", "the zero point"
    if points.value < 0:
        points, better, worse = points.negated(), worse, better
    return Finding(
        f"Start from {better}: from {worse} the same engines on the same formulations are right on "
        f"{points.text()} percentage points fewer of the questions.",
        points,
        POINTS,
        f"{some(points.questions, 'question')} with a path, {some(len(pairs), 'method')}, in pairs",
        MATRIX,
    )


def random_restarts(evidence: Evidence) -> Finding | None:
    """Random guesses against the one along the bearing, and the time that they take."""
    pairs = evidence.pairs(_SAME, "guess", "random", "bearing")
    points = evidence.rate_difference(pairs)
    if points is None or not points.excludes(0):
        return None
    ratios = [(ratio, pair) for pair in pairs if (ratio := evidence.time_ratio(*pair)) is not None]
    cost = medians = ""
    if ratios:
        dearest, pair = max(ratios)
        cost = f", for up to {dearest.text(digits(2))} times the median time"
        medians = f"; time of {evidence.medians_of(*pair)}"
    if points.value > 0:
        advice, what = "Try several random guesses where the model is joint", "more"
    else:
        points, advice, what = points.negated(), "Do not rely on random guesses", "fewer"
    methods = some(len(pairs), "method")
    return Finding(
        f"{advice}: with the same engine and formulation they are right on {points.text()} "
        f"percentage points {what} of the questions than the guess along the bearing{cost}.",
        points,
        POINTS,
        f"{some(points.questions, 'question')} with a path, {methods}, in pairs{medians}",
        MATRIX,
    )


def repeats(evidence: Evidence) -> Finding | None:
    """The method whose verdict changes most often from repeat to repeat."""
    rows = evidence.compared.answerable
    rows = rows[rows["solver"].isin(evidence.methods.index)]
    if rows.empty or rows["repeat"].nunique() < 2:
        return None
    spread = solver_spread(question_spread(rows, question=["question"]))
    spread = spread[(spread["questions"] >= ENOUGH) & (spread["changing"] > 0)]
    if spread.empty:
        return None
    line = spread.sort_values("changing", ascending=False, kind="stable").iloc[:1]
    solver, values = str(line.index[0]), line.to_dict("records")[0]
    ends = (float(values[name]) for name in ("changing", "changing_low", "changing_high"))
    value, low, high = ends
    change = percent(Estimate(value, low, high, int(values["questions"])))
    return Finding(
        f"Run {evidence.name(solver)} more than once: on {change.percent_text()} of the questions "
        f"its verdict changes from repeat to repeat. {some(len(spread), 'method')} of "
        f"{rows['solver'].nunique()} change at all.",
        change,
        PERCENT,
        f"{some(change.questions, 'question')} with a path, {int(values['repeats'])} repeats each",
        "Comparison of methods: spread over repeats",
    )
