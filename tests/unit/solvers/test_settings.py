"""Settings of our own solvers: what is refused, and that a repeat has a seed of its own."""

from __future__ import annotations

import math
from dataclasses import fields

import pytest
from cases import PAPER

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError, load, registered

# no setting is a path, below zero or no number at all
REFUSED = [
    (name, setting.name, value)
    for name in registered()
    for setting in fields(load(name))
    if not isinstance(setting.default, bool)
    for value in (("a/b",) if isinstance(setting.default, str) else (-1.5, math.nan))
]
# what lies just outside of a setting's values
REFUSED += [
    *(("collocation", "n", 2), ("collocation", "n", 4.5), ("collocation", "max_iter", True)),
    *(("collocation", "tol", 0.1), ("disjunctive", "gap", 0.0), ("global-nlp", "gap", 0.1)),
    *(("global-nlp", "feastol", 1e-12), ("global-nlp", "model", "both")),
    *(("heading-milp", "headings", 1001), ("heading-milp", "engine", "maingo")),
    *(("penalty", "evaluations", 10_000_000), ("penalty", "initial_guess", "given")),
    *(("shooting", "tol", 0.0), ("turn-rate-qp", "tolerance", 0), ("turn-rates", "engine", "piqp")),
]


@pytest.mark.parametrize(("name", "setting", "value"), REFUSED)
def test_a_wrong_setting_is_refused_by_name(name, setting, value):
    """One line, with the setting, the value and what was expected."""
    with pytest.raises(ValueError, match=rf"^{setting} is '?{value}'?;.* expected .*\Z"):
        type(load(name))(**{setting: value})


@pytest.mark.parametrize(
    "setting", ["seed=-1", "seed=4294967297", "seed=1.5", "count=0", "count=10000000000"]
)
@pytest.mark.parametrize(
    "name", ["slsqp", "ipopt", "nlp", "multiple-shooting", "penalty", "route-nlp"]
)
def test_a_seed_or_count_out_of_range_is_refused(name, setting):
    key = setting.partition("=")[0]
    with pytest.raises(SolverError, match=key):
        load(f"{name}[initial_guess=random,{setting}]")


@pytest.mark.parametrize(
    "spec", ["penalty[initial_guess=zero]", "headings[engine=cma-es,initial_guess=random]"]
)
def test_a_search_of_the_whole_box_takes_no_guess(spec):
    with pytest.raises(SolverError, match="searches the whole box and takes none"):
        load(spec)


@pytest.mark.parametrize("name", ["/bin/ls", "../ls", "..", "-rf", "a b", "a;b", "ls\n", ""])
def test_an_executable_is_a_name_and_no_path(name):
    """An experiment's text cannot choose a file to run."""
    with pytest.raises(ValueError, match="no folders"):
        Nlp(engine=name)


@pytest.mark.parametrize(
    "spec",
    [
        "slsqp[model=joint,initial_guess=random,count=2]",
        "nlp[engine=nlopt-slsqp,model=joint,initial_guess=random,count=2]",
        "shooting[initial_guess=random,count=2]",
        "multiple-shooting[initial_guess=random,count=1]",
        "penalty[evaluations=300,rounds=1,polish=false]",
        "headings[engine=cma-es,evaluations=300]",
        "headings[engine=slsqp,initial_guess=random,count=3]",
        "route-nlp[initial_guess=random,count=2]",
    ],
)
def test_each_repeat_has_a_seed_of_its_own(spec):
    """The repeats find or spend something else, and each of them always the same."""
    solver = load(spec)

    def found(repeat):
        answer = attempt(solver, Question(PAPER["problem 1"], repeat=repeat), 20.0)
        return answer.evaluations, answer.length

    answers = [found(repeat) for repeat in range(4)]

    assert len(set(answers)) > 1
    assert found(2) == answers[2]
