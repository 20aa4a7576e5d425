"""The sections on routes, by hand.

Tested are numbers, open routes, published lengths, and searches.
"""

from importlib.resources import files

import numpy as np
import pandas as pd
import pytest

from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.report.paper.routes import LONGER, SHORTEST
from dubins_study.report.topics.audit_tables import printed_routes, printed_section
from dubins_study.report.topics.routes import (
    by_size,
    data_profiles,
    routes_section,
    second_opinion,
    with_legs,
)
from dubins_study.report.topics.searches import reached, runtimes
from dubins_study.study.kinds.shortest import known_route
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, lost, paper_scenarios
from tests.unit.report.topic_page import topic_page

SHORT, FAR = "legs of 1 radius", "legs of 9 radii"


def row(number, solver, legs, verdict="optimal", label=SHORT, gap=0.0, **changes):
    """A judged attempt at a route.

    A number says which route.
    """
    points = [float(n) for n in range(legs - 1)] or None
    via = {"via_x": points, "via_y": points and [9.0 for _ in points]}
    engine = {"claim": Claim.LOCAL, "formulation": "headings", "wall_s": 0.25}
    named = {"scenario_id": f"{label}{legs}-{number}", "verdict": verdict, "gap": gap}
    given = named | via | engine | {"region": None, "margin": None, "label": label} | changes
    return attempt(paper_scenarios()[0], solver, **given)


def rows():
    """Rows of `a` on four routes.

    Of 3 legs one is right, one longer, one open; of 1 leg one is right and one not returned.
    """
    gone = {"scenario_id": "lost", "label": SHORT, "formulation": "headings"}
    return [
        row(0, "a", 3),
        row(1, "a", 3, "longer", gap=0.5, false_claim=True),
        row(2, "a", 3, "undecided", gap=0.1, wall_s=0.75),
        row(0, "a", 1),
        lost(paper_scenarios()[0], "a", **gone),
        *(row(number, "b", 3, label=FAR) for number in range(3)),
        row(2, "analytic", 3, "undecided", gap=1e-3, claim=Claim.FEASIBLE, engine="closed form"),
        row(1, "analytic", 3, claim=Claim.OPTIMAL, engine="closed form"),
    ]


def test_numbers_by_hand(load_rows):
    """Numbers by hand.

    A path that does not arrive has an infinite gap; an open route is no trial, but has a gap.
    """
    results = load_rows("routes", rows())
    cells = by_size(with_legs(results.rows)).set_index(["solver", "label", "legs"])
    section = routes_section(results)
    picture, _ = section.blocks
    three = cells.loc[("a", SHORT, 3)]
    one = cells.loc[("a", SHORT, 1)]

    assert (three["successes"], three["trials"], three["left_open"]) == (1, 2, 1)
    assert (three["low"], three["high"]) == pytest.approx((0.0945, 0.9055), abs=5e-5)
    assert (three["gap"], three["wall_s"]) == (0.1, 0.25)
    assert (one["successes"], one["trials"], one["left_open"]) == (1, 2, 0)
    assert cells.loc[("analytic", SHORT, 3), "trials"] == 1
    assert len(cells) == 4
    assert "1 of 8 routes are open" in section.text
    assert "closes 1 of its 2 attempts" in section.text
    written = {text.get_text() for ax in picture.figure.axes for text in ax.texts}
    assert {"1/2?", "1/2", "3/3", "1/1?"} <= written


def test_a_repeat_is_a_part_of_a_route(load_rows):
    """A repeat is a part of a route.

    Two right answers of three are 2/3 of one trial; open routes are counted once.
    """
    verdicts = ["optimal", "optimal", "longer"]
    attempts = [row(0, "a", 2, verdict, repeat=n) for n, verdict in enumerate(verdicts)]
    attempts += [row(1, "a", 2, "undecided", repeat=n) for n in range(3)]
    (line,) = by_size(with_legs(load_rows("routes", attempts).rows)).to_dict("records")

    assert (line["successes"], line["trials"]) == (pytest.approx(2 / 3), 1)
    assert line["left_open"] == 1


def bounds_of_gdip():
    with (files("dubins_study.report.topics") / "gdip.csv").open(encoding="utf-8") as file:
        return pd.read_csv(file, comment="#").set_index("scenario_id")["low"]


def test_another_program_is_asked_too():
    """Another program is asked too.

    Of two routes one bound is within a thousandth, the other above the path that is shortest.
    """
    low = bounds_of_gdip().iloc[:2]
    high = 2 * low.to_numpy() * [1.001, 0.9]
    frame = pd.DataFrame({"scenario_id": [*low.index], "reference_high": high, "radius": 2.0})
    text = second_opinion(pd.concat([frame, frame]))

    assert "gives lower bounds of 2 of these routes; 1 of them contradict the check" in text
    assert second_opinion(frame.assign(scenario_id="none")) == ""


