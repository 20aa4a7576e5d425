"""Order of convergence: numbers by hand, the section, and the claim for real."""

from __future__ import annotations

import math
from functools import partial

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.convergence import medians, orders, refined, series
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt
from tests.unit.report.topic_page import section_text

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


def frames(folder):
    loaded = load([folder])
    return refined(loaded.rows, loaded.settings)


def test_orders_by_hand(results):
    """Powers made up are powers found; the median is the middle target's."""
    attempts = frames(results("convergence", rows()))
    table = medians(attempts).set_index(["series", "place", "size"])
    found = orders(attempts).set_index(["series", "place"])

    assert table.loc[("turn-rate-qp", "outside", 10), "value"] == pytest.approx(2e-3)
    for place, p in (("outside", 3), ("in a disc", 2)):
        line = found.loc[("turn-rate-qp", place)]
        assert line[["order", "least", "most"]].tolist() == pytest.approx([p, p, p])
        assert (line["scenarios"], line["finest"], line["measure"]) == (3, 40, "gap")
    raw = found.loc[(series(RAW.format(20)), "outside")]
    assert (raw["measure"], raw["order"]) == ("miss", pytest.approx(3))


def test_goal_is_met_where_the_gap_stays_below(results):
    """Outside 2 / n^3 stays below 1e-4 from n = 40 on; 2 / n^2 in the disc never does."""
    found = orders(frames(results("convergence", rows()))).set_index(["series", "place"])

    assert found.loc[("turn-rate-qp", "outside"), "goal_s"] == pytest.approx(0.04)
    assert math.isnan(found.loc[("turn-rate-qp", "in a disc"), "goal_s"])


def test_what_does_not_arrive_is_infinitely_far_off(results):
    """Two of three lost at the finest n: the median is infinite there, and the order is of the
    rest."""
    lost = [row | {"gap": None} for row in rows()[:3]]  # n = 10 outside
    made = [*lost[:2], *rows()[2:]]
    table = medians(frames(results("convergence", made)))
    line = table[(table["place"] == "outside") & (table["size"] == 10)].iloc[0]

    assert line["value"] == math.inf
    assert line["arrived"] == pytest.approx(1 / 3)


def test_a_wrong_basin_measures_no_order(results):
    """One jump to another optimum moves no single order; it is counted."""
    made = rows()
    made[-6] |= {"gap": 1.5, "wrong_basin": True}
    assert made[-6]["solver"] == "turn-rate-qp[n=40]"
    found = orders(frames(results("convergence", made))).set_index(["series", "place"])
    line = found.loc[("turn-rate-qp", "in a disc")]

    assert line["wrong"] == 1
    assert line["least"] == pytest.approx(2)


text_of = partial(section_text, "the order of convergence", "convergence")


def test_the_section_says_what_the_rows_say(results, tmp_path):
    text_of(results("convergence", rows()), tmp_path / "out")
    files = {file.stem: file for file in (tmp_path / "out" / "figures").glob("convergence-*.svg")}

    assert set(files) == {
        "convergence-outside",
        "convergence-in-a-disc",
        "convergence-miss-outside",
    }
    for place, p in (("outside", 3), ("in-a-disc", 2)):
        assert f"{QP}: p = {p}.00" in files[f"convergence-{place}"].read_text(encoding="utf-8")


@pytest.mark.slow
def test_lost_rows_make_a_section_too(results, tmp_path):
    gone = dict.fromkeys(("gap", "length", "miss", "wall_s"))
    made = [
        attempt(scenario, f"turn-rate-qp[n={n}]", path=None, claim=Claim.NONE, **gone)
        for n in (10, 20)
        for scenario in FAR
    ]
    text_of(results("convergence", made), tmp_path / "out")

    assert not list((tmp_path / "out" / "figures").glob("convergence*"))
