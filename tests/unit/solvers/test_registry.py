"""Solvers by name, by settings and by file.

Refusals are tested too; a repeat has a seed of its own.
"""

import math
from dataclasses import fields

import pandas as pd
import pytest

from dubins_study.asking.attempt import attempt
from dubins_study.experiments.code_digest import code_digest
from dubins_study.experiments.solve import solve, solve_frame
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.protocol import Method, Question
from dubins_study.solvers.registry import SolverError, canonical, load, registered, settings
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ProfileError
from dubins_study.study.words import Outcome
from tests.cases import PAPER

EASY = Scenario(0, 0, 0.3, 3, 2, 1)
FRAME_ROW = dict.fromkeys(["x", "y", "heading", "target_y"], 0.0) | {"radius": 1.0}
WRONG_PLUGINS = """
from dubins_study import Claim, Solution, Solver

class Stranger:
    name, solve = "stranger", None

class Nameless(Solver):
    def solve(self, question, limit): return Solution(Claim.NONE)

class Idle(Solver):
    name = "idle"

class Unmade(Solver):
    name = method = guarantee = summary = "unmade"
    solve = None
    def __init__(self): raise OSError("no")

class Packed(Solver):
    name, solve, packages = "packed", None, None

class Branched(Solver):
    name, solve, branches = "branched", None, ("best", 3)

class Profiled(Solver):
    name, solve, profiles = "profiled", None, 3
"""
SHORTEST_PLUGIN = """\
from dataclasses import dataclass
from dubins_study import Claim, Path, Solution, Solver
@dataclass(frozen=True)
class Ahead(Solver):
    name = "ahead"
    far: float = 1.0
    def solve(self, question, limit):
        return Solution(Claim.FEASIBLE, Path(question.scenario.start, [0.0], [self.far]))
"""


ANNOTATED_PLUGIN = """\
from __future__ import annotations
from dataclasses import dataclass
from typing import ClassVar
from dubins_study.solvers.protocol import Guarantee, Solution, Solver
from dubins_study.study.words import Claim
@dataclass(frozen=True)
class Plug(Solver):
    n: int = {answer}
    name: ClassVar[str] = "plug"
    guarantee: ClassVar[Guarantee] = Guarantee.LOCAL
    def unavailable(self): raise OSError("no such luck")
    def solve(self, question, limit): return Solution(Claim.NONE)
"""


def test_settings_are_read_by_the_type_of_their_default():
    solver = load("ipopt[tol=1e-6,capped=false,initial_guess=random,count=3]")

    assert settings(solver) | {
        "tol": 1e-6,
        "capped": False,
        "initial_guess": "random",
        "count": 3,
    } == (settings(solver))


@pytest.mark.parametrize(
    ("spec", "profile", "written"),
    [
        ("slsqp[count=10]", "default", "slsqp"),
        (
            *(" slsqp[ initial_guess = zero , model=joint]", "default"),
            "slsqp[model=joint,initial_guess=zero]",
        ),
        ("ipopt[tol=0.000001]", "default", "ipopt[tol=1e-06]"),
        ("ipopt[tol=0]", "default", "ipopt"),
        # what is asked for explicitly is kept where the profile says otherwise
        ("ipopt[tol=1e-8]", "accurate", "ipopt[tol=1e-08]"),
        ("ipopt[tol=1e-11]", "accurate", "ipopt"),
        ("slsqp[ftol=1e-5]", "fast", "slsqp[ftol=1e-05]"),
        # `nlp` names its engine: what a row asked does not change with the default
        ("nlp", "default", "nlp[engine=ipopt]"),
        ("nlp[model=joint,engine=ipopt]", "fast", "nlp[engine=ipopt,model=joint]"),
    ],
)
def test_canonical_specs(spec, profile, written):
    """Canonical specs of solvers.

    Defaults are left out but for `always_named`, in the order of the declaration.
    """
    assert canonical(spec, profile) == canonical(written, profile) == written
    assert load(written, profile) == load(spec, profile)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("nope", "no solver named 'nope'; choose one of: analytic"),
        ("nope", "or give file.py:Class; `dubins-study solvers` tells what each is"),
        ("slsqp[", "does not parse"),
        ("slsqp[ftol]", "'ftol' does not parse; expected setting=value"),
        ("slsqp[foo=1]", "has no setting 'foo'; it has: model, order"),
        ("slsqp[count=two]", "count is 'two'; expected int, such as 10"),
        ("slsqp[capped=perhaps]", "capped is 'perhaps'; expected bool"),
        ("slsqp[initial_guess=here]", "initial_guess is 'here'; expected one of: bearing"),
        ("turn-rate-qp[engine=nope]", "engine"),
        ("turn-rate-qp[n=0]", "n"),
        ("missing.py:Class", "no file 'missing.py'; expected file.py:Class"),
    ],
)
def test_what_cannot_be_loaded(spec, message):
    with pytest.raises(SolverError) as error:
        solve(EASY, spec)

    assert message in str(error.value)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Stranger", "is no solver; expected a frozen"),
        ("Nameless", "is no solver; .* with a name and solve"),
        ("Idle", "is no solver; .* with a name and solve"),
        ("Nothing", "has no class 'Nothing'; it has: Nameless, Idle"),
        ("Unmade", "cannot be made: OSError"),
        ("Packed", "packages is None; expected texts"),
        ("Branched", r"branches is \('best', 3\); expected texts"),
        ("Profiled", "profiles is 3; expected a dict"),
    ],
)
def test_plug_ins_that_do_not_keep_the_promise(tmp_path, name, message):
    (tmp_path / "wrong.py").write_text(WRONG_PLUGINS)

    with pytest.raises(SolverError, match=message):
        load(f"{tmp_path / 'wrong.py'}:{name}")