def test_the_bounds_of_another_program_and_ours_agree():
    """Another program's bounds and ours agree.

    No bound of gdip's lies above the search's path; those of two far legs lie just below it.
    """
    bounds = bounds_of_gdip()
    far = {}
    for chain in plan_run(Request("benchmark-route", solvers=["analytic"])).chains:
        scenario = chain[0].scenario
        low = bounds.get(chain[0].scenario_id)
        if low is not None and scenario.legs <= 5 and scenario.label != "legs of 0.5 R to 2 R":
            route = known_route(scenario, 2.0, 10.0)
            assert low <= route.high * (1 + 1e-5)
            if scenario.legs == 2:
                far[chain[0].scenario_id] = low / route.low

    assert len(far) == 10
    assert min(far.values()) > 0.9999


def test_a_page_of_all_kinds_of_routes(results, tmp_path):
    """A page of all kinds of routes.

    All are undecided, none arrives, or one leg is alone: nothing fails, and the anchor is there.
    """
    open_ = [row(n, "a", 2, "undecided", gap=0.1, claim=Claim.NONE) for n in range(2)]
    gone = [lost(paper_scenarios()[n], "b", label=FAR) for n in range(2)]
    page = topic_page(results("routes", [*open_, *gone]), tmp_path / "out", "routes")

    assert 'id="routes"' in page.read_text(encoding="utf-8")


def test_published_lengths(load_rows):
    """Published lengths are judged by intervals.

    A length above the interval is longer; one that rounds to a length in it is the shortest.
    """
    ours = {"length": 7.46756218196, "reference_low": 7.4675621, "reference_high": 7.467562182}
    worse = ours | {"length": 7.5, "gap": 1e-2, "verdict": "longer"}
    attempts = [
        row(0, "a", 11, label="example 4", **worse),
        row(0, "b", 11, label="example 4", **ours),
    ]
    results = load_rows("kaya", attempts)
    frame = printed_routes(with_legs(results.rows)).set_index("source")
    section = printed_section(results)

    assert frame["verdict"].to_dict() == {"Kaya": SHORTEST, "MPDP": LONGER}
    assert frame.loc["MPDP", "difference"] == pytest.approx(7.46756219733843 - 7.46756218196)
    assert frame["legs"].tolist() == [11, 11]
    assert "1 of 2 published lengths" in section.text
    assert "MPDP, example 4: longer" in section.text


def traced(evaluations, lengths, solver="a"):
    via = {
        "via_x": [1.0],
        "via_y": [2.0],
        "target_x": 9.0,
        "closed": None,
        "verdict": "longer",
        "presolved": False,
        "answerable": True,
        "late": False,
    }
    known = {"reference_low": 10.0, "radius": 1.0, "solver": solver}
    return {**via, **known, "trace_evaluations": evaluations, "trace_lengths": lengths}


def test_a_target_is_reached_by_the_first_path_within_it():
    """The first path within a target reaches it.

    By hand: gaps of 0.2 and 0.05 after 1 and 10 evaluations; without a trace, at its end.
    """
    first = reached(traced([1.0, 10.0], [12.0, 10.5]) | {"evaluations": 99.0, "end_gap": 1.0})
    last = reached(traced(None, None) | {"evaluations": 50.0, "end_gap": 1e-3})

    assert first.tolist() == [10.0] + [np.inf] * 7
    assert last.tolist() == [50.0] * 3 + [np.inf] * 5


def test_curves_count_targets_of_all_attempts():
    """Curves count targets of all attempts.

    One attempt of two reaches all targets at 20 evaluations; the routes have their own panel.
    """
    attempts = [traced([20.0], [10.0]), traced([5.0], [15.0])]
    rows = pd.DataFrame(attempts).assign(evaluations=100.0, gap=[0.0, 0.5])
    one_leg = pd.DataFrame([traced(None, None)]).assign(via_x=None, evaluations=9.0, gap=1e-4)

    panels = runtimes(pd.concat([rows, one_leg]))

    assert list(panels) == ["1 leg", "2 legs"]
    assert panels["2 legs"]["a"].loc[:19.0].max() == 0
    assert panels["2 legs"]["a"].iloc[-1] == 0.5
    assert panels["1 leg"]["a"].iloc[-1] == 0.5  # four of eight targets


def test_a_data_profile_counts_what_is_within_its_target_in_time(load_rows):
    """A data profile counts timely answers within targets.

    Two routes of three are within 1e-4, one of them late; the longest path is only within 1e-2.
    """
    attempts = [row(0, "a", 2, gap=1e-9, wall_s=0.1), row(1, "a", 2, gap=5e-3, wall_s=0.2)]
    attempts += [row(2, "a", 2, gap=1e-5, wall_s=0.3)]
    panels = data_profiles(with_legs(load_rows("routes", attempts).rows))
    ends = {title: round(float(table["a"].iloc[-1]), 6) for title, table in panels.items()}

    assert ends == {"gap up to 1e-2": 1.0, "gap up to 1e-4": 0.666667, "gap up to 1e-8": 0.333333}
    assert panels["gap up to 1e-2"]["a"][:0.15].iloc[-1] == pytest.approx(1 / 3)
