"""The closed form in the page (`scripts/dubins*.js`) against the package, on 10^4 targets."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np
import pytest
from cases import EDGES, PAPER, placed
from hard_cases import hard_frame

from dubins_study.report.page.environment import scripts
from dubins_study.study.angle import parse_angle
from dubins_study.study.body_coordinates import EPS, local
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.extremal import measure
from dubins_study.study.closed_form.shortest import as_path, margin, region_of, shortest
from dubins_study.study.path import Path as Driven
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.scenario_frame import scenarios

BRANCHES = ("LS", "RS", "LR", "RL")
FIELDS = NUMBERS[:-1]  # the speed is no part of the question


def near_circles(n: int) -> list[Scenario]:
    """Targets on and next to edges of words, at 1e-1 to 1e-12 R, of any heading, place and radius.

    Edges are both turning circles, and the circles of three times their radius.
    """
    rng = np.random.default_rng(1)
    cases = []
    for row in range(n):
        R, heading = 10 ** rng.uniform(-2, 3), rng.uniform(-math.pi, math.pi)
        x, y = rng.uniform(-3, 3, 2) * R
        angle, side = rng.uniform(-math.pi, math.pi), rng.choice([-1, 1])
        r = 1 + rng.choice([-1, 0, 1]) * 10.0 ** -(1 + row % 12)
        r *= 3 if row % 5 == 0 else 1  # as far as two arcs reach
        X, Y = r * math.sin(angle), side * (1 - r * math.cos(angle))
        cases.append(placed(X, Y, x, y, heading, R))
    return cases


@cache
def all_cases() -> list[Scenario]:
    """10^4 targets: hard ones, on and near circles, the paper's, and far ones."""
    rng = np.random.default_rng(2)
    far = [Scenario(*rng.uniform(-9, 9, 3), *rng.uniform(-1e6, 1e6, 2), 1.0) for _ in range(1000)]
    named = [*PAPER.values(), *EDGES.values()]
    return [*scenarios(hard_frame(5000, 3)), *near_circles(4000 - len(named)), *far, *named]


@pytest.fixture
def in_page(new_tab):
    """`in_page(body, scenarios)`: what the script's `body`, a function of one scenario, returns."""
    page = new_tab()
    for script in scripts(("tolerances", "dubins", "dubins-certificate")):
        page.add_script_tag(content=script)

    def answers(body: str, cases: list[Scenario]) -> list:
        rows = [{name: getattr(case, name) for name in FIELDS} for case in cases]
        # as text: doubles keep all their digits, and 10^4 rows arrive at once
        answer = f"rows => JSON.stringify(JSON.parse(rows).map({body}))"
        return json.loads(page.evaluate(answer, json.dumps(rows)))

    return answers


def steepness(word: str, segments) -> float:
    """Change of a length per shift of its target: 1, or 1 / |cos(a2 / 2)| of two arcs."""
    return 1.0 if word not in ("LR", "RL") else 1 / max(abs(math.cos(segments[1] / 2)), 1e-6)


def test_every_word_of_ten_thousand_targets_is_the_package_s(in_page):
    """Existence, word, length and segments of all four words.

    Both round sine, cosine and arctangent by up to an ulp, so that X and Y differ by less than
    delta, the data's own uncertainty: a length by delta times its steepness and 8 ulp of the sum.
    Where that decides the side of an edge, the length must be in the package's proven interval.
    """
    cases = all_cases()
    assert len(cases) == 10_000
    undecided = 0

    for case, entries in zip(cases, in_page("dubins.words", cases), strict=True):
        delta = local(case).delta
        for entry in entries:
            optimum = shortest(case, entry["branch"])
            where = f"{case} {entry['branch']}"
            if optimum is None and not entry["exists"]:
                continue
            if entry["exists"] and optimum is not None and entry["word"] == optimum.word:
                slope = steepness(entry["word"], optimum.segments)
                allowed = 2 * slope * delta + 8 * EPS * optimum.total
                if abs(sum(entry["segments"]) - optimum.total) <= allowed:
                    continue
            undecided += 1
            interval = enclose(case, entry["branch"])
            if entry["exists"]:
                assert interval.holds(entry["length"], 8 * EPS * entry["length"]), where
            else:
                assert interval.absent, where

    assert undecided < 0.001 * 4 * len(cases)


def test_lengths_alone_are_those_of_the_words(in_page):
    """The same formulas: the same doubles; absent where a word has no path."""
    cases = all_cases()[::2]
    body = "s => [dubins.lengths(s), dubins.words(s)]"

    for case, (lengths, entries) in zip(cases, in_page(body, cases), strict=True):
        for entry in entries:
            assert lengths[entry["branch"]] == entry["length"], case
        best = next(e for e in entries if e["branch"] == lengths["best"])
        assert best["optimal"], case
        assert set(lengths) == {*BRANCHES, "best"}


