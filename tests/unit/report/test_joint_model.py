"""Studies of the joint model.

They show where starts lead, and the bias in the segments.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from dubins_study.report.topics.basins import (
    FALSE_MINIMUM,
    FALSE_PATH,
    GIVES_UP,
    INFEASIBLE,
    OPTIMUM,
    OTHER,
    TURNS,
    basins_section,
    ends,
    minimum,
    outcomes_of,
)
from dubins_study.report.topics.bias import barrier, bias_section, last_barrier
from dubins_study.study.closed_form.shortest import shortest, shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt, paper_scenarios

THREE, FOUR = paper_scenarios()[2:4]
SPEC = "slsqp[model=joint,order=LRS,initial_guess=given,capped=false]"


def turned(scenario, word, turns):
    """The word's path behind full left turns."""
    path = shortest_path(scenario, word)
    R = scenario.radius
    before = [math.tau * R] * turns
    return Path(
        scenario.start, [1 / R] * turns + list(path.curvatures), before + list(path.lengths)
    )


@pytest.mark.parametrize("scenario", [THREE, FOUR, replace(THREE, radius=0.5)])
def test_the_minima_are_those_of_brute_force(scenario):
    """The minima are those of brute force.

    Drive L(z1) for every z1 up to three turns and then the best RS: the length has a minimum at z1
    = 0 and wherever it drops, and `minimum` knows each of them by its length.
    """
    R = scenario.radius
    minima = []
    last = math.inf
    for z1 in np.arange(0, 3 * math.tau, 1e-3):
        pose = Path(scenario.start, [1 / R], [z1 * R]).end
        moved = replace(scenario, x=pose.x, y=pose.y, heading=pose.heading)
        rest = shortest(moved, "RS")
        # inside the right-hand circle of that pose there is no RS
        length = math.inf if rest is None else (z1 + rest.total) * R
        if length < last:
            minima.append(minimum(scenario, length))
        last = length

    # past a drop the length is flat to third order, so the step adds nothing that is seen
    assert minima == [("RS", 0), ("LS", 0), ("LS", 1), ("LS", 2)]
    assert minimum(scenario, shortest(scenario).total * R + 0.1 * R) is None


def given(scenario, z1, z2, **changes):
    return attempt(scenario, SPEC, initial_guess=f"{z1} {z2} 5.0", **changes)


def not_a_minimum():
    """A path that arrives and is too long.

    It is a right turn more than LS needs, then the best that is left.
    """
    early = Path(THREE.start, [-1], [0.5]).end
    rest = shortest_path(replace(THREE, x=early.x, y=early.y, heading=early.heading), "LS")
    return Path(THREE.start, [-1, *rest.curvatures], [0.5, *rest.lengths])


def every_end():
    """Rows for every end that exists.

    They come in the order of `MARKS`, the last one three times.
    """
    local = {"claim": Claim.LOCAL}
    return [
        given(THREE, 0.0, 0.0, **local),
        given(THREE, 0.0, 1.0, path=turned(THREE, "LS", 2), **local),
        given(THREE, 0.0, 2.0, path=turned(THREE, "RS", 1), **local),
        given(THREE, 1.0, 0.0, path=not_a_minimum(), **local),
        given(THREE, 1.0, 1.0, path=None, claim=Claim.INFEASIBLE),
        given(THREE, 1.0, 2.0, path=astray(THREE, 2.0), **local),
        given(THREE, 2.0, 0.0, path=astray(THREE, 2.0), claim=Claim.FAILED),
        given(THREE, 2.0, 1.0, path=None, claim=Claim.LIMIT),
        given(THREE, 2.0, 2.0, path=turned(THREE, "RS", 0), claim=Claim.LIMIT),
    ]


def test_every_end_is_told_apart(load_rows):
    """Every end is told apart.

    Verdict, claim and length tell it; full turns are counted in minima only.
    """
    cold = attempt(THREE)  # not of the study
    table = ends(load_rows("basins", [*every_end(), cold]).rows)

    assert table["end"].tolist() == [
        OPTIMUM,
        TURNS,
        OTHER,
        FALSE_MINIMUM,
        INFEASIBLE,
        FALSE_PATH,
        *[GIVES_UP] * 3,
    ]
    np.testing.assert_array_equal(table["turns"], [0, 2, 1, *[math.nan] * 6])
    assert table[["z1", "z2", "z3"]].iloc[5].tolist() == [1.0, 2.0, 5.0]
    assert outcomes_of(table) == {"optimal": 1 / 9, "turned": 2 / 9, "refuted": 3}


def test_the_section_tells_what_the_rows_hold(load_rows):
    """The section tells the rows' numbers.

    Without refuted claims it does not speak of any.
    """
    text = basins_section(load_rows("basins", every_end())).text
    honest = [given(FOUR, z1, z2, claim=Claim.LOCAL) for z1 in (0.0, 1.0) for z2 in (0.0, 1.0)]
    plain = basins_section(load_rows("honest", honest)).text

    assert "3 statements are refuted" in text
    assert "22.2 % of all attempts end in a minimum with needless full turns, up to 2" in text
    assert "refuted:" not in plain
    assert "is found from 100 % of the initial guesses" in plain


TOLD = "ipopt[model=joint,order=LRS,units=scenario,mu_target={}]"
DEFAULT = "ipopt[model=joint,order=LRS,units=scenario,options=default]"
SPLIT = "slsqp[units=scenario]"
ACTIVE = "slsqp[model=joint,order=LRS]"


def behind(radius):
    """LS is shortest."""
    return Scenario(0, 0, 0, -3 * radius, 4 * radius, radius, label="behind")


def left(scenario, solver, right, claim=Claim.LOCAL):
    """An answer with so long a right turn.

    It is put where LS begins, and arrives.
    """
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
    """Answers near the predicted turn.

    They have `factor` times that turn, at two barriers and three radii. Others follow: those of
    Ipopt's defaults, and of methods without a barrier.
    """
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
    """Only Ipopt's barrier is known.

    It is known on the unsplit model, from its settings; nobody else's is.
    """
    settings = {
        "ipopt[tol=1]": {"model": "joint", "mu_target": 1e-5, "tol": 1e-12},
        "ipopt[tol=2]": {"model": "joint", "mu_target": 0.0, "tol": 1e-6},
        "ipopt": {"model": "words", "mu_target": 0.0, "tol": 1e-8},
        "ipopt[tol=4]": {"model": "joint", "mu_target": 0.0, "tol": 0.0, "options": "equal"},
        "slsqp[tol=3]": {"model": "joint"},
    }

    known = [barrier(spec, settings) for spec in (*settings, "unheard-of")]

    np.testing.assert_allclose(known, [1e-5, 1e-6 / 11, math.nan, 1e-9 / 11, math.nan, math.nan])


def test_the_section_says_what_the_rows_say(load_rows):
    """The section confirms the prediction or not.

    Where the prediction holds it says so, with numbers; where it does not, not.

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
    assert "Of 2 methods without a barrier 1 leave no turn; slsqp" in good
