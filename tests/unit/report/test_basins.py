"""Where starts lead: ends named by length, shares by hand, and the section."""

from __future__ import annotations

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
    shares,
)
from dubins_study.study.closed_form.shortest import shortest, shortest_path
from dubins_study.study.path import Path
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt, paper_scenarios

THREE, FOUR = paper_scenarios()[2:4]
SPEC = "slsqp[model=joint,order=LRS,initial_guess=given,capped=false]"


def turned(scenario, word, turns):
    """The word's path with full turns to the left before it."""
    path = shortest_path(scenario, word)
    R = scenario.radius
    before = [math.tau * R] * turns
    return Path(
        scenario.start, [1 / R] * turns + list(path.curvatures), before + list(path.lengths)
    )


@pytest.mark.parametrize("scenario", [THREE, FOUR, replace(THREE, radius=0.5)])
def test_the_minima_are_those_of_brute_force(scenario):
    """Drive L(z1) for every z1 up to three turns and then the best RS: the length has a minimum at
    z1 = 0 and wherever it drops, and `minimum` knows each of them by its length."""
    R = scenario.radius
    found, last = [], math.inf
    for z1 in np.arange(0, 3 * math.tau, 1e-3):
        pose = Path(scenario.start, [1 / R], [z1 * R]).end
        moved = replace(scenario, x=pose.x, y=pose.y, heading=pose.heading)
        rest = shortest(moved, "RS")
        # inside the right-hand circle of that pose there is no RS
        length = math.inf if rest is None else (z1 + rest.total) * R
        if length < last:
            found.append(minimum(scenario, length))
        last = length

    # past a drop the length is flat to third order, so the step adds nothing that is seen
    assert found == [("RS", 0), ("LS", 0), ("LS", 1), ("LS", 2)]
    assert minimum(scenario, shortest(scenario).total * R + 0.1 * R) is None


def given(scenario, z1, z2, **changes):
    return attempt(scenario, SPEC, initial_guess=f"{z1} {z2} 5.0", **changes)


def not_a_minimum():
    """A right turn more than LS needs, then the best that is left: it arrives and is too long."""
    early = Path(THREE.start, [-1], [0.5]).end
    rest = shortest_path(replace(THREE, x=early.x, y=early.y, heading=early.heading), "LS")
    return Path(THREE.start, [-1, *rest.curvatures], [0.5, *rest.lengths])


def every_end():
    """Rows for every end there is, in the order of `ENDS`, the last one three times."""
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
    """By verdict, claim and length; full turns are counted in minima only."""
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
    line = shares(table).iloc[0]
    assert (line["guesses"], line["optimal"], line["refuted"]) == (9, 1 / 9, 3)
    assert line[["turns_1", "turns_2", "turns_more", "most_turns"]].tolist() == [1, 1, 0, 2]


def test_the_section_tells_what_the_rows_hold(load_rows):
    """Its numbers are of these rows; without refuted claims it does not speak of any."""
    text = basins_section(load_rows("basins", every_end())).text
    honest = [given(FOUR, z1, z2, claim=Claim.LOCAL) for z1 in (0.0, 1.0) for z2 in (0.0, 1.0)]
    plain = basins_section(load_rows("honest", honest)).text

    assert "3 statements are refuted" in text
    assert "22.2 % of all attempts end in a minimum with full turns in it, with up to 2" in text
    assert "refuted:" not in plain
    assert "is found from 100 % of the initial guesses" in plain
