"""`examples/licensed_engines.py`, tested without a licence.

It has engines that need a licence, as a plug-in.
"""

import importlib.util
import math
import sys
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from dubins_study.asking.attempt import attempt
from dubins_study.solvers.minlp_engines.mixed_program import MixedProgram, Row, Settings, Written
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError, canonical, entry, load
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Verdict

FILE = Path(__file__).parents[3] / "examples" / "licensed_engines.py"
SETTINGS = Settings(1e-6, 1e-6)
PACKAGES = {"gurobi": "gurobipy", "xpress": "xpress"}
SOLVERS = ("GlobalNlp", "Disjunctive", "HeadingMilp")


def spec(solver, **settings):
    written = ",".join(f"{name}={value}" for name, value in settings.items())
    return f"{FILE}:{solver}[{written}]"


def module():
    """The plug-in's module, as the registry has loaded it."""
    return sys.modules[type(load(f"{FILE}:GlobalNlp")).__module__]


def linear(n):
    """A linear program of n variables and equations.

    Its optimum is n.
    """

    def write(x, functions):
        return Written(sum(x), [Row(variable, 1.0, 1.0) for variable in x])

    return MixedProgram(np.zeros(n), np.full(n, 2.0), np.zeros(n, bool), write)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("engine", PACKAGES)
def test_it_loads_and_says_why_it_cannot_run(solver, engine, monkeypatch):
    find = importlib.util.find_spec
    absent = PACKAGES[engine]
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == absent else find(name)
    )
    asked = spec(solver, engine=engine)
    listed = entry(asked)

    assert listed.reason == f"the package {absent} is not installed"
    assert listed.engine.lower() == engine
    assert attempt(load(asked), Question(Scenario(0, 0, 0, 3, 2, 1))).outcome == "unavailable"


def test_a_spec_of_rows_names_what_differs_and_the_packages_own_engines_are_not_taken():
    assert canonical(spec("GlobalNlp", engine="gurobi")) == f"{FILE}:GlobalNlp"
    with pytest.raises(SolverError, match="expected one of: gurobi, xpress"):
        load(spec("GlobalNlp", engine="scip"))


class Variable(float):
    """A variable that has its value from the beginning."""

    @property
    def X(self):  # noqa: N802  (Gurobi's name)
        return float(self)


class Model:
    """A stand-in for `gurobipy.Model`.

    It knows its answer: z = (1, 0, 2).
    """

    Status = 2
    SolCount = 1
    NodeCount = 5
    IterCount = 7
    ObjBound = 2.9

    def __init__(self, env):
        self.Params = SimpleNamespace()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def addMVar(self, n, lower, upper, vtype):  # noqa: N802
        values = [Variable(value) for value in (1.0, 0.0, 2.0, 1.0)[:n]]
        return SimpleNamespace(tolist=lambda: values)

    def setObjective(self, objective):  # noqa: N802
        self.objective = objective

    def addConstr(self, relation):  # noqa: N802
        pass

    def optimize(self):
        assert self.objective == 3.0
        assert (self.Params.Threads, self.Params.MIPGap, self.Params.TimeLimit) == (1, 1e-6, 5.0)


@pytest.fixture
def gurobipy(monkeypatch):
    """A stand-in for the package."""
    status = SimpleNamespace(OPTIMAL=2, INFEASIBLE=3, TIME_LIMIT=9, INTERRUPTED=11, WORK_LIMIT=16)
    library = SimpleNamespace(
        GRB=SimpleNamespace(BINARY="B", CONTINUOUS="C", Status=status),
        GurobiError=type("GurobiError", (Exception,), {"errno": 10009}),
        NLExpr=type("NLExpr", (), {}),
        Model=type("Mine", (Model,), {}),
        Env=lambda params: nullcontext(),
        nlfunc=math,
    )
    monkeypatch.setitem(sys.modules, "gurobipy", library)
    environment = module().gurobi_environment
    environment.cache_clear()
    yield library
    environment.cache_clear()


@pytest.mark.parametrize(
    ("status", "points", "claim", "bound"),
    [
        (2, 1, Claim.OPTIMAL, 2.9),
        (3, 0, Claim.INFEASIBLE, math.inf),
        (9, 0, Claim.LIMIT, 2.9),
        (9, 1, Claim.LIMIT, 2.9),
        (16, 1, Claim.FEASIBLE, 2.9),  # a status without a claim of its own, and a point
        (16, 0, Claim.FAILED, 2.9),
    ],
)
def test_what_gurobi_says_is_what_is_claimed(gurobipy, status, points, claim, bound):
    gurobipy.Model.Status, gurobipy.Model.SolCount = status, points
    result = module().gurobi(SETTINGS)(three(), 5.0)

    assert (result.claim, result.bound) == (claim, bound)
    assert (result.nodes, result.iterations) == (5, 7)
    assert (result.x is None) == (points == 0)


def three():
    def write(x, functions):
        return Written(sum(x), [Row(x[0] + functions.sin(x[1]), 1.0, 1.0)])

    return MixedProgram(np.zeros(3), np.full(3, 9.0), np.zeros(3, bool), write)


def test_a_licence_that_has_expired_is_a_message(gurobipy):
    def expired(params):
        raise gurobipy.GurobiError("License expired 2020-01-01")

    gurobipy.Env = expired
    result = module().gurobi(SETTINGS)(linear(2), 20.0)

    assert (result.claim, result.x) == (Claim.FAILED, None)
    assert "License expired" in result.message


def test_ctrl_c_is_raised_again(gurobipy):
    gurobipy.Model.Status = 11
    with pytest.raises(KeyboardInterrupt):
        module().gurobi(SETTINGS)(three(), 5.0)


INSTALLED = [name for name, package in PACKAGES.items() if importlib.util.find_spec(package)]


@pytest.mark.parametrize("engine", INSTALLED)
@pytest.mark.parametrize("model", ["joint", "words"])
def test_where_it_is_installed_it_proves_the_optimum(engine, model, capfd):
    """An installed engine proves the optimum.

    It has the size-limited licence of its wheel, and is silent.
    """
    solver = load(spec("GlobalNlp", engine=engine, model=model, gap=1e-4, feastol=1e-6))
    answer = attempt(solver, Question(Scenario(0, 0, 0, 3, 2, 1)), 20.0)

    assert (answer.claim, answer.verdict) == (Claim.OPTIMAL, Verdict.OPTIMAL), answer.message
    assert answer.reference * (1 - 2e-4) <= answer.lower_bound <= answer.reference + 1e-5
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("engine", INSTALLED)
def test_a_program_too_large_for_the_licence_is_a_message(engine):
    """A program too large gives a message.

    The wheels' licences end at 2 000 (Gurobi) and 5 000 (Xpress) variables and constraints.
    """
    result = getattr(module(), engine)(SETTINGS)(linear(6000), 20.0)

    if result.claim is Claim.OPTIMAL:  # here is a licence without limits
        assert result.bound == pytest.approx(6000)
    else:
        assert result.claim is Claim.FAILED
        assert any(words in result.message for words in ("size-limited license", "maximum is"))
