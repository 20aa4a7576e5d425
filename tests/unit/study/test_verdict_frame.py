"""The check over frames against the scalar check, row by row, for good and broken answers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import scenario_frame
from hard_cases import hard_frame

from dubins_study.study.check.two_arcs import PATH_WORDS
from dubins_study.study.check.verdict import judge
from dubins_study.study.check.verdict_frame import NO_WORD, REGIONS, VERDICTS, judge_frame
from dubins_study.study.closed_form.kernel import WORDS, curvatures, shortest_rows
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import CLAIMS, Paths
from dubins_study.study.scenario import NUMBERS, Scenario, scenarios
from dubins_study.study.words import BRANCHES, Claim, Verdict

N = 1200
FRAME = hard_frame(N, seed=11)
TEXTS = {"verdict": VERDICTS, "word": PATH_WORDS, "reference_word": WORDS, "region": REGIONS}


def answers(branch):
    """Controls of the closed form, shape (2, n) each, and which rows have a path."""
    x, y, heading, tx, ty, radius = (FRAME[name].to_numpy() for name in NUMBERS[:6])
    rows = shortest_rows(x, y, heading, tx, ty, radius, branch=branch)
    k, returned = np.empty((2, N)), ~np.isnan(rows.length)
    curvatures(rows.word, radius, k)
    return k, np.where(returned, [rows.first, rows.second], 0.0), returned


R = FRAME["radius"].to_numpy()


def broken(rng, k, length):
    k, length = k.copy(), length.copy()
    k[rng.integers(0, 2, N), np.arange(N)] *= rng.choice([-1, 0, 1], N)
    k[rng.integers(0, 2, N // 9), np.arange(0, N, 9)[: N // 9]] = np.nan
    length[1, ::7] *= -1
    length[0, ::31] = np.inf
    return k, length


def at_random(rng, k, length):
    length = rng.exponential(1, k.shape) * R * rng.choice([0, 1e-7, 1], k.shape)
    return rng.choice([-1, 0, 1], k.shape) / R, length


def powers(rng, low, high):
    return 10.0 ** rng.uniform(low, high, (2, N))


def signs(rng):
    return rng.choice([-1, 1], (2, N))


SPOILERS = {
    "as they are": lambda rng, k, s: (k, s),
    "stretched": lambda rng, k, s: (k, s * (1 + powers(rng, -14, 0))),
    "shifted": lambda rng, k, s: (k, s + R * powers(rng, -9, -3) * signs(rng)),
    "bent": lambda rng, k, s: (k * (1 + powers(rng, -12, 0) * signs(rng)), s),
    "a full turn": lambda rng, k, s: (
        k,
        s + 2 * math.pi * R * rng.integers(0, 2, (2, N)) * [[1], [0]],
    ),
    "broken": broken,
    "at random": at_random,
}


def judged_alike(paths, claims, branch):
    """What the check of the frame says; it is what the scalar check says of every row."""
    found = judge_frame(FRAME, paths, claims, branch)
    for row, scenario in enumerate(scenarios(FRAME)):
        claim = claims if isinstance(claims, Claim) else CLAIMS[claims[row]]
        expected = judge(scenario, paths.path(row, scenario), claim, branch)
        assert difference(expected, found, row, scenario) is None, scenario
    return found


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")  # inf - inf in a broken path
@pytest.mark.parametrize("spoiler", SPOILERS)
@pytest.mark.parametrize("branch", BRANCHES)
def test_rows_are_judged_as_the_scalar_check_does(branch, spoiler):
    rng = np.random.default_rng(3)
    k, length, returned = answers(branch)
    paths = Paths(*SPOILERS[spoiler](rng, k, length), returned)
    judged_alike(paths, rng.integers(0, len(CLAIMS), N), branch)


def test_another_branch_than_the_one_asked():
    """RS paths for the question `best`: wrong basins, and longer ones that are none."""
    found = judged_alike(Paths(*answers("RS")), Claim.OPTIMAL, "best")

    assert found.wrong_basin.sum() > N / 10
    np.testing.assert_array_equal(
        found.false_claim, found.verdict != VERDICTS.index(Verdict.OPTIMAL)
    )


def difference(expected, found, row, scenario):
    """The first field that differs, with both values; None if there is none.

    Numbers may differ by 1e-14 of the size of what is added up: coordinates, radius and length.
    References of paths shorter than the shortest follow the end point, whose last digits differ
    between two integrations, at a rate of up to 1e3 here: 1e-11.
    """
    size = scenario.extent + scenario.radius + (expected.length or 0.0)
    units = {
        "length": size,
        "miss": size,
        "reference": 1e3 * size,
        "travel_time": size / scenario.speed,
        "gap": 1e3 * size / scenario.radius,
        "margin": size / scenario.radius,
        "curvature_excess": 1 + (expected.curvature_excess or 0.0),
    }
    for name, unit in units.items():
        one, other = getattr(expected, name), getattr(found, name)[row]
        one = math.nan if one is None else one
        if not (one == other or (one != one and other != other)) and not (
            abs(one - other) <= 1e-14 * unit
        ):
            return name, one, other
    for name, texts in TEXTS.items():
        code = getattr(found, name)[row]
        other = None if code == NO_WORD else texts[code]
        if getattr(expected, name) != other:
            return name, getattr(expected, name), other
    for name in ("false_claim", "wrong_basin"):
        if getattr(expected, name) != getattr(found, name)[row]:
            return name, getattr(expected, name), getattr(found, name)[row]
    return None


def test_the_closed_form_is_judged_optimal_without_the_scalar_check(monkeypatch):
    """Ordinary rows take the quick way: the tolerance for what is not is one row in a hundred."""
    calls = []
    monkeypatch.setattr(
        "dubins_study.study.check.verdict_frame.judge",
        lambda *args: calls.append(1) or judge(*args),
    )
    k, length, _ = answers("best")
    found = judge_frame(FRAME, Paths(k, length), Claim.OPTIMAL)

    assert (found.verdict == VERDICTS.index(Verdict.OPTIMAL)).all()
    assert not found.false_claim.any()
    ordinary = (FRAME["heading"].abs() < LARGEST_ANGLE).sum()
    assert len(calls) < N - ordinary + N / 100


def test_empty_frames_and_wrong_shapes():
    empty = Paths(np.zeros((2, 0)), np.zeros((2, 0)))

    assert judge_frame(FRAME[:0], empty).verdict.shape == (0,)
    with pytest.raises(ValueError, match="0 paths for 1200 scenarios"):
        judge_frame(FRAME, empty)
    with pytest.raises(ValueError, match=r"length has shape \(2, 3\); expected \(2, 4\)"):
        Paths(np.zeros((2, 4)), np.zeros((2, 3)))


def test_a_longer_path_of_a_tie_is_in_the_right_basin():
    """Straight behind, LS and RS tie: either word, coarsely driven, turns the right way."""
    behind = Scenario(0, 0, 0, -1, 0, 1)
    paths = [shortest_path(replace(behind, radius=1.1), word) for word in ("LS", "RS")]
    controls = (np.array([getattr(p, name) for p in paths]).T for name in ("curvature", "length"))
    found = judge_frame(scenario_frame([behind, behind]), Paths(*controls))

    assert [VERDICTS[code] for code in found.verdict] == [Verdict.LONGER] * 2
    assert not found.wrong_basin.any()
    assert not any(judge(behind, path).wrong_basin for path in paths)
