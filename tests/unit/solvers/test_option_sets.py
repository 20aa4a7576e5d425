"""Options of each engine in the three sets.

Each library is called by hand beside them.

The engines that come with wheels of their own: NLopt, Uno, APOPT.
"""

import importlib
import math
import re
import resource
import tempfile
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest
import scipy.optimize

from dubins_study.asking.attempt import attempt
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, names
from dubins_study.solvers.nlp_engines.expressions import algebra_text
from dubins_study.solvers.nlp_engines.program import Expressions, Program
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.solvers.setting_checks import FEASIBILITY, OPTIMALITY, OPTION_SETS
from dubins_study.solvers.stochastic.penalty_function import CountedFunction, Task
from dubins_study.study.words import DERIVATIVE_FREE, ROOTS, SAMPLING, Claim
from tests.cases import PAPER, engine_params


def program() -> Program:
    """Problem 7 of Hock and Schittkowski.

    Test Examples for Nonlinear Programming Codes (1981).
    """
    x = casadi.SX.sym("x", 2)
    p = casadi.SX.sym("p", 1)
    f = casadi.log(1 + x[0] ** 2) - x[1]
    written = Expressions(x, p, f, (1 + x[0] ** 2) ** 2 + x[1] ** 2 - p[0])
    upper = np.full(2, math.inf)
    return Program(written, np.array([4.0]), -upper, upper)


GUESS = np.array([2.0, 2.0])


def by_hand(method: str, options: dict[str, Any]) -> Any:
    """SciPy without any of our code.

    Functions, derivatives and options are written out.
    """
    jac = method != "COBYQA"
    return scipy.optimize.minimize(
        lambda x: math.log(1 + x[0] ** 2) - x[1],
        GUESS,
        method=method,
        jac=(lambda x: np.array([2 * x[0] / (1 + x[0] ** 2), -1.0])) if jac else None,
        constraints={
            "type": "eq",
            "fun": lambda x: np.array([(1 + x[0] ** 2) ** 2 + x[1] ** 2 - 4]),
            **(
                {"jac": lambda x: np.array([[4 * x[0] * (1 + x[0] ** 2), 2 * x[1]]])} if jac else {}
            ),
        },
        options=options,
    )


@pytest.mark.parametrize(
    ("options", "tol", "max_iter", "same"),
    [
        ("default", 0.0, 0, {}),
        ("tuned", 0.0, 0, {}),
        ("equal", 0.0, 0, {"ftol": 1e-9}),
        ("default", 1e-3, 0, {"ftol": 1e-3}),
        ("equal", 0.0, 3, {"ftol": 1e-9, "maxiter": 3}),
    ],
)
def test_slsqp_has_the_options_of_its_set_and_no_others(options, tol, max_iter, same):
    """SLSQP has its set's options, no others.

    Its iterates are those of SciPy called by hand, to the last digit but rounding.
    """
    ours = ENGINES["slsqp"].load()(tol, max_iter, options)(program(), GUESS, 10.0)
    hand = by_hand("SLSQP", same)

    assert (ours.iterations, ours.evaluations) == (hand.nit, hand.nfev)
    assert ours.x == pytest.approx(hand.x, abs=1e-12)


def test_cobyqa_s_last_radius_is_its_makers():
    ours = ENGINES["cobyqa"].load()(options="default")(program(), GUESS, 10.0)
    hand = by_hand("COBYQA", {})

    assert ours.evaluations == hand.nfev
    assert ours.x == pytest.approx(hand.x, abs=1e-9)


@pytest.mark.parametrize("options", OPTION_SETS)
@pytest.mark.parametrize("engine", ["ipopt", "uno", "fatrop", "alpaqa", "sqpmethod", "qrsqp"])
def test_casadi_gets_the_options_of_the_set(engine, options, monkeypatch):
    """casadi gets the options of the set.

    They reach `casadi.nlpsol`, beside casadi's own; the makers' set adds only silence.
    """
    seen: list[dict[str, Any]] = []
    make = casadi.nlpsol
    monkeypatch.setattr(casadi, "nlpsol", lambda *args: seen.append(args[-1]) or make(*args))
    ENGINES[engine].load()(options=options)(program(), GUESS, 10.0)

    flat = {
        f"{name}.{inner}" if isinstance(value, dict) else name: given
        for name, value in seen[0].items()
        for inner, given in (value.items() if isinstance(value, dict) else [("", value)])
    }
    table = ENGINES[engine].options
    expected = dict(table.always)
    if options == "equal":
        expected |= dict.fromkeys((*table.feasibility, *table.optimality), 1e-9)
    if options == "tuned":
        expected |= table.tuned
    added = {"print_time", "expand", "show_eval_warnings", "calc_lam_p", "jac_fg", "hess_lag"}
    assert {name: value for name, value in flat.items() if name not in added} == expected