def test_the_optimal_words_region_and_margin_are_the_package_s(in_page):
    """One word, or both straight behind; next to an edge whichever the package's intervals hold."""
    cases = all_cases()
    body = "s => [dubins.words(s).filter(e => e.optimal), dubins.region(s), dubins.margin(s)]"
    undecided = 0

    for case, answer in zip(cases, in_page(body, cases), strict=True):
        optimal, region, in_radii = answer
        best, target = shortest(case), local(case)
        assert best is not None
        assert in_radii == pytest.approx(margin(case), rel=1e-9, abs=2 * target.delta)
        same_words = {entry["word"] for entry in optimal} == set(best.words)
        if not same_words or region != region_of(target.w, target.mirrored.w):
            undecided += 1
            for entry in optimal:
                allowed = 8 * EPS * entry["length"]
                assert enclose(case).holds(entry["length"], allowed), case

    assert undecided < 0.001 * len(cases)


def test_certificates_are_the_package_s(in_page):
    """Pontryagin's residual, the costates and the cut margin of every word, as `measure` has them.

    Compared where the words are one path: of equal letters and segments to 1e-9.
    """
    cases = all_cases()[::3]
    compared = 0

    for case, entries in zip(cases, in_page("dubins.words", cases), strict=True):
        for entry in entries:
            optimum = shortest(case, entry["branch"])
            if optimum is None or entry["word"] != optimum.word:
                continue
            driven = [length for length in optimum.segments if length > 0]
            if not np.allclose(entry["segments"], driven, rtol=0, atol=1e-9):
                continue
            path = as_path(case, optimum.word, optimum.segments)
            extremal, cut = measure(path, case.radius)
            found = entry["certificate"]
            # 1e-9 of the segments, twice; 1e9 R away positions lose 16 ulp a radius in costates
            allowed = 4e-9 + 64 * EPS * optimum.total
            assert found["cut_margin"] == pytest.approx(cut, abs=allowed), case
            if extremal is None:
                assert found["residual"] == 0
                continue
            assert found["abnormal"] == extremal.abnormal
            if extremal.abnormal:  # a second arc of pi: the costates' sign hangs on its last ulp
                continue
            assert found["residual"] == pytest.approx(extremal.pmp_residual, abs=allowed), case
            size = max(1.0, math.hypot(*extremal.nu))
            costates = found["costate_x"], found["costate_y"]
            assert np.allclose(costates, extremal.nu, rtol=0, atol=allowed * size**2), case
            compared += 1

    assert compared > 2 * len(cases)


@pytest.mark.slow
def test_a_polyline_stays_on_the_path_which_arrives(in_page):
    """Every point lies on the path as the package drives it; arcs are divided finely."""
    # `at` loses digits of larger headings
    cases = [case for case in all_cases()[::10] if abs(case.heading) < 10]
    body = "s => dubins.words(s).map(e => e.exists"
    body += " && [e, dubins.polyline(s, e.curvatures, e.lengths, 40)])"

    for case, answers in zip(cases, in_page(body, cases), strict=True):
        for answer in filter(None, answers):
            entry, points = answer
            path = Driven(case.start, entry["curvatures"], entry["lengths"])
            end = path.end
            miss = math.hypot(end.x - case.target_x, end.y - case.target_y)
            # on an edge the path goes to another target within delta, twice; then 32 ulp
            rounding = 32 * EPS * (case.extent + entry["length"])
            assert miss <= 4 * local(case).delta * case.radius + rounding, f"{case} {entry}"
            turns = np.abs(path.curvatures * path.lengths)
            parts = [max(1, math.ceil(40 * t / (turns.sum() or 1))) for t in turns]
            ends = np.concatenate([[0.0], np.cumsum(path.lengths)])
            along = [
                ends[i] + path.lengths[i] * j / n
                for i, n in enumerate(parts)
                for j in range(1, n + 1)
            ]
            expected = path.at([0.0, *along])[:, :2]
            assert len(points) == len(expected)
            assert np.abs(np.array(points) - expected).max() <= 2 * rounding, case


def test_bad_input_is_refused_by_name(new_tab):
    """A scenario that cannot be names the field and the value."""
    page = new_tab()
    for script in scripts(("tolerances", "dubins", "dubins-certificate")):
        page.add_script_tag(content=script)
    good = {"x": 0, "y": 0, "heading": parse_angle("120deg"), "target_x": 1, "target_y": 2}
    for change, text in (
        ({"radius": 0}, "radius is 0; expected a number above 0"),
        ({"radius": "1"}, "radius is 1; expected a finite number"),
        ({"radius": 1, "x": None}, "x is null; expected a finite number"),
        ({"radius": 1e-13, "x": 2}, "radius is 1e-13; expected at least"),
    ):
        body = "s => { try { dubins.words(s); return 'taken' } catch (e) { return e.message } }"
        assert page.evaluate(body, good | change).startswith(text)
