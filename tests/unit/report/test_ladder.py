"""The ladder of targets toward a turning circle."""

import math

from dubins_study.report.topics.ladder import SIDES, ladder, ladder_section, rungs
from dubins_study.study.closed_form.shortest import shortest, shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt

FRONT, REAR = 0.5, 4.0
MARGINS = (1e-2, 1e-4, 1e-8)


def target(arc, margin):
    """A target near the left circle.

    It lies so many radii outside, at an arc angle.
    """
    r = 1 + margin
    return Scenario(0, 0, 0, r * math.sin(arc), 1 - r * math.cos(arc), 1, label="ladder")


def row(scenario, solver, path="exact", **changes):
    """A row with the bounds of a certificate."""
    optimum = shortest(scenario).total
    bounds = {"reference_low": optimum * (1 - 1e-15), "reference_high": optimum * (1 + 1e-15)}
    return attempt(scenario, solver, path=path, claim=Claim.LOCAL, **(bounds | changes))


def along(scenario, arc):
    """A path along the circle.

    It misses the target by its margin.
    """
    return Path(scenario.start, [1.0], [arc])


def rows():
    """Rows of an exact and an inexact solver.

    The exact path is everywhere; the other solver follows the circle where its miss is below 1e-6.
    """
    attempts = []
    for arc in (FRONT, REAR):
        for margin in (*MARGINS, *(-m for m in MARGINS)):
            scenario = target(arc, margin)
            attempts.append(row(scenario, "collocation"))
            near = abs(margin) < 1e-6
            attempts.append(row(scenario, "ipopt", along(scenario, arc) if near else "exact"))
    return attempts


def test_a_short_path_is_told_from_a_right_one(load_rows):
    """A short path is told from a right one.

    The check calls both optimal; only just inside the front half does a miss pay.
    """
    attempts = rungs(load_rows("ladder", rows()).rows)
    assert (attempts.groupby("side").size()[list(SIDES)] == 6).all()
    short = attempts[attempts["finding"] == "by its miss"]

    assert short[["solver", "side", "rung"]].to_numpy().tolist() == [["ipopt", "front, inside", -8]]


def test_findings_and_the_worst_of_a_rung(load_rows):
    """Findings and the worst of a rung.

    Coarse is not a wrong basin, and a rung is as good as its worst answer.
    """
    inside = target(FRONT, -1e-2)
    other = shortest_path(inside, "RS")
    made = [
        row(inside, "slsqp", gap=1e-3, verdict="longer"),
        row(inside, "slsqp", other, repeat=1, false_claim=True),
        row(inside, "nlp", path=None),
        row(target(FRONT, -1e-4), "nlp"),
    ]
    loaded = load_rows("ladder", made)
    attempts = rungs(loaded.rows)
    table = ladder(attempts)

    assert "Of all 4 claims 2 are false." in ladder_section(loaded).text
    assert attempts["finding"].tolist() == ["coarse", "wrong basin", "no path", "right"]
    assert table["finding"].tolist() == ["wrong basin", "no path", "right"]


def test_the_section_says_what_the_rows_say(load_rows):
    good = [r for r in rows() if r["solver"] == "collocation"]
    text, level = (
        ladder_section(load_rows(name, each)).text
        for name, each in (("ladder", rows()), ("good", good))
    )

    assert "a full turn: 1 answer by a miss of at most 1.0e−8 R." in text
    assert "Of all 24 claims 0 are false." in text
    assert "no solver gets a shorter path by a miss" in level
