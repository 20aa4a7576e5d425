"""Each finding on made-up rows.

There are rows with the effect, without it, and too few rows.

A finding that no effect can remove, or that no effect can make, would be a typed one.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest, linregress

from dubins_study.report.elements.content import General
from dubins_study.report.page.sections import TOPICS, sections_of
from dubins_study.report.statistics.methods import Compared, compared, methods_of
from dubins_study.report.topics import findings as found
from dubins_study.report.topics.findings import FINDINGS, findings_section
from dubins_study.report.topics.findings_evidence import ENOUGH, Evidence, Finding, chosen_share
from dubins_study.report.topics.findings_routes import exponent
from dubins_study.report.topics.routes import TITLE
from dubins_study.report.topics.tours import TITLE as TOURS_TITLE
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, compared_row, paper_scenarios

WORDS, JOINT = found.WORDS, found.JOINT
MANY, FEW = 80, ENOUGH - 1
GRID, EIGHT = "tour-milp", {"headings": 8, "costs": "lengths"}
Row = dict[str, Any]


def row(question: int, solver: str, **changes: Any) -> Row:
    """A right answer of a local engine.

    It takes 1 ms; times differ a little from question to question.
    """
    answer = compared_row(
        question,
        solver,
        **{"engine": "Ipopt", "gap": 1e-12, "tolerance": 1e-8, "margin": 1.0, "evaluations": 10.0},
        **dict.fromkeys(("x", "y", "heading", "target_y"), 0.0),
        target_x=4.0 + question,
    )
    answer |= changes
    answer["wall_s"] *= 1 + (question % 7) / 50
    if not answer["right"] and answer["verdict"] == "optimal":
        answer |= {"verdict": "misses", "gap": float("nan"), "claim": "failed"}
    return answer


def evidence(rows: Iterable[Row]) -> Evidence:
    frame = pd.DataFrame(list(rows))
    return Evidence(Compared(frame, methods_of(frame), 2.0, ()), settings={GRID: EIGHT})


class Case(NamedTuple):
    """A finding with its rows and words.

    Rows come with the effect and without it; the sentence must hold the words.
    """

    find: Callable[[Evidence], Finding | None]
    made: Callable[[int, bool], list[Row]]
    says: tuple[str, ...]
    value: float


def of_two(first: Row, second: Row, effect: Callable[[int], Row]) -> Callable[..., list[Row]]:
    """Rows of a solver against another.

    Only the rows with the effect have its changes.
    """

    def made(n: int, there: bool) -> list[Row]:
        other = [second | (effect(q) if there else {}) for q in range(n)]
        return [row(q, **one) for q in range(n) for one in (first, other[q])]

    return made


def half_wrong(q: int) -> Row:
    return {"right": q % 2 == 0}


def slower(factor: float, _: int) -> Row:
    return {"wall_s": factor * 1e-3}


IPOPT = {"solver": "ipopt"}
BOTH_ORDERS = {"solver": "ipopt[model=joint]", "formulation": JOINT}
ONE_GUESS = {"solver": "one", "guess": "one", "guesses": "one"}
BLIND = {"solver": "blind", "guess": "straight", "guesses": "blind"}
SCIP = {"solver": "global-nlp[model=words]", "engine": "SCIP", "guess": "none"}
OTHER_FORMULATION = {"formulation": "disjunction"}
PROOF = {"claim": "optimal", "lower_bound": 4.0}


def routes(
    n: int,
    effect: bool,
    slow: float = 1.0,
    power: float = 1.0,
    right: Callable[[int], bool] = lambda _: True,
    sizes: tuple[int, ...] = (2, 5, 10, 20),
) -> list[Row]:
    """Routes of four sizes by search and engine.

    The effect is one of them.
    """
    attempts = []
    for q in range(n):
        legs = sizes[q % 4]
        same: Row = {"label": "short", "via_x": [1.0] * (legs - 1)}
        mine = slow if effect else 1.0
        other = legs ** (power if effect else 1.0)
        columns = {
            "engine": "none",
            "formulation": "closed form",
            "guess": "none",
            "claim": "optimal",
        }
        attempts.append(row(q, "analytic", **columns, **same, wall_s=1e-3 * mine * other))
        found_it = right(legs) or not effect
        attempts.append(row(q, "ipopt", **same, wall_s=1e-3 * other, right=found_it))
        if power != 1.0:
            attempts[-2]["wall_s"] = 1e-3 * legs * (1 + (q % 7) / 50)
    return attempts


def tours(n: int, effect: bool) -> list[Row]:
    """Proved tours, and proved optima of a grid.

    The effect makes half of the optima longer.
    """
    attempts = []
    for q in range(n):
        same: Row = {"scenario_id": f"tour {q}", "closed": False, "via_x": [1.0], "message": ""}
        same |= {"lower_bound": 5.0, "reference_high": 5.0, "visit_order": [0.0], "late": False}
        solved = same | {"native_status": "kOptimal", "formulation": "tour MILP", "engine": "HiGHS"}
        if effect and q % 2:
            solved |= {"verdict": "longer", "gap": 0.03, "visit_order": [1.0]}
        attempts.append(row(q, "analytic", **same, native_status="", claim="optimal"))
        attempts.append(row(q, GRID, **solved))
    return attempts


CASES = [
    Case(
        found.words_against_joint,
        of_two(IPOPT, BOTH_ORDERS, half_wrong),
        ("Pose one problem a word", "50 ("),
        50.0,
    ),
    Case(
        found.blind_start,
        of_two(ONE_GUESS, ONE_GUESS | BLIND, half_wrong),
        ("Begin from one guess", "50 ("),
        50.0,
    ),
    Case(
        found.proof_of_routes,
        partial(routes, slow=4.0),
        ("it proves 100 % (", "of 2 to 20 legs", ", 4.0 (4.0 to 4.0) times as slow"),
        1.0,
    ),
    Case(
        found.where_engines_stop,
        partial(routes, right=lambda legs: legs < 5),
        ("Do not trust an engine alone with routes of many short", "0 % (0 to", "proves 60 of 60"),
        0.0,
    ),
    # 20 routes of each size at the ends are the fewest that carry a power
    Case(
        found.growth,
        partial(routes, power=2.0, sizes=(10, 20, 50, 100)),
        (
            "multiply the time of Ipopt (bearing) on one NLP a word by 4.0 (",
            "(106 ms to 10.6 s)",
            "by 2.0 (",
        ),
        2.0,
    ),
    Case(
        found.grid_optima,
        tours,
        ("with 8 headings a point, 50.0 % (", "by 3.0 % at", "40 optima are longer"),
        0.5,
    ),
    Case(
        found.presolve,
        of_two(
            {"solver": "ipopt[presolve=True]"},
            IPOPT | {"evaluations": 10.0},
            lambda q: {"evaluations": 60.0 + q % 3},
        ),
        ("Drop the words", "6.1 ("),
        6.1,
    ),
    Case(
        found.price_of_proof,
        of_two(IPOPT, SCIP | PROOF, partial(slower, 50.0)),
        ("SCIP takes 50 (50 to 50) times", "right on 100 % ("),
        50.0,
    ),
]
NAMES = [case.find.__name__ for case in CASES]


def test_every_finding_has_a_case():
    assert set(NAMES) == {find.__name__ for find in FINDINGS}


@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_a_finding_is_said_of_its_effect_alone(case):
    """A finding is said of its effect alone.

    It has its number, which lies in its interval, and the number of questions. It is not said
    without the effect, of too few questions, of one solver, or of failures alone.
    """
    finding = case.find(evidence(case.made(MANY, True)))
    one = [row(q, "ipopt") for q in range(MANY)]
    failed = [row(q, s, right=False) for q in range(MANY) for s in ("ipopt", "slsqp")]

    assert finding is not None
    told = f"{finding.sentence} {finding.question}"
    assert all(text in told for text in case.says), told
    assert len(finding.sentence.split()) <= 30
    value, low, high, questions = finding.estimate
    assert value == pytest.approx(case.value, rel=0.03, abs=1e-12)
    assert low <= value <= high
    assert questions == MANY or case.find is found.where_engines_stop
    for rows in (case.made(MANY, False), case.made(FEW, True), one, failed):
        assert case.find(evidence(rows)) is None


def test_guesses_are_told_apart():
    """Guesses are told apart.

    From one guess the words are better, from a straight line worse: each is said by itself.
    """
    one = {"guess": "one", "guesses": "one"}
    joint = of_two(BOTH_ORDERS | one, IPOPT | one, lambda q: {"right": q % 4 != 0})
    words = of_two(BLIND, BLIND | {"solver": "b", "formulation": JOINT}, half_wrong)
    finding = found.words_against_joint(evidence(joint(MANY, True) + words(MANY, True)))

    assert finding.sentence.startswith("Pose one problem a word: from a straight line")
    assert "; from one guess toward the target −25 (" in finding.question
    assert "1 method" in finding.question


def test_the_search_is_held_against_the_fastest_of_those_that_are_as_sure():
    """The search competes with the fastest sure solver.

    It does so spacing by spacing; an engine that is never right is not one of them.
    """
    rows = routes(80, True, slow=4.0, sizes=(2, 5, 100, 200))
    rows = [one | {"label": "long" if len(one["via_x"]) > 50 else "short"} for one in rows]
    ipopt = [one for one in rows if one["solver"] == "ipopt"]
    slsqp = [
        one | {"solver": "slsqp", "engine": "SLSQP"} | {"wall_s": one["wall_s"] * (2, 0.5)[long]}
        for one in ipopt
        for long in [one["label"] == "long"]
    ]
    never = [one | {"solver": "uno", "engine": "Uno", "right": False} for one in ipopt]
    question = found.proof_of_routes(evidence(rows + slsqp + never)).question

    assert "Uno" not in question
    assert "with short it proves 40 of 40, 4.0 (4.0 to 4.0) times as slow as Ipopt" in question
    assert "8.0 (8.0 to 8.0) times as slow as SLSQP" in question
    assert (
        found.proof_of_routes(evidence([one for one in rows if one not in ipopt] + never)) is None
    )


@pytest.mark.parametrize(
    ("find", "made", "advice"),
    [
        (found.words_against_joint, of_two(BOTH_ORDERS, IPOPT, half_wrong), "Pose the joint model"),
        (
            found.blind_start,
            of_two(ONE_GUESS | BLIND, ONE_GUESS, half_wrong),
            "Begin from a straight line",
        ),
    ],
)
def test_a_sentence_turns_round_with_the_rows(find, made, advice):
    """A sentence turns round with the rows.

    If the other choice is the better one, the advice is the other.
    """
    finding = find(evidence(made(MANY, True)))

    assert finding is not None
    assert finding.sentence.startswith(advice)
    assert finding.estimate.low > 0


@pytest.mark.parametrize(
    "unequal",
    [{"guesses": "several"}, {"guesses": None}, {"guess": "random"}, {"presolve": True}],
)
def test_formulations_are_compared_at_equal_guesses_only(unequal):
    """Formulations are compared at equal guesses only.

    More guesses, or a presolve, on one side say nothing of the formulation.
    """
    equal = of_two(IPOPT, BOTH_ORDERS, half_wrong)(MANY, True)
    other = of_two(IPOPT | unequal, BOTH_ORDERS, half_wrong)(MANY, True)

    assert found.words_against_joint(evidence(equal)) is not None
    assert found.words_against_joint(evidence(other)) is None


def test_a_sentence_on_engines_holds_for_other_engines():
    """A sentence on engines needs several engines.

    One engine that gains much and three that gain nothing carry no advice for all.
    """

    def rows(gains: int) -> list[Row]:
        attempts = []
        for number, engine in enumerate("abcd"):
            words = {"solver": f"{engine}-words", "engine": engine}
            joint = {"solver": f"{engine}-joint", "engine": engine, "formulation": JOINT}
            attempts += of_two(words, joint, half_wrong)(MANY, number < gains)
        return attempts

    every = found.words_against_joint(evidence(rows(4)))
    assert every is not None
    assert "4 methods in pairs" in every.question
    assert found.words_against_joint(evidence(rows(1))) is None


@pytest.mark.parametrize("of", [1, 20])
def test_the_worst_of_many_has_the_interval_of_all(of):
    """0 of 30 by chance: by Bonferroni."""
    high = binomtest(0, MANY).proportion_ci(1 - 0.05 / of, "wilson").high

    assert chosen_share(0.0, MANY, of).high == pytest.approx(high)


@pytest.mark.parametrize(
    ("floor_s", "runs", "said"),
    [
        *((None, [4.0], True), (2e-4, None, True), (2e-4, [2.0], True)),
        *((2e-4, [4.0], False), (9e-4, None, False)),
    ],
)
def test_no_sentence_compares_times_that_are_mostly_floor(floor_s, runs, said):
    """No sentence compares times that are mostly floor.

    Four calls of 0.2 ms each for a trivial problem are most of 1 ms, two are not.
    """
    floor = {"floor_s": floor_s, "subproblem_runs": runs}
    proof = of_two(IPOPT | floor, SCIP | PROOF, partial(slower, 50.0))(MANY, True)

    assert (found.price_of_proof(evidence(proof)) is not None) is said


@pytest.mark.parametrize("other", [OTHER_FORMULATION, {"knows": "words"}], ids=str)
def test_the_price_of_a_proof_is_of_the_proof_alone(other):
    """Both methods have one formulation, and know the same of the answer."""
    rows = of_two(IPOPT, SCIP | PROOF | other, partial(slower, 50.0))(MANY, True)

    assert found.price_of_proof(evidence(rows)) is None


def test_an_exponent_is_that_of_the_times():
    """An exponent is that of the times.

    Times that are a power exactly have no interval; noisy ones have that of scipy about it.
    """
    legs = np.repeat([2.0, 5.0, 10.0, 20.0, 50.0], 8)
    noise = np.random.default_rng(3).normal(0.0, 0.3, legs.size)
    exact, noisy = exponent(legs, 3.0 * legs**1.5), exponent(legs, 3.0 * np.exp(noise) * legs**1.5)
    line = linregress(np.log(legs), 1.5 * np.log(legs) + noise)

    assert exact[:3] == pytest.approx((1.5, 1.5, 1.5))
    assert noisy.value == pytest.approx(line.slope)
    assert noisy.high - noisy.low == pytest.approx(2 * 1.96 * line.stderr, rel=0.25)
    assert noisy.low < line.slope < noisy.high


@pytest.mark.slow
def test_the_section_has_every_sentence(load_rows):
    """The section has every sentence of real rows.

    It has none where no row carries a finding.
    """
    rows = []
    local = {"claim": Claim.LOCAL, "best_run_s": 1e-3}
    for number in range(30):
        scenario = paper_scenarios()[0]
        moved = type(scenario)(0, 0, scenario.heading, 10 + number, 5, 1)
        rows += [attempt(moved, "ipopt", engine="Ipopt", wall_s=1e-3, **local)]
        rows += [attempt(moved, "disjunctive", engine="SCIP", wall_s=3e-3)]
    loaded = load_rows("benchmark", rows)
    section = findings_section(loaded)
    attempts = compared(loaded)

    assert attempts is not None
    every = [finding for find in FINDINGS if (finding := find(Evidence(attempts, len(FINDINGS))))]
    assert section is not None
    assert section.blocks[0].frame["sentence"].tolist() == [f.sentence for f in every]
    topics = [
        topic
        for topic in TOPICS
        if topic.about in ("benchmark", General.BENCHMARKED, General.FOUND)
    ]
    shown = {section.title for topic in topics for section in sections_of(topic, loaded)}
    named = {case.find(evidence(case.made(MANY, True))).shown_in for case in CASES}
    assert {name.split(":")[0] for name in named} <= shown | {TITLE, TOURS_TITLE}
    assert "SCIP takes 3.0" in " ".join(section.blocks[0].frame["sentence"])
    assert "medians 3.00 ms and 1.00 ms" in " ".join(section.blocks[0].frame["question"])
    assert "is of medians" in section.blocks[0].caption
    assert findings_section(load_rows("few", rows[:6])) is None
