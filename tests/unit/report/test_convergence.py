"""Orders of convergence and sequences' convex problems.

Numbers are worked by hand; the sections are read.
"""

import math

import numpy as np
import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.convergence import (
    convergence_section,
    medians,
    orders,
    refined,
    series,
)
from dubins_study.report.topics.convex import by_method, convex_section, shift_of, with_parts
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, paper_scenarios, write_folder
from tests.unit.report.topic_page import topic_page

FAR = [Scenario(0, 0, 0, x, 3, 1) for x in (4.0, 5.0, 6.0)]
NEAR = [Scenario(0, 0, 0, x, 1, 1) for x in (0.1, 0.2, 0.3)]
QP = "turn-rate-qp, word NLPs"  # its short name, by the engine and formulation of `attempt`
RAW = "collocation[n={},points=2,mesh=equal,correct=False]"


def rows():
    """Rows of a QP and of collocation.

    The QP has order 3 outside and 2 in the disc; collocation misses with order 3.
    """
    attempts = []
    for n in (10, 20, 40):
        for where, p in ((FAR, 3), (NEAR, 2)):
            attempts += [
                attempt(scenario, f"turn-rate-qp[n={n}]", gap=factor / n**p, wall_s=n / 1e3)
                for scenario, factor in zip(where, (1.0, 2.0, 4.0), strict=True)
            ]
        attempts += [
            attempt(scenario, RAW.format(n), gap=None, miss=1.0 / n**3, verdict="misses")
            for scenario in FAR
        ]
    return attempts


@pytest.fixture
def attempts_of(load_rows):
    def made(rows):
        results = load_rows("convergence", rows)
        return refined(results.rows, results.settings)

    return made


def test_orders_by_hand(attempts_of):
    """Orders by hand.

    Powers made up are powers found; the median is the middle target's.
    """
    attempts = attempts_of(rows())
    table = medians(attempts).set_index(["series", "place", "size"])
    found = orders(medians(attempts)).groupby(["series", "place", "measure"])["order"].first()

    assert table.loc[("turn-rate-qp", "outside", 10), "value"] == pytest.approx(2e-3)
    assert found["turn-rate-qp", "outside", "gap"] == pytest.approx(3)
    assert found["turn-rate-qp", "in a disc", "gap"] == pytest.approx(2)
    assert found[series(RAW.format(20)), "outside", "miss"] == pytest.approx(3)


def test_what_does_not_arrive_is_infinitely_far_off(attempts_of):
    """A path that does not arrive is infinitely off.

    Two of three are lost at the finest n: the median is infinite there, and the order is of the
    rest.
    """
    lost = [row | {"gap": None} for row in rows()[:3]]  # n = 10 outside
    attempts = [*lost[:2], *rows()[2:]]
    table = medians(attempts_of(attempts))
    line = table[(table["place"] == "outside") & (table["size"] == 10)].iloc[0]

    assert line["value"] == math.inf


def test_a_figure_names_the_order_of_each_line(load_rows):
    pictures = convergence_section(load_rows("convergence", rows())).blocks
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


def frozen(engine, label, wall_s, interface="own", verdict="optimal", repeat=0, **changes):
    """A judged attempt at a frozen problem.

    Its tolerance is 1e-6.
    """
    spec = f"convex[engine={engine.lower()},interface={interface}]"
    named = {"scenario_id": label, "label": label, "branch": "frozen", "verdict": verdict}
    given = {"engine": engine, "formulation": "frozen convex problem", "tolerance": 1e-6}
    residuals = {"miss": 1e-9, "dual_residual": 1e-9, "duality_gap": 1e-9, "reference_low": 0.0}
    times = {"wall_s": wall_s, "floor_s": 1e-4, "repeat": repeat, "limit_s": 2.0}
    return attempt(
        paper_scenarios()[0],
        spec,
        **(named | given | residuals | times | {"claim": Claim.OPTIMAL} | changes),
    )


