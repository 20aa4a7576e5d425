"""The bias in the segments: numbers by hand, and the section."""

from __future__ import annotations

import math

import numpy as np

from dubins_study.report.topics.bias import barrier, bias_section, last_barrier
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt

TOLD = "ipopt[model=joint,order=LRS,units=scenario,mu_target={}]"
DEFAULT = "ipopt[model=joint,order=LRS,units=scenario,options=default]"
SPLIT, ACTIVE = "slsqp[units=scenario]", "slsqp[model=joint,order=LRS]"


def behind(radius):
    """LS is shortest."""
    return Scenario(0, 0, 0, -3 * radius, 4 * radius, radius, label="behind")


def left(scenario, solver, right, claim=Claim.LOCAL):
    """An answer with so long a right turn in it, put where LS begins: it arrives."""
    if right == 0:
        return attempt(scenario, solver, claim=claim)
    R = scenario.radius
    first = Path(scenario.start, [-1 / R], [right])
    pose = first.end
    rest = shortest_path(
        Scenario(*pose, scenario.target_x, scenario.target_y, R),
        "LS",
    )
    path = Path(scenario.start, [-1 / R, *rest.curvatures], [right, *rest.lengths])
    return attempt(scenario, solver, path=path, claim=claim)


def by_theory(factor=1.0):
    """Answers with `factor` times the predicted turn, at two barriers and three radii; then what
    the defaults leave and what methods without a barrier leave."""
    rows = [
        left(behind(R), TOLD.format(mu), factor * (mu * R**2) ** (1 / 3))
        for mu in (1e-9, 1e-6)
        for R in (0.1, 1.0, 10.0)
    ]
    mu = last_barrier(1e-8)
    rows.append(left(behind(1.0), DEFAULT, factor * mu ** (1 / 3), claim=Claim.FAILED))
    rows += [left(behind(R), ACTIVE, z2) for R, z2 in ((0.1, 0.0), (1.0, 1e-3))]
    return [*rows, left(behind(1.0), SPLIT, 0.0)]


def test_whose_barrier_is_known():
    """Ipopt's on the unsplit model, from its settings; nobody else's."""
    settings = {
        "ipopt[a]": {"model": "joint", "mu_target": 1e-5, "tol": 1e-12},
        "ipopt[b]": {"model": "joint", "mu_target": 0.0, "tol": 1e-6},
        "ipopt": {"model": "words", "mu_target": 0.0, "tol": 1e-8},
        "ipopt[d]": {"model": "joint", "mu_target": 0.0, "tol": 0.0, "options": "equal"},
        "slsqp[c]": {"model": "joint"},
    }

    known = [barrier(spec, settings) for spec in (*settings, "unheard-of")]

    np.testing.assert_allclose(known, [1e-5, 1e-6 / 11, math.nan, 1e-9 / 11, math.nan, math.nan])


def test_the_section_says_what_the_rows_say(load_rows):
    """Where the prediction holds it says so, with numbers; where it does not, not.

    A part of the rows is enough.
    """
    lost = attempt(behind(5.0), TOLD.format(1e-9), path=None, claim=Claim.NONE, outcome="crashed")
    good, bad, part = (
        bias_section(load_rows(name, rows)).text
        for name, rows in (
            ("good", by_theory()),
            ("bad", by_theory(2.0)),
            ("part", [lost, *by_theory()[:3]]),
        )
    )

    assert "Over 7 attempts z₂ is within a relative" in good
    assert "though the solver calls 1 of them failures" in good
    assert "z₂ does not follow this everywhere: it is up to a relative 1.0 away" in bad
    assert "Over 3 attempts" in part
