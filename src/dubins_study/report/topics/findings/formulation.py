"""Findings about formulations: which to choose, and what a choice loses."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.formats import digits, some
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.finding import (
    PERCENT,
    POINTS,
    TIMES,
    Estimate,
    Finding,
    percent,
)

WORDS, JOINT = "one NLP a word", "joint NLP, both orders"
ORDERS = ("joint NLP, LRS", "joint NLP, RLS")
TRANSCRIPTIONS = ("turn rates", "Radau collocation", "multiple shooting")
RANKS = "Comparison of methods: means and ranks"
MATRIX = "Formulation by engine"
STRATA = "Formulation by engine: strata"
# The check cannot tell a smaller gap from the miss that it allows.
_RESOLVED = 1e-6


def fastest_formulation(evidence: Evidence) -> Finding | None:
    """The formulation whose best method is right everywhere and the fastest."""
    best = evidence.reliable.drop_duplicates("formulation")
    if len(best) < 2:
        return None
    first, second = map(str, best.index[:2])
    ratio = evidence.time_ratio(second, first)
    if ratio is None or not ratio.low > 1:
        return None
    right = evidence.share_of(evidence.rates[first])
    share = "" if right is None else right.percent_text()
    return Finding(
        f"Where no closed form serves, take {evidence.name(first)}: it is right on {share} of the "
        f"questions, and the best method of another formulation, {evidence.name(second)}, takes "
        f"{ratio.text()} times its median time.",
        ratio,
        TIMES,
        f"{evidence.medians_of(second, first)}; the best method of each of {len(best)} "
        "formulations that are right on at least 99 %",
        RANKS,
    )


def words_against_joint(evidence: Evidence) -> Finding | None:
    """One problem a word against the joint model in both orders: same engine, same guess."""
    pairs = evidence.pairs(["engine", "guess"], "formulation", WORDS, JOINT)
    points = evidence.rate_difference(pairs)
    if points is None or not points.excludes(0):
        return None
    better, worse = "one problem a word", "the joint model in both orders"
    if points.value < 0:
        points, better, worse = points.negated(), worse, better
    return Finding(
        f"Pose {better}: with the same engine and guess it is right on {points.text()} percentage "
        f"points more of the questions than {worse}.",
        points,
        POINTS,
        _asked(points, len(pairs), "engine"),
        MATRIX,
    )


def single_order(evidence: Evidence) -> Finding | None:
    """What one order of the joint model loses against both, in the region where it loses most.

    Engines and guesses together, those that met few questions too: a question is answered if any
    attempt of any method of the formulation is right.
    """
    answered = _by_formulation(evidence, evidence.rates, "max")
    if JOINT not in answered:
        return None
    rows = evidence.compared.answerable.drop_duplicates("question").set_index("question")
    regions = rows["region"].reindex(answered.index)
    worst: list[tuple[Estimate, str, str]] = []
    for order in ORDERS:
        if order not in answered:
            continue
        lost = (answered[order] == 0).astype(float)[answered[JOINT] == 1]
        shares = [(evidence.share_of(here), str(where)) for where, here in lost.groupby(regions)]
        known = [(share, order, where) for share, where in shares if share and share.value > 0]
        worst += [max(known)] if known else []
    if not worst:
        return None
    (share, order, region), *other = sorted(worst, reverse=True)
    more = "".join(
        f"; with {name[-3:]} alone, {each.percent_text()} {_where(place)}"
        for each, name, place in other
    )
    return Finding(
        f"Pose both orders: where the target lies {_where(region)}, {share.percent_text()} of the "
        "questions that both orders answer are answered by no engine with the order "
        f"{order[-3:]} alone{more}.{_longer(evidence, order, regions == region)}",
        share,
        PERCENT,
        f"{some(share.questions, 'question')} {_where(region)}; all attempts of all engines",
        STRATA,
    )


def _where(region: str) -> str:
    return _WHERE.get(region, f"in the {region}")


_WHERE = {"circle": "on a turning circle", "outside": "outside the turning circles"}


def _longer(evidence: Evidence, order: str, here: pd.Series[bool]) -> str:
    """A sentence on the length of the paths that one order yields; empty if few arrive."""
    least = _by_formulation(evidence, evidence.gaps, "min")
    loss = evidence.mean_of((least[order] - least[JOINT])[here.reindex(least.index)])
    if loss is None or not loss.low > _RESOLVED:
        return ""
    text = percent(loss).percent_text()
    return f" Where a path arrives, it is {text} longer on average."


def _by_formulation(evidence: Evidence, table: pd.DataFrame, best: str) -> pd.DataFrame:
    """The best value of any method: questions by formulations."""
    values = table[[solver for solver in table if solver in evidence.methods.index]]
    formulation = evidence.methods["formulation"].reindex(values.columns)
    return values.T.groupby(formulation).agg(best).T


def coarse_transcription(evidence: Evidence) -> Finding | None:
    """How often direct transcription is too coarse: right turns, but a path that is longer."""
    best = evidence.ranked.drop_duplicates("formulation").reset_index().set_index("formulation")
    if WORDS not in best.index:
        return None
    words = evidence.share_of(evidence.coarse[best["solver"][WORDS]])
    shares: list[tuple[Estimate, str]] = []
    for name in TRANSCRIPTIONS:
        if name in best.index and words is not None:
            coarse = evidence.share_of(evidence.coarse[best["solver"][name]])
            if coarse is not None and coarse.low > words.high:
                shares.append((coarse, str(best["solver"][name])))
    if words is None or not shares:
        return None
    coarse, solver = max(shares)
    return Finding(
        "Do not expect the shortest length from direct transcription: on "
        f"{coarse.percent_text()} of the questions the path of {evidence.name(solver)} turns as "
        "the shortest one and is yet longer than the check allows; for the best method with "
        f"{WORDS} that is {words.percent_text()}.",
        coarse,
        PERCENT,
        f"{some(coarse.questions, 'question')} with a path; the best method of each formulation",
        "Comparison of methods: gap targets over time",
    )


def near_circles(evidence: Evidence) -> Finding | None:
    """The method that loses most next to a turning circle."""
    rows = evidence.compared.answerable.drop_duplicates("question").set_index("question")
    margin = rows["margin"].abs().reindex(evidence.rates.index)
    groups = evidence.rates[margin <= _NEAR], evidence.rates[margin >= _AWAY]
    losses: list[tuple[float, str, Estimate, Estimate]] = []
    asked = [solver for solver in evidence.rates if solver in evidence.usual.index]
    for solver in asked:
        near, away = (evidence.share_of(group[solver]) for group in groups)
        if near is not None and away is not None and near.high < away.low:
            losses.append((away.value - near.value, str(solver), near, away))
    if not losses:
        return None
    _, solver, near, away = max(losses)
    return Finding(
        f"Distrust {evidence.name(solver)} next to a turning circle: within "
        f"{digits(1)(_NEAR)} radii of one it is right on {near.percent_text()} of the questions, "
        f"elsewhere on {away.percent_text()}. Of "
        f"{some(len(asked), 'method')} {len(losses)} lose like that.",
        near,
        PERCENT,
        f"{some(near.questions, 'question')} within {digits(1)(_NEAR)} radii of a circle, "
        f"{away.questions} at least {digits(1)(_AWAY)} radii from one",
        STRATA,
    )


# Strata lie at 1e-6 radii from a circle, at 1e-3, at 0.1, and farther.
_NEAR, _AWAY = 1e-5, 0.05


def _asked(estimate: Estimate, pairs: int, noun: str) -> str:
    return f"{some(estimate.questions, 'question')} with a path, {some(pairs, noun)}, in pairs"