def frozen_rows():
    """Rows of four convex engines.

    PIQP is right and slow, OSQP quick and wrong once, SCS right once; Clarabel has a tube.
    """
    return [
        *(frozen("PIQP", "qp-50-well", s, repeat=n) for n, s in enumerate((0.1, 0.2, 0.4))),
        frozen("PIQP", "qp-50-random-6-0", 0.3),
        frozen("PIQP", "qp-50-well", 0.6, "cvxpy"),
        frozen("PIQP", "qp-50-random-6-0", 0.7, "cvxpy"),
        frozen("OSQP", "qp-50-well", 0.01),
        frozen("OSQP", "qp-50-random-6-0", 0.01, verdict="longer", **FALSE),
        frozen("SCS", "qp-50-well", 0.5),
        frozen("SCS", "qp-50-random-6-0", 0.5, verdict="longer"),
        frozen("Clarabel", "tube-50-random-3-12", 2.0),
    ]


FALSE = {"dual_residual": 1e-3, "false_claim": True, "claim": "optimal"}


def test_convex_problems_by_hand(load_rows):
    """Convex problems by hand.

    Computed are shares, means with failures at the limit, and the counts in the text.
    """
    results = load_rows("convex", frozen_rows())
    rows = with_parts(results.rows)
    direct = rows[rows["interface"] == "own"]
    methods = by_method(direct).set_index(["family", "name"])
    section = convex_section(results)
    profiles, engines = section.blocks
    shift = shift_of(direct)
    limit = direct["limit_s"].max()
    lines = engines.frame.set_index(["family", "name"])

    assert methods["right"].to_dict() == {
        ("QP", "OSQP"): 1,
        ("QP", "PIQP"): 2,
        ("QP", "SCS"): 1,
        ("tube", "Clarabel"): 1,
    }
    expected = np.sqrt((0.2 + shift) * (0.3 + shift)) - shift  # the median of three, and one
    assert methods.loc[("QP", "PIQP"), "mean_s"] == pytest.approx(expected)
    expected = np.sqrt((0.01 + shift) * (limit + shift)) - shift
    assert methods.loc[("QP", "OSQP"), "mean_s"] == pytest.approx(expected)
    assert lines["false_claim"].to_dict() == {key: int(key[1] == "OSQP") for key in lines.index}
    assert "False claims in 11 answers: 1. 0 of them" in section.text
    assert "further than that from the optimum: 1." in section.text
    assert "takes 400 ms longer (median of 2 answers)" in section.text  # 0.6 - 0.2 and 0.7 - 0.3
    assert "Problems of a former set: 1." in section.text
    assert "PIQP on QP, 100 % (34.2 to 100)" in section.lead
    titles = [ax.get_title() for ax in profiles.figure.axes]
    assert titles == ["QP, 10⁻⁶", "with cones, 10⁻⁶"]


def test_convex_problems_of_another_machine_have_no_picture(results, tmp_path):
    """Another machine's convex problems have no picture.

    Their times rank nothing. How many are right is still said.
    """
    ours = results("convex", [attempt(paper_scenarios()[0])])
    theirs = [row | {"machine": "another"} for row in frozen_rows()]
    section = convex_section(load([ours, write_folder(tmp_path / "theirs", "convex", theirs)]))
    (engines,) = section.blocks

    assert engines.frame["mean_s_1e-06"].isna().all()
    assert "False claims in 11 answers: 1." in section.text


def test_a_floor_beside_a_time_is_said(load_rows):
    """A floor beside a time is marked.

    There is a star where more than half of the mean time is the time of a problem of one variable.
    """
    rows = [
        frozen(name, "qp-50-well", 0.01, floor_s=s)
        for name, s in {"PIQP": 6e-3, "OSQP": 4e-3}.items()
    ]
    _, engines = convex_section(load_rows("convex", rows)).blocks

    cells = engines.frame.set_index("name")["at_1e-06"]
    assert cells["PIQP"].endswith("10.0 ms*")
    assert cells["OSQP"].endswith("10.0 ms")


def test_the_page_of_convex_problems(results, tmp_path):
    page = topic_page(results("convex", frozen_rows()), tmp_path / "page", "convex problems")

    assert "Convex problems of paths" in page.read_text(encoding="utf-8")
