"""The audit of published routes: which lengths are the shortest, by proof."""

from __future__ import annotations

import numpy as np
import pytest

from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.plan.scenario_columns import scenarios
from dubins_study.report.paper import routes
from dubins_study.study.check.reference import reference_of

ROUTES = [s for block in read("kaya").experiment.scenarios for s in scenarios(block, "kaya")]


def test_one_published_length_is_not_the_shortest():
    """All others are correct roundings of lengths in intervals of a relative width of 1e-9."""
    records = routes.audit_routes(ROUTES)

    longer = [r for r in records if r["verdict"] != routes.SHORTEST]
    assert [(r["source"], r["label"], r["verdict"]) for r in longer] == [
        ("MPDP", "example 4", routes.LONGER)
    ]
    assert longer[0]["difference"] == pytest.approx(1.5373e-8, rel=1e-3)
    assert all(r["verdict"] == r["expected"] and 0 <= r["width"] <= 1e-9 for r in records)


@pytest.mark.parametrize("scenario", ROUTES, ids=lambda scenario: scenario.label)
def test_the_better_path_is_driven(scenario):
    """Its arcs alone, driven: it passes every point, in order, and ends with its heading."""
    path = reference_of(scenario).path
    poses = path.sample(200_001)
    at = 0
    for point in scenario.points[1:]:
        distances = np.hypot(*(poses[at:, :2] - point).T)
        step = path.length / 200_000
        at += int(np.flatnonzero(distances <= step)[0])
    turned = (path.end.heading - scenario.final_heading) / (2 * np.pi)

    assert np.hypot(*(np.array(path.end[:2]) - scenario.points[-1])) < 1e-9
    assert turned == pytest.approx(round(turned), abs=1e-9)
    assert np.abs(path.curvatures).max() <= (1 + 1e-12) / scenario.radius


@pytest.mark.parametrize(
    ("printed", "verdict"),
    [("3.41", routes.TOO_SHORT), ("3.42", routes.SHORTEST), ("3.43", routes.LONGER)],
)
def test_a_length_may_be_rounded(printed, verdict, monkeypatch):
    """3.4156 rounds to 3.42; no path rounds to 3.41, and 3.43 is longer than a path."""
    line = routes.PrintedRoute("here", "example 1", printed)
    monkeypatch.setattr(routes, "PRINTED_ROUTES", (line,))

    assert routes.audit_routes(ROUTES)[0]["verdict"] == verdict
