"""Settings of our own solvers: what is refused, and that a repeat has a seed of its own."""

from __future__ import annotations

import pytest
from cases import PAPER

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.global_minlp.disjunctive import Disjunctive
from dubins_study.solvers.global_minlp.global_nlp import GlobalNlp
from dubins_study.solvers.heading_milp.solver import HeadingMilp
from dubins_study.solvers.indirect.shooting import Shooting
from dubins_study.solvers.optimal_control.collocation import Collocation
from dubins_study.solvers.optimal_control.multiple_shooting import MultipleShooting
from dubins_study.solvers.optimal_control.turn_rate_qp import TurnRateQp
from dubins_study.solvers.optimal_control.turn_rates import TurnRates
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError, load
from dubins_study.solvers.stochastic.penalty import Penalty

NAN = float("nan")
REFUSED = {
    Collocation: {
        **{"n": (2, 4.5), "points": (0,), "max_iter": (True,), "tol": (0,)},
        **{"mesh": ("fine",), "via": ("mail",)},
    },
    Disjunctive: {
        **{"engine": ("highs",), "transformation": ("cuttingplane",), "emphasis": ("fast",)},
        **{"gap": (0.0,), "feastol": (-1e-6,)},
    },
    GlobalNlp: {"engine": ("baron",), "gap": (0.1,), "feastol": (1e-12,), "model": ("both",)},
    HeadingMilp: {
        **{"engine": ("maingo",), "headings": (3, 1001, 72.0, True), "legs": (0,), "gap": (0.0,)}
    },
    MultipleShooting: {
        **{"n": (2, 4.5), "max_iter": (True,), "tol": (0,), "count": (0,), "seed": (-1,)},
        **{"engine": ("cplex",), "mesh": ("graded",), "integrator": ("euler",)},
        **{"initial_guess": ("warm",)},
    },
    Penalty: {
        **{"seed": (-1,), "evaluations": (-1, 10_000_000), "rounds": (0,), "count": (0,)},
        **{"engine": ("nope",), "order": ("SLR",), "weight": (0.0, NAN)},
        **{"initial_guess": ("given",)},
    },
    Shooting: {
        **{"initial_guess": ("sobol",), "root": ("newton",), "tol": (0.0,)},
        **{"count": (0,), "seed": (-1,)},
    },
    TurnRateQp: {
        **{"n": (1, 2.5), "tolerance": (0,), "max_qps": (0,)},
        **{"engine": ("cplex",), "mesh": ("fine",)},
    },
    TurnRates: {"n": (2,), "mesh": ("free",), "engine": ("piqp",)},
}


@pytest.mark.parametrize(
    ("solver", "name", "value"),
    [(k, name, value) for k, wrong in REFUSED.items() for name in wrong for value in wrong[name]],
)
def test_a_wrong_setting_is_refused_by_name(solver, name, value):
    """One line, with the setting, the value and what was expected."""
    with pytest.raises(ValueError, match=rf"^{name} is '?{value}'?;.* expected .*\Z"):
        solver(**{name: value})


@pytest.mark.parametrize(
    "setting", ["seed=-1", "seed=4294967297", "seed=1.5", "count=0", "count=10000000000"]
)
@pytest.mark.parametrize("name", ["slsqp", "ipopt", "nlp", "multiple-shooting", "penalty"])
def test_a_seed_or_count_out_of_range_is_refused(name, setting):
    key = setting.partition("=")[0]
    with pytest.raises(SolverError, match=key):
        load(f"{name}[initial_guess=random,{setting}]")


def test_a_search_of_the_whole_box_takes_no_guess():
    with pytest.raises(SolverError, match="searches the whole box and takes none"):
        load("penalty[initial_guess=zero]")


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
