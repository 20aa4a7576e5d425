"""The worth of claims, and proofs, by hand.

The rows of each kind are made up.
"""

import math

import numpy as np
import pytest

from dubins_study.report.statistics.methods import compared
from dubins_study.report.topics.belief import PROOFS, belief_section, beliefs, claims, false_proofs
from dubins_study.report.topics.certificates import certificates_section, proofs
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import solve_command
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, lost, paper_scenarios

PLAIN = Scenario(0, 0, 0, 5, 2, 1, label="plain")
FAR = Scenario(0, 0, 0.123456, 50, 20, 1, label="far")
# The target lies in the left disc: no path LS.
DISC = Scenario(0, 0, 0, 0.5, 1, 1, label="disc")


def honest(scenario, solver, claim, path="exact", branch="best", **changes):
    return attempt(scenario, solver, branch, path, claim, **({"false_bound": False} | changes))


def frame(load_rows, rows):
    return claims(compared(load_rows("benchmark", rows)))


LONGER, MISSES = shortest_path(PLAIN, "RS"), Path(PLAIN.start, [0.0], [1.0])
LENGTH = shortest_path(PLAIN).length


def bound(factor, **changes):
    """A claim of optimality with a scaled bound.

    The bound is the shortest length times a factor.
    """
    bounds = {"lower_bound": factor * LENGTH, "reference_high": LENGTH, "false_bound": True}
    return honest(PLAIN, "scip", Claim.OPTIMAL, **bounds, **changes)


WORTHS = [
    (honest(PLAIN, "scip", Claim.OPTIMAL), "true"),
    (honest(PLAIN, "scip", Claim.OPTIMAL, LONGER), "false"),
    (honest(PLAIN, "scip", Claim.LOCAL, LONGER), "true"),
    (honest(PLAIN, "scip", Claim.LOCAL, MISSES), "false"),
    (honest(PLAIN, "scip", Claim.FEASIBLE), "better than claimed"),
    (honest(PLAIN, "scip", Claim.FEASIBLE, LONGER), "true"),
    (honest(PLAIN, "scip", Claim.FAILED), "better than claimed"),
    (honest(PLAIN, "scip", Claim.LIMIT, LONGER), "better than claimed"),
    (honest(PLAIN, "scip", Claim.FAILED, MISSES), "says nothing"),
    (honest(PLAIN, "scip", Claim.NONE, None), "says nothing"),
    (honest(PLAIN, "scip", Claim.INFEASIBLE, None), "false"),
    (honest(DISC, "scip", Claim.INFEASIBLE, None, "LS"), "true"),
    # ten tolerances of 1e-8 explain 5e-8; a thousandth is a false proof, and any bound without one
    (bound(1 + 5e-8, tolerance=1e-8), "true to its tolerance"),
    (bound(1.001, tolerance=1e-8), "false"),
    (bound(1.1), "false"),
    # a plug-in may call every answer presolved; only a path rightly denied is taken for one
    (honest(PLAIN, "scip", Claim.OPTIMAL, LONGER, presolved=True), "false"),
]


def test_the_worth_of_each_claim(load_rows):
    """The worth of each claim.

    The claims are about a question that has a path, about one that has none, and of bounds.
    """
    presolved = honest(DISC, "scip", Claim.INFEASIBLE, None, "LS", presolved=True)
    rows = [row | {"repeat": n} for n, (row, _) in enumerate(WORTHS)]
    table = frame(load_rows, [presolved, *rows])
    proofs = false_proofs(table).set_index("proof")["most"].dropna()

    assert table["truth"].tolist() == [worth for _, worth in WORTHS]
    assert proofs.to_dict() == pytest.approx({PROOFS[0]: 0.1, PROOFS[1]: 5e-8})


def test_a_question_counts_once_however_often_it_is_asked(load_rows):
    """False in one of three repeats counts a third."""
    rows = [
        honest(PLAIN, "scip", Claim.OPTIMAL, "exact" if n else LONGER, repeat=n) for n in range(3)
    ] + [honest(FAR, "scip", Claim.OPTIMAL, repeat=n) for n in range(3)]
    line = beliefs(frame(load_rows, rows)).loc["scip"]

    assert (line["questions"], line["false"]) == (2, pytest.approx(1 / 6))
    assert line["true"] == pytest.approx(5 / 6)


def test_the_plainest_example_and_its_command(load_rows):
    """The plainest example and its command.

    The round numbers are shown; the command holds all digits of the question.
    """
    rows = [honest(s, "scip[a=1]", Claim.INFEASIBLE, None) for s in (FAR, PLAIN)]
    (line,) = false_proofs(frame(load_rows, rows)).to_dict("records")

    assert (line["proof"], line["attempts"], line["questions"]) == (PROOFS[3], 2, 2)
    assert line["command"] == "dubins-study solve --solver 'scip[a=1]' -- 5 2"


