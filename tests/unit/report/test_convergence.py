"""Orders of convergence, and the convex problems of a sequence: numbers by hand, sections."""

import math

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.convergence import (
    convergence_section,
    medians,
    orders,
    refined,
    series,
)
from dubins_study.report.topics.convex import by_size, convex_section, with_parts
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, paper_scenarios, write_folder
from tests.unit.report.topic_page import topic_page

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
    found = orders(medians(attempts)).groupby(["series", "place", "measure"])["order"].first()

    assert table.loc[("turn-rate-qp", "outside", 10), "value"] == pytest.approx(2e-3)
    assert found["turn-rate-qp", "outside", "gap"] == pytest.approx(3)
    assert found["turn-rate-qp", "in a disc", "gap"] == pytest.approx(2)
    assert found[series(RAW.format(20)), "outside", "miss"] == pytest.approx(3)


def test_what_does_not_arrive_is_infinitely_far_off(attempts_of):
    """Two of three lost at the finest n: the median is infinite there, and the order is of the
    rest."""
    lost = [row | {"gap": None} for row in rows()[:3]]  # n = 10 outside
    made = [*lost[:2], *rows()[2:]]
    table = medians(attempts_of(made))
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
    """A judged attempt at a frozen problem, at the tolerance 1e-6."""
    spec = f"convex[engine={engine.lower()},interface={interface}]"
    named = {"scenario_id": label, "label": label, "branch": "frozen", "verdict": verdict}
    given = {"engine": engine, "formulation": "frozen convex problem", "tolerance": 1e-6}
    found = {"miss": 1e-9, "dual_residual": 1e-9, "duality_gap": 1e-9, "reference_low": 0.0}
    times = {"wall_s": wall_s, "floor_s": 1e-4, "repeat": repeat, "claim": Claim.OPTIMAL}
    return attempt(paper_scenarios()[0], spec, **(named | given | found | times | changes))


def frozen_rows():
    """PIQP is right and slow, OSQP quick and wrong once, SCS right; Clarabel has an SOCP."""
    return [
        *(frozen("PIQP", "qp-50-well", s, repeat=n) for n, s in enumerate((0.1, 0.2, 0.4))),
        frozen("PIQP", "qp-50-bad", 0.3),
        frozen("PIQP", "qp-50-well", 0.6, "cvxpy"),
        frozen("PIQP", "qp-50-bad", 0.7, "cvxpy"),
        frozen("OSQP", "qp-50-well", 0.01),
        frozen("OSQP", "qp-50-bad", 0.01, verdict="longer", dual_residual=1e-3, false_claim=True),
        frozen("SCS", "qp-50-well", 0.5),
        frozen("SCS", "qp-50-bad", 0.5, verdict="longer"),
        frozen("Clarabel", "socp-500-well", 2.0),
    ]


def test_convex_problems_by_hand(load_rows):
    """The slower problem's median counts, and one wrong answer makes a size wrong.

    The counts of each engine, and the picture's differences are shown.
    """
    results = load_rows("convex", frozen_rows())
    sizes = by_size(with_parts(results.rows)).set_index(["engine", "interface", "kind", "rates"])
    section = convex_section(results)
    picture, engines = section.blocks
    counts = engines.frame.set_index(["engine", "interface"])

    assert sizes.loc[("PIQP", "own", "QP", 50), "wall_s"] == 0.3
    assert sizes.loc[("PIQP", "cvxpy", "QP", 50), "wall_s"] == 0.7
    assert sizes["right"].to_dict() == {
        ("Clarabel", "own", "SOCP", 500): True,
        ("OSQP", "own", "QP", 50): False,
        ("PIQP", "cvxpy", "QP", 50): True,
        ("PIQP", "own", "QP", 50): True,
        ("SCS", "own", "QP", 50): False,
    }
    assert counts.loc[("OSQP", "own"), ["right", "kept", "false_claim"]].tolist() == [1, 1, 1]
    assert counts.loc[("SCS", "own"), ["right", "kept", "false_claim"]].tolist() == [1, 2, 0]
    assert counts.loc[("PIQP", "own"), "attempts"] == 4
    assert "1 claim of 11 answers is false" in section.text
    assert "1 answer keeps all three residuals" in section.text
    [above], [below] = (picture.figure.axes[:1], picture.figure.axes[1:])
    assert above.get_title() == "tolerance 10⁻⁶"
    [line] = [line for line in below.lines if line.get_linestyle() == "-"]
    assert line.get_ydata() == pytest.approx([0.4])  # 0.7 through cvxpy, 0.3 without


def test_convex_problems_of_another_machine_have_no_picture(results, tmp_path):
    """Their times rank nothing. How many are right is still said."""
    ours = results("here", [attempt(paper_scenarios()[0])])
    theirs = [row | {"machine": "another"} for row in frozen_rows()]
    section = convex_section(load([ours, write_folder(tmp_path / "convex", "convex", theirs)]))
    (engines,) = section.blocks

    assert engines.frame["attempts"].sum() == len(theirs)
    assert "1 claim of 11 answers is false" in section.text


def test_the_page_of_convex_problems(results, tmp_path):
    page = topic_page(results("convex", frozen_rows()), tmp_path / "page", "convex problems")

    assert "The convex problems of a sequence" in page.read_text(encoding="utf-8")
