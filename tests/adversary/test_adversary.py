"""The campaign passes the package and finds planted faults."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from dubins_study.study.path import Path
from dubins_study.study.route.search import Route, search
from dubins_study.study.words import Proof, Verdict
from tests.adversary import WHOLE, checks, frames, routes, routes_judged
from tests.adversary.campaign import run
from tests.adversary.table import CHECKS, Table

SEED = 9
FEW = 200
ALL, ROUTES = (10_000, len(routes.LENGTHS)) if WHOLE else (5_000, 500)
PARTS = 10  # of the slow run, so that they are shared out among the workers


def test_no_counterexample_in_few_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every generator meets every check without a counterexample.

    A bound of a route that is hardly too high is seen.
    """
    table = run(SEED, 0, FEW)
    spoilt = Table()
    lengths = [routes.attack(table, 0, number) for number in range(1, 5)]

    assert table.wrong == 0, str(table)
    assert {check for check, _ in table.cells} == set(CHECKS)
    assert lengths == pytest.approx(routes.LENGTHS[1:5], rel=1e-6)
    right = routes.search
    monkeypatch.setattr(routes, "search", lambda *a, **o: _raised(right(*a, **o)))
    routes.attack(spoilt, 0, 1)
    assert spoilt.wrong == 1


def _raised(route: Route) -> Route:
    return route._replace(low=route.high * (1.0 + 1e-11))


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("part", range(PARTS))
def test_no_counterexample(part: int) -> None:
    """Every case passes; the cases come in parts."""
    size = ALL // PARTS
    table = Table()
    for low in range(part * size, (part + 1) * size, 500):
        table.add(run(SEED, low, low + 500))

    assert table.wrong == 0, str(table)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("part", range(PARTS))
def test_no_bound_is_above_a_length_that_was_found(part: int) -> None:
    """No bound is above a length of an attack.

    Where one is, its route is attacked anew: rounding may put its points elsewhere.
    """
    table = Table()
    for number in range(part, ROUTES, PARTS):
        low = routes.proven(routes.route_of_seed(number, 0)[1], number).low
        if low * (1.0 - routes.TOLERANCE) > routes.LENGTHS[number]:
            routes.attack(table, 0, number)

    assert table.wrong == 0, str(table)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("seed", range(12))
def test_lattice_routes_close(seed: int) -> None:
    """Lattice routes close, and no attack beats them.

    Their points and headings are round numbers, often on turning circles.
    """
    rng = np.random.default_rng((18, seed))
    steps = rng.integers(-3, 4, (2 + seed % 4, 2))
    steps[~steps.any(axis=1)] = 1, 1
    points = np.vstack([[0, 0], np.cumsum(steps, axis=0)]).astype(float)
    first, last = 0.25 * math.pi * rng.integers(-3, 5, 2) * (rng.random(2) < 0.5)
    asked = routes.Asked(points, first, None if rng.random() < 0.5 else last)

    route = search(*asked, limit=60.0, tolerance=1e-9)
    length = routes.attacked(asked, rng)

    assert route.closed
    assert length >= route.low * (1.0 - routes.tolerated(asked))


def _longer(path: Path | None) -> Path | None:
    """The path, longer by a share of 1e-13."""
    return path and Path(path.start, path.curvatures, path.lengths * (1 + 1e-13))


Spoil = Callable[[Any], Any]
SPOILT: dict[str, tuple[Any, str, Spoil]] = {
    "closed form length": (checks, "shortest_path", _longer),
    "closed form existence": (checks, "shortest", lambda _: None),
    "kernel length": (frames, "shortest_path", _longer),
    "parts hold truth": (checks, "enclose", lambda e: e._replace(parts=e.parts[:-1])),
    "absent": (checks, "enclose", lambda e: e._replace(absent=not e.absent)),
    "enclosure decided": (checks, "enclose", lambda e: e._replace(high=float("inf"))),
    "enclosure width": (checks, "enclose", lambda e: e._replace(low=0.0)),
    "bounds": (checks, "certify", lambda c: replace(c, false_bound=not c.false_bound)),
    "frame judgement": (frames, "judge", lambda j: replace(j, region="circle")),
    "frame gap": (frames, "judge", lambda j: replace(j, gap=j.gap and j.gap + 1e-14)),
    "analytic claim": (frames, "judge", lambda j: replace(j, false_claim=True)),
    "verdict": (checks, "judge", lambda j: _swapped(j)),
    "arrival": (checks, "judge", lambda j: replace(j, verdict=Verdict.MISSES)),
    "broken path": (checks, "judge", lambda j: replace(j, verdict=Verdict.OPTIMAL)),
    "proved": (checks, "certify", lambda c: replace(c, proof=Proof.PROVED)),
    "route claim": (routes_judged, "judge", lambda j: _swapped(j)),
    "route verdict": (routes_judged, "judge", lambda j: _swapped(j)),
    "route arrival": (routes_judged, "judge", lambda j: replace(j, verdict=Verdict.MISSES)),
    "route bound": (routes_judged, "certify", lambda c: replace(c, reference_low=1e9)),
    "route false bound": (routes_judged, "certify", lambda c: replace(c, false_bound=True)),
    "leg length": (routes_judged, "leg_length", lambda length: length * (1 + 1e-8)),
    "certificate": (checks, "certify", lambda c: replace(c, pmp_residual=0.0, cut_margin=1.0)),
}


def _swapped(judged: Any) -> Any:
    other = {Verdict.OPTIMAL: Verdict.LONGER, Verdict.LONGER: Verdict.OPTIMAL}
    return replace(judged, verdict=other.get(judged.verdict, judged.verdict))


@pytest.mark.smoke
@pytest.mark.many(4)
@pytest.mark.parametrize("check", SPOILT)
def test_campaign_sees_what_is_spoilt(check: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A spoilt result is a counterexample of its check.

    It is altered by little, or by one flag.
    """
    room, name, spoil = SPOILT[check]
    right = getattr(room, name)
    monkeypatch.setattr(room, name, lambda *args, **options: spoil(right(*args, **options)))

    # a route or a leg with a final heading follows one case in 25, and takes as long as all of them
    table = run(SEED, 101, 125)
    if room is routes_judged:
        table = run(SEED, 100, 101)
        table.add(run(SEED, 125, 126))

    assert check in table.first, str(table)
