"""Cold against warm starts: quartiles by hand, sentences, the section."""

from __future__ import annotations

import math

import pytest

from dubins_study.report.data.results import load
from dubins_study.report.topics.warm import warm_starts, warm_text
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt
from tests.unit.report.topic_page import topic_page

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


def test_quartiles_by_hand(results):
    """Ratios 0.1 to 0.5 in five steps; iterations halved; none counted is none compared.

    A solver that is never warm is left out.
    """
    table = warm_starts(load([results("radius-sweep", rows())]).rows).set_index("solver")

    assert table.index.tolist() == ["ipopt", "shooting", "slsqp"]
    line = table.loc["ipopt", ["questions", "ratio_q1", "ratio", "ratio_q3"]]
    assert line.tolist() == pytest.approx([5, 0.2, 0.3, 0.4])
    assert table.loc["ipopt", ["work_q1", "work", "work_q3"]].tolist() == [0.5, 0.5, 0.5]
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


def test_sentences_say_what_the_rows_say(results):
    table = warm_starts(load([results("radius-sweep", rows())]).rows)
    text = warm_text(table.assign(name=table["solver"]))

    assert "less than a cold one for ipopt (0.300); as much for shooting (1.00); more for" in text
    assert "In iterations it costs: less than a cold one for ipopt (0.500); more for slsqp" in text
    assert "No solver is right more or less often for it." in text

    worse = rows()
    worse[1] = attempt(scenario(1.0), "ipopt", path=None, claim=Claim.FAILED, initial_guess="warm")
    table = warm_starts(load([results("worse", worse)]).rows)
    text = warm_text(table.assign(name=table["solver"]))
    assert "ipopt is right less often (100 % cold, 80.0 % warm)" in text


def test_the_section_has_the_figure(results, tmp_path):
    topic = "cold against warm starts"
    page = topic_page(results("radius-sweep", rows()), tmp_path / "a", topic)
    cold = [row for row in rows() if row["initial_guess"] == "cold"]
    plain = topic_page(results("cold", cold), tmp_path / "b", topic)

    assert (page.parent / "figures" / "warm-starts.svg").is_file()
    assert "In iterations it costs" in page.read_text(encoding="utf-8")
    assert not (plain.parent / "figures" / "warm-starts.svg").exists()