ASKED = {"x": 0.0, "y": 0.0, "heading": 0.0, "target_x": -3.0, "target_y": 1.0, "radius": 1.0}
ASKED |= {"branch": "best", "solver": "a"}
ELSEWHERE = {"x": 0.1, "heading": -2.5, "target_y": 1e-7, "radius": 2.0, "branch": "LS"}
SETTING = {"solver": "nlp[a=b,c=d]", "profile": "accurate"}
ROUTE = {"via_x": np.array([0.1, -2.0]), "via_y": [3.0, 1e-7], "final_heading": -7.5}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "--solver a -- -3 1"),
        ({"via_x": None, "via_y": math.nan, "final_heading": math.nan}, "--solver a -- -3 1"),
        ({"heading": 7.5}, "--from 0 0 7.5rad --solver a -- -3 1"),
        (
            ELSEWHERE | SETTING,
            "--from 0.1 0 -2.5 --radius 2 --branch LS --profile accurate --solver 'nlp[a=b,c=d]'"
            " -- -3 1e-07",
        ),
        (
            ROUTE,
            "--via 0.1 3 --via -2 1e-07 --final-heading -7.5rad --solver a -- -3 1",
        ),
    ],
)
def test_a_command_asks_the_question_again(changes, words):
    """A command asks the question again.

    Negative numbers are no options; radius, heading and branch are given if they matter.

    Via points as rows hold them, and headings, which may be more than a full turn.
    """
    assert solve_command(ASKED | changes) == f"dubins-study solve {words}"


def test_the_section(load_rows):
    """The section names the liar.

    Without false claims it says so, and has no table of them.
    """
    liar = load_rows("liar", [honest(PLAIN, "scip", Claim.INFEASIBLE, None)])
    good = load_rows("good", [honest(PLAIN, "scip", Claim.OPTIMAL)])

    section = belief_section(liar)
    names = [block.name for block in section.blocks]
    assert names == ["belief-claims", "belief-false"]
    assert "no path, though one exists" in section.blocks[1].texts()[0]
    assert "1 method of 1 made 1 false claim (no path, though one exists: 1)" in section.text
    assert "No method makes a false claim" in belief_section(good).text
    assert len(belief_section(good).blocks) == 1


def test_a_denial_is_no_false_claim(load_rows):
    """A denial is no false claim.

    A local engine's word of its last point is counted apart, and only where a path exists.
    """
    local = load_rows("local", [honest(PLAIN, "ipopt", Claim.LOCALLY_INFEASIBLE, None)])

    section = belief_section(local)

    assert [block.name for block in section.blocks] == ["belief-claims"]
    assert "No method makes a false claim" in section.text
    assert "1 denial" in section.text
    assert claims(compared(local))["truth"].tolist() == ["denial"]


PROVED = {
    "proof": "proved",
    "pmp_residual": 1e-15,
    "cut_margin": 0.5,
    "reference_low": 1.0,
    "reference_high": 1.0 + 4e-16,
    "false_bound": False,
}


def rows():
    """Rows of two solvers with and without proofs.

    One is proved, with multipliers; the other has a bad bound, an extremal and a lost row.
    """
    first, second, third = paper_scenarios()[:3]
    extremal = {"proof": "extremal", "false_bound": True}
    return [
        attempt(first, "slsqp", costate_error=1e-9, **PROVED),
        attempt(second, "slsqp", costate_error=1e-7, **(PROVED | {"cut_margin": 0.2})),
        attempt(first, "disjunctive", lower_bound=9.0, **(PROVED | extremal)),
        attempt(second, "disjunctive", lower_bound=1.0, **(PROVED | {"proof": "bounded"})),
        lost(third, "disjunctive"),
    ]


def test_numbers_by_hand(load_rows):
    """Numbers by hand.

    They are counts of each word, a lost row without a proof, and the worst and least of what is
    measured.
    """
    table = proofs(load_rows("tiny", rows()).attempts).set_index("solver")
    words = ["attempts", "proved", "bounded", "extremal", "none"]

    assert table.loc["slsqp", words].tolist() == [2, 2, 0, 0, 0]
    assert table.loc["disjunctive", words].tolist() == [3, 0, 1, 1, 1]
    assert table.loc["slsqp", "pmp_residual"] == 1e-15
    assert table.loc["slsqp", ["multipliers", "costate_error"]].tolist() == [2, 1e-7]
    assert table.loc["disjunctive", ["bounds", "false_bounds"]].tolist() == [2, 1]
    assert math.isnan(table.loc["disjunctive", "costate_error"])


def test_multipliers_are_compared_with_costates_that_are_there(load_rows):
    """Multipliers are compared with existing costates.

    They are not of a single arc, which leaves them free, nor of a path that is no extremal or is
    lost.
    """
    scenario = paper_scenarios()[0]
    base = attempt(scenario, "slsqp", costate_error=1e-9, **PROVED)
    variants = [
        base,
        base | {"repeat": 1, "word": "L"},
        base | {"repeat": 2, "pmp_residual": 0.1},
        base | {"repeat": 3, "costate_error": None},
        base | {"repeat": 4, "gap": None},
    ]

    table = proofs(load_rows("tiny", variants).attempts)

    assert table[["attempts", "multipliers", "costate_error"]].to_numpy().tolist() == [[5, 1, 1e-9]]
    for row in variants[1:]:
        alone = proofs(load_rows(f"only-{row['repeat']}", [row]).attempts)
        assert alone["multipliers"].tolist() == [0]


def test_the_section_says_what_the_rows_say(load_rows):
    text = certificates_section(load_rows("tiny", rows())).text

    assert "Of 5 attempts 2 are proved (40.0 %; 1 bounded, 1 extremal, 1 none)." in text