def test_a_plug_in_that_raises_when_it_is_loaded(tmp_path):
    (tmp_path / "broken.py").write_text("1/0")

    with pytest.raises(SolverError, match="ZeroDivisionError"):
        load(f"{tmp_path / 'broken.py'}:Any")


def test_a_plug_in_in_eight_lines(tmp_path):
    """A plug-in in eight lines works.

    A name and `solve` are enough; what is left out has the defaults of the base class.
    """
    assert len(SHORTEST_PLUGIN.splitlines()) == 8
    (tmp_path / "ahead.py").write_text(SHORTEST_PLUGIN)
    spec = f"{tmp_path / 'ahead.py'}:Ahead[far=3]"
    answer = solve(Scenario(target_x=3, target_y=0), spec)

    assert (answer.verdict, answer.claim, answer.length) == ("optimal", "feasible", 3.0)
    assert solve(EASY, spec, "LS").outcome is Outcome.UNSUPPORTED
    assert solve_frame(pd.DataFrame([{**FRAME_ROW, "target_x": 3.0}]), spec)["miss"].tolist() == [0]
    solver = load(spec)
    assert (solver.method, solver.guarantee, solver.warm) == (Method(), "local", False)
    assert (solver.packages, solver.variants, solver.profiles, solver.runs) == ((), (), {}, None)
    assert solver.unavailable() is None
    assert solver.library_versions() == {}
    assert code_digest(spec) != code_digest(spec.replace("far=3", "far=4"))


def test_a_plug_in_may_look_like_our_own(tmp_path):
    """A plug-in may look like our own.

    It has postponed annotations and ClassVars, as CONTRIBUTING shows; two files of one name are
    two modules.
    """
    for folder, answer in (("one", 1), ("two", 2)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "plug.py").write_text(ANNOTATED_PLUGIN.format(answer=answer))
    classes = [load(f"{tmp_path / folder / 'plug.py'}:Plug") for folder in ("one", "two")]

    assert [solver.n for solver in classes] == [1, 2]
    answer = solve(EASY, f"{tmp_path / 'one' / 'plug.py'}:Plug")
    assert answer.outcome is Outcome.UNAVAILABLE
    assert "raised OSError: no such luck" in answer.message


def test_a_profile_that_there_is_not():
    with pytest.raises(ProfileError, match="no profile named 'slow'; choose one of: default"):
        solve(EASY, profile="slow")


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
    """A wrong setting is refused by name.

    One line has the setting, the value and what was expected.
    """
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
        "collocation[initial_guess=random,count=1]",
        "turn-rates[initial_guess=random,count=1,n=20]",
        "penalty[evaluations=300,rounds=1,polish=false]",
        "headings[engine=cma-es,evaluations=300]",
        "headings[engine=slsqp,initial_guess=random,count=3]",
        "route-nlp[initial_guess=random,count=2]",
    ],
)
def test_each_repeat_has_a_seed_of_its_own(spec):
    """Each repeat has a seed of its own.

    The repeats find or spend something else, and each of them always the same.
    """
    solver = load(spec)

    def found(repeat):
        answer = attempt(solver, Question(PAPER["problem 1"], repeat=repeat), 20.0)
        return answer.evaluations, answer.length

    answers = [found(repeat) for repeat in range(4)]

    assert len(set(answers)) > 1
    assert found(2) == answers[2]
