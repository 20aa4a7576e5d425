"""The section on convex problems: numbers by hand."""

from __future__ import annotations

import pytest

from dubins_study.report.topics.convex import by_size, convex_section, with_parts
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, paper_scenarios
from tests.unit.report.topic_page import topic_page


def row(engine, label, wall_s, interface="own", verdict="optimal", repeat=0, **changes):
    """A judged attempt at a frozen problem, at the tolerance 1e-6."""
    spec = f"convex[engine={engine.lower()},interface={interface}]"
    named = {"scenario_id": label, "label": label, "branch": "frozen", "verdict": verdict}
    given = {"engine": engine, "formulation": "frozen convex problem", "tolerance": 1e-6}
    found = {"miss": 1e-9, "dual_residual": 1e-9, "duality_gap": 1e-9, "reference_low": 0.0}
    times = {"wall_s": wall_s, "floor_s": 1e-4, "repeat": repeat, "claim": Claim.OPTIMAL}
    return attempt(paper_scenarios()[0], spec, **(named | given | found | times | changes))


def rows():
    """PIQP is right and slow, OSQP quick and wrong once, SCS right; Clarabel has an SOCP."""
    return [
        *(row("PIQP", "qp-50-well", s, repeat=n) for n, s in enumerate((0.1, 0.2, 0.4))),
        row("PIQP", "qp-50-bad", 0.3),
        row("PIQP", "qp-50-well", 0.6, "cvxpy"),
        row("PIQP", "qp-50-bad", 0.7, "cvxpy"),
        row("OSQP", "qp-50-well", 0.01),
        row("OSQP", "qp-50-bad", 0.01, verdict="longer", dual_residual=1e-3, false_claim=True),
        row("SCS", "qp-50-well", 0.5),
        row("SCS", "qp-50-bad", 0.5, verdict="longer"),
        row("Clarabel", "socp-500-well", 2.0),
    ]


def test_numbers_by_hand(load_rows):
    """The slower problem's median counts, and one wrong answer makes a size wrong.

    The quickest right engine, the counts of each engine, and the picture's differences are shown.
    """
    results = load_rows("convex", rows())
    sizes = by_size(with_parts(results.rows)).set_index(["engine", "interface", "kind", "rates"])
    section = convex_section(results)
    picture, quickest, engines = section.blocks
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
    assert quickest.texts() == [
        ["QP, 50 turn rates", "PIQP 300 ms"],
        ["SOCP, 500 turn rates", "Clarabel 2.00 s"],
    ]
    assert counts.loc[("OSQP", "own"), ["right", "kept", "false_claim"]].tolist() == [1, 1, 1]
    assert counts.loc[("SCS", "own"), ["right", "kept", "false_claim"]].tolist() == [1, 2, 0]
    assert counts.loc[("PIQP", "own"), "attempts"] == 4
    assert "1 claim of 11 answers is false" in section.text
    assert "1 answer keeps all three residuals" in section.text
    [above], [below] = (picture.figure.axes[:1], picture.figure.axes[1:])
    assert above.get_title() == "tolerance 10⁻⁶"
    [line] = [line for line in below.lines if line.get_linestyle() == "-"]
    assert line.get_ydata() == pytest.approx([0.4])  # 0.7 through cvxpy, 0.3 without


def test_page(results, tmp_path):
    page = topic_page(results("convex", rows()), tmp_path / "page", "convex problems")

    assert "The convex problems of a sequence" in page.read_text(encoding="utf-8")