def test_equal_is_one_tolerance_for_all():
    """`equal` is one tolerance for all.

    Every engine that takes a tolerance is asked for the same one.
    """
    assert FEASIBILITY == OPTIMALITY == 1e-9
    assert {ENGINES[name].tolerance("equal") for name in NLP_ENGINES} == {1e-9}
    assert ENGINES["ipopt"].tolerance("default") is None


@pytest.mark.parametrize("name", ["slsqp", "ipopt", "nlp[engine=uno]"])
def test_explicit_settings_win(name):
    base, _, rest = name.partition("[")
    word = "ftol" if base == "slsqp" else "tol"
    inner = f"{rest.rstrip(']')}," if rest else ""

    for options in OPTION_SETS:
        solver = load(f"{base}[{inner}options={options},{word}=1e-5]")
        assert solver.method.tolerance == 1e-5


def test_nlopt_claims_a_solution_only_where_the_equations_hold(monkeypatch):
    """NLopt claims solutions only where equations hold.

    NLopt calls small steps a success; here they are small at the guess, off the equation.
    """
    nlopt = pytest.importorskip("nlopt")
    adapter = importlib.import_module("dubins_study.solvers.nlp_engines.nlopt_local")
    always = {"xtol_rel": 1e6, "constraint_tol": 1e-8}
    result = adapter.nlopt(always, "LN_COBYLA")(program(), GUESS, 10.0)

    assert result.status == "XTOL_REACHED"
    assert abs((1 + result.x[0] ** 2) ** 2 + result.x[1] ** 2 - 4) > 1e-3
    assert result.claim is Claim.FAILED
    assert nlopt.XTOL_REACHED > 0  # a success, in NLopt's words


@pytest.mark.parametrize("options", OPTION_SETS)
def test_a_search_has_the_options_of_its_set(options, monkeypatch):
    """A search has the options of its set.

    Nothing is chosen for this problem: SciPy's own strategy is taken, or the one of its inventors.
    """
    seen: dict[str, Any] = {}
    monkeypatch.setattr(
        scipy.optimize,
        "differential_evolution",
        lambda *_, **given: seen.update(given) or scipy.optimize.OptimizeResult(message="", x=None),
    )
    function = CountedFunction(_Parabola(), 10, math.inf)
    Task(function, None, np.random.default_rng(0)).search("differential-evolution", options)

    chosen = {name: value for name, value in seen.items() if name not in ("maxiter", "rng")}
    assert (
        chosen
        == {
            "equal": {"tol": 1e-9, "atol": 1e-9},
            "default": {},
            "tuned": {
                **{"strategy": "rand1bin", "popsize": 10, "mutation": 0.5, "recombination": 0.9},
                **{"vectorized": True, "updating": "deferred"},
            },
        }[options]
    )


@pytest.mark.parametrize("options", OPTION_SETS)
@pytest.mark.parametrize("root", names(ROOTS))
def test_minpack_has_the_options_of_its_set(root, options, monkeypatch):
    """MINPACK has the options of its set.

    They are as the page of engines has them; the makers' sets leave all of them to MINPACK.
    """
    page = (Path(__file__).parents[3] / "docs/engines.md").read_text(encoding="utf-8")
    row = next(line for line in page.splitlines() if line.startswith(f"| `{root}` | `equal`"))
    told = {name: float(value) for name, value in re.findall(r"`(\w+)=([^`]+)`", row)}
    seen: list[dict[str, Any]] = []
    solve = scipy.optimize.root
    monkeypatch.setattr(
        scipy.optimize,
        "root",
        lambda *args, **given: seen.append(given["options"]) or solve(*args, **given),
    )
    attempt(load(f"shooting[root={root},options={options}]"), Question(PAPER["problem 1"]))

    assert seen
    expected = told if options == "equal" else {}
    assert all(given == pytest.approx(expected) for given in seen)


class _Parabola:
    upper = np.full(2, 2.0)

    def at(self, free: np.ndarray) -> float:
        return float((free**2).sum())

    def at_each(self, free: np.ndarray) -> np.ndarray:
        return (free**2).sum(axis=0)


