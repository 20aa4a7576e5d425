"""Order of convergence: numbers by hand, and the section."""

from __future__ import annotations

import math

import pytest

from dubins_study.report.topics.convergence import (
    convergence_section,
    medians,
    orders,
    refined,
    series,
)
from dubins_study.study.scenario import Scenario
from tests.unit.report.results_folder import attempt

FAR = [Scenario(0, 0, 0, x, 3, 1) for x in (4.0, 5.0, 6.0)]
NEAR = [Scenario(0, 0, 0, x, 1, 1) for x in (0.1, 0.2, 0.3)]
QP = "turn-rate-qp, word NLPs"  # its short name, by the engine and formulation of `attempt`
RAW = "collocation[n={},points=2,mesh=equal,correct=False]"


def rows():
    """A QP of order 3 outside and 2 in the disc; collocation that misses with order 3."""
    made = []
    for n in (10, 20, 40):
        for where, p in ((FAR, 3), (NEAR, 2)):
            made += [
                attempt(scenario, f"turn-rate-qp[n={n}]", gap=factor / n**p, wall_s=n / 1e3)
                for scenario, factor in zip(where, (1.0, 2.0, 4.0), strict=True)
            ]
        made += [
            attempt(scenario, RAW.format(n), gap=None, miss=1.0 / n**3, verdict="misses")
            for scenario in FAR
        ]
    return made


@pytest.fixture
def attempts_of(load_rows):
    def made(rows):
        results = load_rows("convergence", rows)
        return refined(results.rows, results.settings)

    return made


def test_orders_by_hand(attempts_of):
    """Powers made up are powers found; the median is the middle target's."""
    attempts = attempts_of(rows())
    table = medians(attempts).set_index(["series", "place", "size"])
    found = orders(attempts).set_index(["series", "place"])

    assert table.loc[("turn-rate-qp", "outside", 10), "value"] == pytest.approx(2e-3)
    # the gap 2 / n^3 stays below 1e-4 from n = 40 on, 2 / n^2 never does
    for place, p, goal_s in (("outside", 3, 0.04), ("in a disc", 2, math.nan)):
        line = found.loc[("turn-rate-qp", place)]
        numbers = line[["order", "least", "most", "goal_s"]].tolist()
        assert numbers == pytest.approx([p, p, p, goal_s], nan_ok=True)
        assert (line["scenarios"], line["finest"], line["measure"]) == (3, 40, "gap")
    raw = found.loc[(series(RAW.format(20)), "outside")]
    assert (raw["measure"], raw["order"]) == ("miss", pytest.approx(3))


def test_what_does_not_arrive_is_infinitely_far_off(attempts_of):
    """Two of three lost at the finest n: the median is infinite there, and the order is of the
    rest."""
    lost = [row | {"gap": None} for row in rows()[:3]]  # n = 10 outside
    made = [*lost[:2], *rows()[2:]]
    table = medians(attempts_of(made))
    line = table[(table["place"] == "outside") & (table["size"] == 10)].iloc[0]

    assert line["value"] == math.inf


def test_a_wrong_basin_measures_no_order(attempts_of):
    """One jump to another optimum moves no single order; it is counted."""
    made = rows()
    made[-6] |= {"gap": 1.5, "wrong_basin": True}
    assert made[-6]["solver"] == "turn-rate-qp[n=40]"
    found = orders(attempts_of(made)).set_index(["series", "place"])
    line = found.loc[("turn-rate-qp", "in a disc")]

    assert line["wrong"] == 1
    assert line["least"] == pytest.approx(2)


def test_a_figure_names_the_order_of_each_line(load_rows):
    *pictures, _ = convergence_section(load_rows("convergence", rows())).blocks
    legends = {
        each.name: [text.get_text() for text in each.figure.legends[0].get_texts()]
        for each in pictures
    }

    assert [*legends] == [
        "convergence-outside",
        "convergence-in-a-disc",
        "convergence-miss-outside",
    ]
    for place, p in (("outside", 3), ("in-a-disc", 2)):
        assert legends[f"convergence-{place}"] == [f"{QP}: p = {p}.00"]
