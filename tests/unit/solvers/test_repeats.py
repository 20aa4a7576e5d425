"""Random initial guesses: another seed in each repeat, and none that is out of range."""

from __future__ import annotations

import pytest
from cases import PAPER

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError, load
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim

RANDOM = (
    "slsqp[model=joint,initial_guess=random,count=2]",
    "nlp[engine=nlopt-slsqp,model=joint,initial_guess=random,count=2]",
    "shooting[initial_guess=random,count=2]",
    "multiple-shooting[initial_guess=random,count=1]",
)


@pytest.mark.parametrize("spec", RANDOM)
def test_each_repeat_has_a_seed_of_its_own(spec):
    """The repeats spend different evaluations, and each of them always the same."""
    solver = load(spec)

    def evaluations(repeat):
        question = Question(PAPER["problem 1"], repeat=repeat)
        return attempt(solver, question, 20.0).evaluations

    spent = [evaluations(repeat) for repeat in range(4)]

    assert len(set(spent)) > 1
    assert evaluations(2) == spent[2]


@pytest.mark.parametrize(
    "setting", ["seed=-1", "seed=4294967297", "seed=1.5", "count=0", "count=10000000000"]
)
@pytest.mark.parametrize("name", ["slsqp", "ipopt", "nlp", "multiple-shooting", "penalty"])
def test_a_seed_or_count_out_of_range_is_refused(name, setting):
    key = setting.partition("=")[0]
    with pytest.raises(SolverError, match=key):
        load(f"{name}[initial_guess=random,{setting}]")


def test_the_milp_is_not_offered_to_an_engine_that_never_ends():
    with pytest.raises(SolverError, match="engine is 'maingo'; expected one of: highs, scip"):
        load("heading-milp[engine=maingo]")


@pytest.mark.parametrize("branch", ["LS", "RS"])
def test_far_away_the_disjunction_calls_nothing_infeasible(branch):
    """Both words reach a target 1.4e9 R away; SCIP's tolerances cannot tell."""
    answer = attempt(load("disjunctive"), Question(Scenario(0, 0, 1, 1e9, -1e9, 1), branch), 20.0)

    assert answer.claim is not Claim.INFEASIBLE
    assert not answer.false_claim