@pytest.mark.many(3)
@pytest.mark.parametrize("options", OPTION_SETS)
@pytest.mark.parametrize("engine", engine_params(names(SAMPLING, DERIVATIVE_FREE)))
def test_every_search_goes_downhill_with_every_set(engine, options):
    if ENGINES[engine].unavailable():
        pytest.skip("not installed")
    function = CountedFunction(_Parabola(), 3000, math.inf)
    Task(function, np.array([1.0, 1.5]), np.random.default_rng(0)).search(engine, options)

    assert function.value < 1e-3


def test_scip_as_its_makers_have_it(monkeypatch):
    """SCIP has its makers' settings.

    docs/engines.md: with these settings SCIP has its own defaults, but for the gap: 0.
    """
    pyscipopt = pytest.importorskip("pyscipopt")
    given: dict[str, Any] = {}
    set_param = pyscipopt.Model.setParam
    defaults = pyscipopt.Model().getParams()

    class Model(pyscipopt.Model):
        def setParam(self, name: str, value: Any) -> None:  # noqa: N802
            given[name] = value
            set_param(self, name, value)

    monkeypatch.setattr(pyscipopt, "Model", Model)
    solver = load("global-nlp[engine=scip,gap=1e-12,feastol=1e-6,emphasis=default]")
    attempt(solver, Question(PAPER["problem 1"]), 20.0)

    differing = {name for name, value in given.items() if value != defaults[name]}
    assert differing <= {"limits/gap", "limits/time", "misc/catchctrlc"}
    assert (given["limits/gap"], defaults["limits/gap"]) == (1e-12, 0.0)
    assert given["numerics/feastol"] == defaults["numerics/feastol"]


WHEELS = ("nlopt-slsqp", "nlopt-auglag", "nlopt-cobyla", "uno-filtersqp", "apopt")


def _run(name: str, max_iter: int = 200, seconds: float = 10.0) -> Any:
    return ENGINES[name].load()(1e-8, max_iter)(program(), GUESS, seconds)


@pytest.mark.parametrize("name", WHEELS)
def test_too_few_iterations_are_a_limit(name):
    assert _run(name, max_iter=1).claim is Claim.LIMIT


def test_a_program_is_stopped_and_its_folder_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    stopped = _run("apopt", seconds=1e-3)
    solved = _run("apopt")

    assert (stopped.claim, solved.claim) == (Claim.LIMIT, Claim.LOCAL)
    assert np.isnan(stopped.x).all()
    assert list(tmp_path.iterdir()) == []


def test_apopt_within_a_worker_s_memory_limit():
    """APOPT works within a worker's memory limit.

    Its program reserves gigabytes: with a limit of 4 GiB it ended in one run of five.
    """
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (2**30, limits[1]))
    try:
        statuses = {_run("apopt").status for _ in range(8)}
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, limits)

    assert statuses == {"Successful solution"}


def test_text_means_what_the_expressions_mean(monkeypatch):
    """Text means what the expressions mean.

    Python reads the text too; there are two values of the parameters, and long expressions cut in
    pieces.
    """
    x = casadi.SX.sym("x", 3)
    p = casadi.SX.sym("p", 2)
    f = casadi.sin(x[0]) ** 2 - x[1] / p[0] + casadi.sqrt(x[2]) * casadi.exp(-x[0])
    f += x[2] ** 1.5 + casadi.log(x[2]) + 1 / x[0] + x[0] ** x[2] + 2 * casadi.tan(p[0])
    f += casadi.atan(x[1]) - casadi.asin(0.1 * x[2]) * casadi.acos(x[0])
    g = casadi.vertcat(p[1] - x[0] * casadi.cos(x[1] - x[2]), (x[0] - 2) ** 3 - 1e-7 * x[2])
    bound = np.full(3, math.inf)
    point = np.array([0.3, -1.7, 2.5])
    scope = dict(vars(math))
    scope["x"] = dict(enumerate(point.tolist(), 1))

    for longest in (10, 10_000):
        monkeypatch.setattr("dubins_study.solvers.nlp_engines.expressions._LONGEST", longest)
        for parameters in (np.array([3.0, -2.0]), np.array([-0.5, 1e-9])):
            posed = Program(Expressions(x, p, f, g), parameters, -bound, bound)
            text = algebra_text(posed)
            names = dict(scope)
            for name, expression in text.intermediates:
                names[name] = eval(expression.replace("^", "**"), names)
            sides = [text.objective, *text.equations]
            sides = [eval(side.replace("^", "**"), names) for side in sides]

            functions = posed.functions
            expected = [functions.objective(point), *functions.equations(point)]
            assert sides == pytest.approx(expected, rel=1e-14, abs=1e-15)
            assert bool(text.intermediates) is (longest == 10)
