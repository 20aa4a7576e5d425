"""Findings: sentences to act on, computed from the rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import ENOUGH_TO_CHOOSE
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import General, Place, Section, Table, Topic
from dubins_study.report.elements.formats import some
from dubins_study.report.statistics.methods import compared
from dubins_study.report.statistics.metrics import parse_spec
from dubins_study.report.topics.comparison import evaluations
from dubins_study.report.topics.findings_evidence import (
    ENOUGH,
    Estimate,
    Evidence,
    Finding,
    Pair,
)
from dubins_study.report.topics.findings_routes import growth, proof_of_routes, where_engines_stop
from dubins_study.report.topics.findings_tours import grid_optima
from dubins_study.report.topics.tours import TOURS
from dubins_study.study.kinds.table import BRANCHES_WITHOUT_PATH

WORDS = "one NLP a word"
JOINT = "joint NLP, both orders"
RANKS = "Comparison of methods: means and ranks"
MATRIX = "Formulation by engine"
# Initial guesses in a sentence.
_FROM = {
    "one": "one guess toward the target",
    "words": "one guess a word",
    "straight": "a straight line",
    "bearing": "several guesses",
}


def words_against_joint(evidence: Evidence) -> Finding | None:
    """One problem a word against the joint model.

    Pairs of methods differ in the formulation alone: the engine and the guess are the same, and
    both are presolved or neither is. Routes have no such pair: their joint model is a formulation
    of its own. Each kind of guess has its own difference. The largest clear difference is
    the sentence, and the others follow in `question`.
    """
    same = ["engine", "guess", "guesses", "presolve", "settings"]
    kinds: dict[str, list[Pair]] = {}
    for pair in evidence.pairs(same, "formulation", WORDS, JOINT):
        guess = str(evidence.methods["guess"][pair[0]])
        kinds.setdefault(_FROM.get(guess, guess), []).append(pair)
    differences: dict[str, Estimate] = {}
    for guess, pairs in kinds.items():
        points = _points(evidence, pairs, len(kinds))
        if points is not None:
            differences[guess] = points
    clear = [guess for guess, points in differences.items() if points.is_clear()]
    if not clear:
        return None
    head = max(clear, key=lambda guess: abs(differences[guess].value))
    better = "one problem a word"
    worse = "the joint model"
    if differences[head].value < 0:
        better, worse = worse, better
        differences = {guess: points.turned() for guess, points in differences.items()}
        kinds[head] = [pair[::-1] for pair in kinds[head]]
    others = []
    for guess, points in differences.items():
        if guess != head:
            undecided = "" if points.is_clear() else " (undecided)"
            others.append(f"from {guess} {points.text()}{undecided}")
    return _in_pairs(
        evidence,
        kinds[head],
        differences[head],
        f"Pose {better}: from {head}, it raises the same engines' share right by "
        f"{differences[head].text()} percentage points over {worse}.",
        others,
    )


def blind_start(evidence: Evidence) -> Finding | None:
    """One guess toward the points against a straight line.

    Pairs of methods differ in the guess alone.
    """
    pairs = evidence.pairs(["formulation", "engine", "settings"], "guess", "one", "straight")
    points = _points(evidence, pairs)
    if points is None or not points.is_clear():
        return None
    better = _FROM["one"]
    worse = _FROM["straight"]
    if points.value < 0:
        better, worse = worse, better
        points = points.turned()
        pairs = [pair[::-1] for pair in pairs]
    return _in_pairs(
        evidence,
        pairs,
        points,
        f"Begin from {better}: this raises the same engines' share right by {points.text()} "
        f"percentage points over {worse}.",
    )


def _apart(evidence: Evidence, pairs: list[Pair]) -> pd.DataFrame:
    """Differences of shares right, questions by pairs.

    A column has the name of the pair's first method. It says by how many percentage points the
    first method is right more often than the second; negative: less often.
    """
    rates = evidence.rates
    apart = {first: 100 * (rates[first] - rates[second]) for first, second in pairs}
    return pd.DataFrame(apart, rates.index)


def _points(evidence: Evidence, pairs: list[Pair], of: int = 1) -> Estimate | None:
    """The mean difference of shares right, or None.

    It is the mean of `_apart`, in percentage points. Its interval is over scenarios and engines. If
    it is one of `of` means, all their intervals hold at once.
    """
    return evidence.estimate_over_engines(_apart(evidence, pairs), of)


def _in_pairs(
    evidence: Evidence,
    pairs: list[Pair],
    points: Estimate,
    sentence: str,
    others: Sequence[str] = (),
) -> Finding:
    """A finding on pairs of methods.

    In each pair the first method is right more often, by `points` in the mean. The finding's
    `question` also has the texts `others`, and the range of differences between formulations, or
    between pairs if there is one formulation.
    """
    each = _apart(evidence, pairs).mean()
    by = each.groupby(evidence.methods["formulation"][each.index]).mean()
    asked = [
        f"{some(points.questions, 'question')} with a path",
        f"{some(len(pairs), 'method')} in pairs",
        *others,
    ]
    if len(by) > 1:
        most = f"{by.min():z.0f} ({by.idxmin()}) to {by.max():z.0f} ({by.idxmax()})"
        asked.append(f"by formulation {most} points")
    elif len(pairs) > 1:
        asked.append(f"pair by pair {each.min():z.0f} to {each.max():z.0f} points")
    return Finding(sentence, points, "; ".join(asked), MATRIX)


def presolve_pairs(methods: pd.DataFrame) -> list[Pair]:
    """Pairs of solvers (without presolve, with presolve).

    The specs of a pair differ only in the setting `presolve`.
    """
    alike: dict[object, dict[bool, str]] = {}
    for spec in methods.index:
        name, settings = parse_spec(spec)
        presolved = settings.pop("presolve", "false").lower() == "true"
        alike.setdefault((name, *settings.items()), {})[presolved] = spec
    return [(specs[False], specs[True]) for specs in alike.values() if len(specs) > 1]


def presolve(evidence: Evidence) -> Finding | None:
    """The evaluations that dropping words by geometry saves.

    The sentence has the best supported median of a method; `question` has those of all.
    """
    table = evaluations(evidence.compared).replace(np.inf, np.nan)
    ratios = pd.DataFrame(index=table.index)
    for off, on in presolve_pairs(evidence.methods):
        if off in table and on in table:
            ratios[on] = table[off] / table[on]
    factors: dict[str, Estimate] = {}
    for solver in map(str, ratios):
        factor = evidence.median(ratios[solver])
        if factor is not None:
            factors[solver] = factor
    if not factors or not min(factor.low for factor in factors.values()) > 1.0:
        return None
    surest = max(factors, key=lambda solver: factors[solver].low)
    parts = [f"{factors[solver].text()} with {evidence.name(solver)}" for solver in factors]
    return Finding(
        "Drop the words that geometry excludes before you call an engine: at the median this "
        f"divides {evidence.methods['engine'][surest]}'s evaluations of a question by "
        f"{factors[surest].text()}.",
        factors[surest],
        f"{some(factors[surest].questions, 'question')} with a path, with several guesses a word; "
        f"the surer of the medians: {', '.join(parts)}",
        "Cost where it arises",
    )


def price_of_proof(evidence: Evidence) -> Finding | None:
    """The fastest method with a proof against one without.

    Both have the same formulation and know the same of the answer: else the ratio would compare
    these too.
    """
    ranked = evidence.ranked
    proves = ranked.index.isin(evidence.provers)
    methods = evidence.methods.reindex(ranked.index)
    alike = methods["formulation"] + ": " + methods["knows"].fillna("")
    first_local = alike[~proves].rename("alike").reset_index().groupby("alike")["solver"].first()
    provers = alike[proves & alike.isin(first_local.index)]
    if provers.empty:
        return None
    prover = provers.index[0]
    local = first_local[provers.iloc[0]]
    ratio = evidence.time_ratio(prover, local)
    proven = evidence.rates[prover] == 1.0
    right = evidence.share_of(evidence.rates.loc[proven, local])
    if ratio is None or right is None or not ratio.low > 1 or ratio.questions < ENOUGH_TO_CHOOSE:
        return None
    return Finding(
        "Buy a proof only where errors cost more than time: "
        f"{evidence.methods['engine'][prover]} takes {ratio.text()} times as long as "
        f"{evidence.name(local)}.",
        ratio,
        f"{evidence.medians_of(prover, local)}; those of least mean time, failures counted as the "
        "limit, with and without a proof, of one formulation and with the same knowledge of the "
        f"answer. The method without a proof is right on {right.percent_text()} of the questions "
        "that the other answers",
        RANKS,
    )


FINDINGS: tuple[Callable[[Evidence], Finding | None], ...] = (
    proof_of_routes,
    where_engines_stop,
    growth,
    grid_optima,
    blind_start,
    words_against_joint,
    presolve,
    price_of_proof,
)


def findings_section(results: Results) -> Section | None:
    """The section with all findings, or None without any."""
    every = _findings(results)
    if not every:
        return None
    text = (
        f"Every finding is computed from the results of at least {ENOUGH} questions. The "
        "intervals in the first column hold at once with 95 %. A difference is reported only if "
        "its interval excludes zero difference."
    )
    lead = f"Read {some(len(every), 'sentence')} to act on, the most important first."
    return Section("findings", "What the study found", text, (_table(every),), lead)


def _findings(results: Results) -> list[Finding]:
    """The findings of each experiment.

    A finding names its experiment if there are several. The intervals are corrected for all
    findings that are possible: each of `FINDINGS` in each experiment, but of tours only
    `grid_optima`, which is about tours alone. Frozen convex problems are left out, since they have
    a section of their own.
    """
    paths = results.attempts[~results.attempts["branch"].isin(BRANCHES_WITHOUT_PATH)]
    asked = set(paths["experiment"])
    names = dict.fromkeys(run.name for run in results.folders if run.name in asked)
    tours = {run.name for run in results.folders if run.section == TOURS}
    possible = [
        (find, name)
        for find, name in product(FINDINGS, names)
        if (find is grid_optima) == (name in tours)
    ]
    suites: dict[str, Evidence] = {}
    for name in names:
        attempts = compared(results.only({name}))
        if attempts is not None:
            suites[name] = Evidence(attempts, len(possible), results.settings)
    every = []
    for find, name in possible:
        if name not in suites:
            continue
        finding = find(suites[name])
        if finding is not None:
            shown_in = finding.shown_in.partition(":")[0]
            if len(names) > 1:
                shown_in += f": {name}"
            every.append(finding._replace(shown_in=shown_in))
    return every


def _table(findings: list[Finding]) -> Table:
    """The table with a line per finding."""
    shown = (
        *columns(kind="prose", sentence="finding"),
        *columns(kind="prose", question="from what"),
        *columns(kind="section", shown_in="shown in"),
    )
    caption = (
        "Intervals: Wilson's for shares, else a bootstrap over scenarios, and over engines if none "
        "is named; corrected for all possible sentences (Bonferroni). They leave out the machine's "
        "speed. A ratio of times is of medians over the questions that both answer, of routes of "
        "geometric means."
    )
    return Table("findings", caption, pd.DataFrame(findings), shown, stacked=True)


TOPIC = Topic("what the study found", findings_section, General.FOUND, place=Place.FRONT)
