"""Cold against warm starts: ratios by hand, the section."""

from __future__ import annotations

import math

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.warm import warm_section, warm_starts
from dubins_study.study.scenario import Scenario
from tests.unit.report.results_folder import attempt

RADII = (1.0, 1.1, 1.2, 1.3, 1.4)


def scenario(radius):
    return Scenario(0, 0, 0, -3, 4, radius, label="sweep")


def rows():
    """A solver that saves, one that pays, one that counts no iterations and is the same."""
    made = []
    for place, radius in enumerate(RADII):
        where = scenario(radius)
        for start, time, work in (("cold", 0.01, 10), ("warm", 0.001 * (place + 1), 5)):
            made.append(attempt(where, "ipopt", initial_guess=start, wall_s=time, iterations=work))
        for start, time, work in (("cold", 0.01, 10), ("warm", 0.02, 30)):
            made.append(attempt(where, "slsqp", initial_guess=start, wall_s=time, iterations=work))
        made += [
            attempt(where, "shooting", initial_guess=s, iterations=None) for s in ("cold", "warm")
        ]
        made.append(attempt(where, "never-warm"))
    return made


def test_ratios_by_hand(results):
    """Ratios 0.1 to 0.5 in five steps; iterations halved; none counted is none compared.

    A solver that is never warm is left out.
    """
    table = warm_starts(load([results("radius-sweep", rows())]).rows).set_index("solver")

    assert table.index.tolist() == ["ipopt", "shooting", "slsqp"]
    assert table.loc["ipopt", ["questions", "ratio", "work"]].tolist() == pytest.approx(
        [5, 0.3, 0.5]
    )
    assert math.isnan(table.loc["shooting", "work"])


def test_no_iterations_at_all_are_no_ratio(results):
    """Cold in none and warm in some would be infinitely more."""
    made = [
        attempt(scenario(r), "ipopt", initial_guess=start, iterations=n)
        for r in RADII
        for start, n in (("cold", 0), ("warm", 3))
    ]
    table = warm_starts(load([results("radius-sweep", made)]).rows)

    assert math.isnan(table["work"].iloc[0])


def test_only_rows_with_both_starts_make_a_section(results):
    cold = [row for row in rows() if row["initial_guess"] == "cold"]
    both, plain = (load([results(n, each)]) for n, each in (("both", rows()), ("cold", cold)))

    assert warm_section(both).blocks[0].name == "warm-starts"
    assert warm_section(plain) is None
