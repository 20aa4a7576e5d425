"""Rules for every registered solver.

Its method does not matter.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings

from dubins_study.asking.attempt import attempt
from dubins_study.experiments.solve import solve
from dubins_study.solvers.protocol import Guarantee, Question
from dubins_study.solvers.registry import available_solvers, entries, load, registered
from dubins_study.study.closed_form.shortest import as_path, shortest
from dubins_study.study.kinds.table import PATH_BRANCHES
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import (
    BRANCHES,
    FORMULATIONS,
    FROZEN,
    Claim,
    Outcome,
    Verdict,
)
from tests.cases import PAPER, engine_params, margin, question_for, scenarios

# A gap that the method's kind may leave: rounding; the solver's tolerance of 1e-8 on lengths; the
# coarseness of 50 steps, which falls like 1/n^2.
LARGEST_GAP = {
    Guarantee.EXACT: 1e-14,
    Guarantee.LOCAL: 1e-7,
    Guarantee.GLOBAL: 1e-6,
    Guarantee.DISCRETISED: 1e-3,
    Guarantee.STOCHASTIC: 1e-4,
}
EASY = Scenario(0, 0, 0.3, 3, 2, 1)

OF_ROUTES = ("heading", "route-nlp", "tour-")  # no route has a word as branch
# eight headings at each point, the target's too
COARSE = ("tour-milp", "tour-circuit", "tour-routing")

# One solver that is exact and one that iterates.
ALWAYS = ("analytic", "slsqp")


def test_every_entry_says_what_it_is():
    """Every entry describes itself.

    It has name, method, guarantee, branches and a line of summary, available or not.
    """
    assert {"analytic", "slsqp", "ipopt", "turn-rate-qp"} <= set(registered())
    for entry in entries():
        assert entry.formulation in FORMULATIONS or entry.branches == (FROZEN,)
        assert entry.engine
        assert entry.guarantee in set(Guarantee)
        assert entry.summary
        least = {"best"} if entry.name.startswith(OF_ROUTES) else {"best", "LS", "RS"}
        if entry.branches != (FROZEN,):
            assert least <= set(entry.branches) <= set(PATH_BRANCHES)
        assert entry.reason is None or entry.reason.strip()


@pytest.mark.many(8)
@pytest.mark.parametrize(
    ("name", "branch"),
    [
        pytest.param(
            *(name, branch),
            marks=() if branch == "best" or name in ALWAYS else pytest.mark.slow,
        )
        for name in available_solvers()
        for branch in ("best", "LS", "RS")
        if branch in load(name).branches and name not in COARSE
    ],
)
@pytest.mark.parametrize(
    "problem", engine_params(PAPER, ("problem 1", "problem 3", "problem 5, R=25"))
)
def test_paper_problems(name, branch, problem):
    answer = solve(PAPER[problem], name, branch)

    assert answer.outcome is Outcome.RETURNED, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert not answer.false_claim
    assert answer.miss <= 1e-6 * PAPER[problem].radius
    assert -1e-12 <= answer.gap <= LARGEST_GAP[load(name).guarantee]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spec", "branch"),
    [(spec, branch) for spec in ("slsqp", "ipopt", "shooting") for branch in BRANCHES]
    # of two arcs' two solutions lm misses the shorter now and then
    + [("shooting[root=lm]", "LS"), ("shooting[root=lm]", "RS")],
)
@settings(max_examples=25)
@given(scenario=scenarios(far=1000.0))
def test_words_are_right_or_said_not_to_be(spec, branch, scenario):
    """Words are right or said not to be.

    Where the word exists it is found; where it does not, no path is claimed.

    Of the two isolated solutions of LR and RL the shorter one is the branch's answer.
    """
    two_arcs = branch in ("LR", "RL")
    # the margin (radii) from the turning circles, where a miss may be shorter
    least = {"best": 1e-4, "LS": 1e-3, "RS": 1e-3}.get(branch, 1e-2)
    least = 1e-6 if "shooting" in spec else least
    assume(margin(scenario) > least)
    X, Y = scenario.local()
    # where the two solutions meet, at 1 and 3 radii from the first centre, none is isolated
    assume(not two_arcs or all(abs(math.hypot(X, Y - side) - 3) > least for side in (1, -1)))

    answer = attempt(load(spec), Question(scenario, branch))

    if shortest(scenario, branch) is None:
        assert answer.claim is not Claim.LOCAL
    else:
        assert answer.claim is Claim.LOCAL
        assert answer.verdict is Verdict.OPTIMAL
        assert answer.gap < 1e-7 or branch != "best"


@pytest.mark.many(3)
@pytest.mark.parametrize("name", available_solvers())
def test_a_branch_it_cannot_answer_is_a_row(name):
    for branch in set(BRANCHES) - set(load(name).branches):
        answer = solve(EASY, name, branch)
        assert answer.outcome is Outcome.UNSUPPORTED
        assert branch in answer.message
        assert answer.verdict is Verdict.NONE


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[] if n in ALWAYS else pytest.mark.slow) for n in available_solvers()],
)
def test_profiles_are_accepted(name):
    """Profiles are accepted.

    Every solver runs under every profile, and `accurate` is no worse than `fast`.
    """
    profiles = ("fast", "default", "accurate")
    gaps = {p: solve(*question_for(name, EASY), profile=p).gap for p in profiles}

    assert None not in gaps.values()
    assert gaps["accurate"] <= gaps["fast"] + 1e-9


# what the engine's tolerance leaves of the multipliers of two arcs, whose switch lies somewhere
TWO_ARCS = {
    "collocation": 1e-5,  # of the quadrature in the end point's derivatives: the raw miss
    "multiple-shooting": 1e-6,  # Ipopt relaxes bounds by 1e-8, and stops as far off
    "turn-rate-qp[n=320]": 0.05,  # steps of 0.018: the switch lies somewhere within one
    "shooting": 1e-7,
}


@pytest.mark.many(4)
@pytest.mark.parametrize(
    ("scenario", "spec", "error"),
    [
        # a discretised control ends within one step of the straight
        *(
            (replace(PAPER["problem 1"], radius=2.5), name, error)
            for name in available_solvers()
            for error in [0.02 if load(name).guarantee is Guarantee.DISCRETISED else 1e-6]
        ),
        *((Scenario(1, -2, 0, 1.1, -1.2, 1), spec, error) for spec, error in TWO_ARCS.items()),
    ],
)
def test_multipliers_are_the_costates(scenario, spec, error):
    """Multipliers are the costates.

    Duals, where a solver has them, are -(nu1, nu2) / nu0 of the path (derivation, section 9).

    Of a path that ends straight this is its direction there, of two arcs the second one's chord
    divided by cos(a2 / 2).
    """
    answer = solve(scenario, spec)
    if answer.multiplier_x is None and spec not in TWO_ARCS:
        pytest.skip("reports no multipliers")
    optimum = shortest(scenario)
    path = as_path(scenario.start, scenario.radius, optimum.word, optimum.segments)
    x, y, heading = path.at(optimum.segments[0] * scenario.radius)[0]
    along = (math.cos(heading), math.sin(heading))
    if optimum.word == "RL":  # of radius 1, its chord is 2 sin(a2 / 2) long
        chord = np.array((scenario.target_x - x, scenario.target_y - y))
        along = chord / math.sin(optimum.segments[1])

    assert (answer.multiplier_x, answer.multiplier_y) == pytest.approx(along, abs=error)


@pytest.mark.parametrize(
    "spec",
    [
        *("slsqp", "ipopt", "nlp", "penalty", "shooting", "heading-milp", "turn-rate-qp"),
        *("turn-rates", "multiple-shooting", "collocation", "disjunctive"),
    ],
)
@pytest.mark.parametrize("limit", [0.0, 1e-9])
def test_no_time_is_a_limit(spec, limit):
    """No time is a limit.

    There is no exception, and nothing is claimed of a point, if there is one.
    """
    solver = load(spec)
    question = Question(PAPER["problem 1"])
    solution = solver.solve(solver.build(question), limit)

    assert solution.claim is Claim.LIMIT
    assert not attempt(solver, question, limit or 1e-9).false_claim
