"""The engines that prove bounds: licences, statuses, and programs with binaries."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES
from dubins_study.solvers.minlp_engines.program import MixedProgram, Row, Settings, Written
from dubins_study.study.words import Claim

INSTALLED = [name for name in MINLP_ENGINES if ENGINES[name].unavailable() is None]
SETTINGS = Settings(1e-6, 1e-6)


def linear(n):
    """A linear program of n variables and n equations, whose optimum is n."""

    def write(x, functions):
        return Written(sum(x), [Row(variable, 1.0, 1.0) for variable in x])

    return MixedProgram(np.zeros(n), np.full(n, 2.0), np.zeros(n, bool), write)


@pytest.mark.parametrize("name", INSTALLED)
@pytest.mark.parametrize("lean", [False, True])
def test_a_program_with_binaries_and_curves(name, lean):
    """min x - b with x >= sin(2) b, b binary, x^2 + cos(x) <= 2: the bound meets the optimum.

    For b = 1 the least x is sin(2) = 0.909, whose square and cosine add up to 1.44: the optimum
    is sin(2) - 1; for b = 0 it is 0.
    """

    def write(x, functions):
        curve = x[0] ** 2 + functions.cos(x[0]) - 2
        rows = [Row(x[0] - math.sin(2) * x[1], 0.0, 9.0), Row(curve, -math.inf, 0.0)]
        return Written(x[0] - x[1], rows)

    program = MixedProgram(np.zeros(2), np.array((3.0, 1.0)), np.array((False, True)), write)
    result = ENGINES[name].load()(Settings(1e-6, 1e-6, lean))(program, 20.0)

    assert result.claim is Claim.OPTIMAL
    assert result.x == pytest.approx([math.sin(2), 1], abs=1e-5)
    assert result.bound == pytest.approx(math.sin(2) - 1, abs=1e-5)
    assert result.nodes is None or result.nodes >= 0


@pytest.mark.parametrize("name", INSTALLED)
def test_what_has_no_point_is_infeasible(name):
    """x = y and x = y + 2 - sin(x) / 10 cannot both be."""

    def write(x, functions):
        return Written(x[0], [Row(x[0] - x[1]), Row(x[0] - x[1] - 2 + functions.sin(x[0]) / 10)])

    program = MixedProgram(np.zeros(2), np.full(2, 3.0), np.zeros(2, bool), write)
    result = ENGINES[name].load()(SETTINGS)(program, 20.0)

    assert result.claim is Claim.INFEASIBLE
    assert result.x is None
    assert result.bound == math.inf


@pytest.mark.parametrize("name", [name for name in ("gurobi", "xpress") if name in INSTALLED])
def test_a_program_too_large_for_the_licence_is_a_message(name):
    """The wheels' licences end at 2 000 (Gurobi) and 5 000 (Xpress) variables and constraints."""
    result = ENGINES[name].load()(SETTINGS)(linear(6000), 20.0)

    if result.claim is Claim.OPTIMAL:  # here is a licence without limits
        assert result.bound == pytest.approx(6000)
    else:
        assert result.claim is Claim.FAILED
        assert result.x is None
        assert any(words in result.message for words in ("size-limited license", "maximum is"))


@pytest.mark.skipif("gurobi" not in INSTALLED, reason="gurobipy is not installed")
def test_a_licence_that_has_expired_is_a_message(monkeypatch):
    import gurobipy

    from dubins_study.solvers.minlp_engines import gurobi

    def expired():
        raise gurobipy.GurobiError(10009, "License expired 2020-01-01")

    monkeypatch.setattr(gurobi, "_environment", expired)
    result = ENGINES["gurobi"].load()(SETTINGS)(linear(2), 20.0)

    assert result.claim is Claim.FAILED
    assert "License expired" in result.message


@pytest.mark.skipif("xpress" not in INSTALLED, reason="xpress is not installed")
def test_a_licence_that_is_missing_is_a_message(monkeypatch):
    import xpress as library

    from dubins_study.solvers.minlp_engines import xpress

    def missing():
        raise library.InterfaceError("Failed to initialise: no licence")

    monkeypatch.setattr(xpress, "_start", missing)
    result = ENGINES["xpress"].load()(SETTINGS)(linear(2), 20.0)

    assert result.claim is Claim.FAILED
    assert "no licence" in result.message
