"""Scale invariance: numbers by hand, and the section."""

from __future__ import annotations

import math

import pytest

from dubins_study.report.topics.scale import ROUNDING, dependence, scale_section, spreads
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt

RADII = (1e-3, 1.0, 1e3)
UNITS = "slsqp[units=scenario]"


def scenario(radius):
    return Scenario(0, 0, 0, -3 * radius, 4 * radius, radius, label="behind")


def longer(where, share):
    """The shortest path, its straight longer by a share: it misses by that."""
    path = shortest_path(where)
    return Path(where.start, path.curvatures, path.lengths * [1, 1 + share])


def rows():
    """The closed form; a solver that is level; one whose answers depend on the radius."""
    made = [attempt(scenario(R), iterations=None) for R in RADII]
    made += [attempt(scenario(R), "ipopt", iterations=5) for R in RADII]
    ends = (longer(scenario(1e-3), 1e-7), longer(scenario(1.0), 0.0), longer(scenario(1e3), 1e-2))
    local = {"claim": Claim.LOCAL}
    made += [
        attempt(scenario(R), UNITS, path=path, iterations=n, **local)
        for R, path, n in zip(RADII, ends, (4, 6, 10), strict=True)
    ]
    return made


def test_numbers_by_hand(load_rows):
    """Spreads over the answers that arrive, iterations as a ratio, misses not invariant."""
    table = dependence(spreads(load_rows("scale", rows()).rows)).set_index("solver")
    exact = shortest_path(scenario(1.0))
    straight, whole = exact.lengths[1], exact.length

    assert table["invariant"].tolist() == [1, 1, 0]
    assert table.index.tolist() == ["analytic", "ipopt", UNITS]
    assert table.loc["ipopt", "spread"] <= ROUNDING
    assert table.loc[UNITS, "spread"] == pytest.approx(1e-7 * straight / whole)
    assert table.loc[UNITS, "success"] == pytest.approx(2 / 3)
    assert math.isnan(table.loc["analytic", "iterations"])
    assert table.loc[UNITS, "iterations"] == 2.5
    assert table.loc["ipopt", "iterations"] == 1


def test_another_word_is_not_invariant(load_rows):
    """Straight behind two words tie; taking now one and now the other is no invariance."""
    tie = [Scenario(0, 0, 0, -R, 0, R, label="tie") for R in RADII]
    words = ("LS", "RS", "LS")
    made = [
        attempt(where, path=shortest_path(where, word))
        for where, word in zip(tie, words, strict=True)
    ]

    line = dependence(spreads(load_rows("scale", made).rows)).iloc[0]

    assert line["spread"] <= ROUNDING
    assert not line["words"]
    assert line["invariant"] == 0


def test_the_section_says_what_the_rows_say(load_rows):
    """Who is level, who is not and why; with nobody to blame it blames nobody."""
    text, level = (
        scale_section(load_rows(name, each)).text
        for name, each in (("scale", rows()), ("level", rows()[:6]))
    )

    assert "2 of 3 solvers and variants give the same path everywhere" in text
    assert "Not so for slsqp, word NLPs: they" in text
    assert "in the scenario's own unit" in text
    assert "None depends on the unit." in level
