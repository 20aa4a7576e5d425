"""Findings about proofs: what one costs, and which are false."""

from __future__ import annotations

from dubins_study.report.elements.formats import some
from dubins_study.report.topics.belief.numbers import FALSE, beliefs, false_proofs
from dubins_study.report.topics.findings.evidence import Evidence
from dubins_study.report.topics.findings.finding import (
    ENOUGH,
    PERCENT,
    TIMES,
    Estimate,
    Finding,
    percent,
)

_NAMES = 3  # names in a sentence


def price_of_proof(evidence: Evidence) -> Finding | None:
    """The best method that proves its answers against the best that does not."""
    ranked = evidence.ranked
    proves = ranked.index.isin(evidence.provers)
    if not proves.any() or proves.all():
        return None
    prover, local = str(ranked.index[proves][0]), str(ranked.index[~proves][0])
    ratio = evidence.time_ratio(prover, local)
    proven = evidence.rates[prover] == 1.0
    right = evidence.share_of(evidence.rates.loc[proven, local])
    if ratio is None or right is None or not ratio.excludes(1):
        return None
    if ratio.value > 1:
        advice = "Buy a proof only where a wrong answer costs more than time"
    else:
        advice = "Take the proof: it costs nothing here"
    return Finding(
        f"{advice}: {evidence.name(prover)} takes {ratio.text()} times as long as "
        f"{evidence.name(local)}, which proves nothing and is right on {right.percent_text()} of "
        "the questions that the other answers.",
        ratio,
        TIMES,
        f"{some(ratio.questions, 'question')} that both answer; the fastest with and without a "
        "proof",
        "Comparison of methods: means and ranks",
    )


def false_proof(evidence: Evidence) -> Finding | None:
    """The engine with proofs whose proofs are false most often, and the others by name."""
    rows = evidence.claims[evidence.claims["solver"].isin(evidence.provers)]
    if rows.empty:
        return None
    table = beliefs(rows, ["solver"])
    table = table[(table["false"] > 0) & (table["questions"] >= ENOUGH)]
    if table.empty:
        return None
    order = [str(s) for s in table.sort_values("false", ascending=False, kind="stable").index]
    worst = table.loc[[order[0]]].to_dict("records")[0]
    share = percent(
        Estimate(worst["false"], worst["false_low"], worst["false_high"], int(worst["questions"]))
    )
    false = false_proofs(rows[(rows["solver"] == order[0]) & (rows["truth"] == FALSE)]).to_dict(
        "records"
    )[0]
    others = [evidence.name(solver) for solver in order[1 : _NAMES + 1]]
    more = f" So do {', '.join(others)}." if others else ""
    more += (
        f" And {some(len(order) - 1 - _NAMES, 'method')} more." if len(order) > _NAMES + 1 else ""
    )
    return Finding(
        f"Check a proof as you check an answer: {evidence.name(order[0])} claims or bounds what "
        f"is false on {share.percent_text()} of the questions; on "
        f"{some(false['attempts'], 'attempt')} {false['proof']}.{more}",
        share,
        PERCENT,
        f"{some(share.questions, 'question')}, with a path or without; "
        f"{some(len(evidence.provers), 'method')} with proofs",
        "Whom one can believe: false claims by name",
    )


def infeasible_claims(evidence: Evidence) -> Finding | None:
    """Of the questions that a local engine calls infeasible, the share that has a path."""
    rows = evidence.claims[evidence.claims["claim"] == "infeasible"]
    rows = rows[~rows["solver"].isin(evidence.provers)]
    false = rows[rows["answerable"]]
    if false.empty:
        return None
    solver = str(false.groupby("solver")["question"].nunique().idxmax())
    called = rows[rows["solver"] == solver].groupby("question")["answerable"].first()
    share = evidence.share_of(called.astype(float))
    if share is None:
        return None
    liars = false["solver"].nunique()
    return Finding(
        'Do not take a local engine\'s "infeasible" for a proof: of the questions that '
        f"{evidence.name(solver)} calls infeasible, {share.percent_text()} have a path. "
        f"{some(liars, 'local method')} of {rows['solver'].nunique()} that ever say so "
        f"{'is' if liars == 1 else 'are'} wrong at least once.",
        share,
        PERCENT,
        f"{some(share.questions, 'question')} that it calls infeasible in some repeat",
        "Whom one can believe: false claims by name",
    )
