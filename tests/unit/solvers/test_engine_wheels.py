"""The engines that come with wheels of their own: NLopt, Uno, APOPT."""

from __future__ import annotations

import math
import resource
import tempfile
from functools import cache
from typing import Any

import casadi
import numpy as np
import pytest

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.nlp_engines.expressions import algebra_text
from dubins_study.solvers.nlp_engines.program import Expressions, Program
from dubins_study.study.words import Claim

WHEELS = ("nlopt-slsqp", "nlopt-auglag", "nlopt-cobyla", "uno-filtersqp", "apopt")


@cache
def _expressions() -> Expressions:
    """Problem 7 of Hock and Schittkowski, Test Examples for Nonlinear Programming Codes (1981)."""
    x, p = casadi.SX.sym("x", 2), casadi.SX.sym("p", 1)
    f = casadi.log(1 + x[0] ** 2) - x[1]
    return Expressions(x, p, f, (1 + x[0] ** 2) ** 2 + x[1] ** 2 - p[0])


def _run(name: str, max_iter: int = 200, seconds: float = 10.0) -> Any:
    upper = np.full(2, math.inf)
    program = Program(_expressions(), np.array([4.0]), -upper, upper)
    return ENGINES[name].load()(1e-8, max_iter)(program, np.array([2.0, 2.0]), seconds)


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
    """Its program reserves gigabytes: with a limit of 4 GiB it ended in one run of five."""
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (2**30, limits[1]))
    try:
        statuses = {_run("apopt").status for _ in range(8)}
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, limits)

    assert statuses == {"Successful solution"}


def test_text_means_what_the_expressions_mean(monkeypatch):
    """Python reads the text too; two values of the parameters, long expressions cut in pieces."""
    x, p = casadi.SX.sym("x", 3), casadi.SX.sym("p", 2)
    f = casadi.sin(x[0]) ** 2 - x[1] / p[0] + casadi.sqrt(x[2]) * casadi.exp(-x[0])
    g = casadi.vertcat(p[1] - x[0] * casadi.cos(x[1] - x[2]), (x[0] - 2) ** 3 - 1e-7 * x[2])
    bound = np.full(3, math.inf)
    point = np.array([0.3, -1.7, 2.5])
    scope = {name: getattr(math, name) for name in ("sin", "cos", "sqrt", "exp", "log")}
    scope["x"] = dict(enumerate(point.tolist(), 1))

    for longest in (10, 10_000):
        monkeypatch.setattr("dubins_study.solvers.nlp_engines.expressions._LONGEST", longest)
        for parameters in (np.array([3.0, -2.0]), np.array([-0.5, 1e-9])):
            program = Program(Expressions(x, p, f, g), parameters, -bound, bound)
            text = algebra_text(program)
            names = dict(scope)
            for name, expression in text.intermediates:
                names[name] = eval(expression.replace("^", "**"), names)
            sides = [text.objective, *text.equations]
            sides = [eval(side.replace("^", "**"), names) for side in sides]

            functions = program.functions
            expected = [functions.objective(point), *functions.equations(point)]
            assert sides == pytest.approx(expected, rel=1e-14, abs=1e-15)
            assert bool(text.intermediates) is (longest == 10)
