"""The check over frames against the scalar check, row by row, for good and broken answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import scenario_frame
from hard_cases import hard_frame

from dubins_study.study.check.verdict import judge
from dubins_study.study.check.verdict_frame import VERDICTS, judge_frame
from dubins_study.study.closed_form.kernel import curvatures, shortest_rows
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import CLAIMS, Paths
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.words import Claim, Verdict
from tests.adversary.frames import analytic, checks_of_frames, judged
from tests.adversary.generators import case, wrong_answer
from tests.adversary.table import Table


@pytest.mark.parametrize("n", [1_000, pytest.param(20_000, marks=pytest.mark.slow)])
def test_frames_say_what_the_scalar_checks_say(n):
    """Of right, longer, missing, broken and absent paths, and of any claim and bound.

    Words are equal, lengths to 1e-14 of the size of what is added up, gaps to 8 ulp of a length,
    and the costates to 1e-6, since they have no bound where a second arc nears half a turn.
    """
    rng, table, answers = np.random.default_rng(n), Table(), []
    for number in range(n):
        table.generator, scenario = case(11, number)
        answers += analytic(table, scenario, {})
        kind, asked = wrong_answer(rng, scenario)
        length, claim = asked.path.total_length, CLAIMS[number % len(CLAIMS)]
        bound = rng.choice([None, 1e9, np.inf, length, length * 0.9])
        answers.append(judged(kind, *asked, claim, bound))
        answers.append(judged("no path", scenario, "LS", None, claim))
    checks_of_frames(table, answers)

    assert table.wrong == 0, str(table)
    found = {(one.judgement.verdict, one.judgement.wrong_basin) for one in answers}
    assert {(Verdict.LONGER, True), (Verdict.LONGER, False)} <= found
    assert {verdict for verdict, _ in found} == set(Verdict)


N = 1200
FRAME = hard_frame(N, seed=11)


def test_the_closed_form_is_judged_optimal_without_the_scalar_check(monkeypatch):
    """Ordinary rows take the quick way: the tolerance for what is not is one row in a hundred."""
    calls = []
    monkeypatch.setattr(
        "dubins_study.study.check.verdict_frame.judge",
        lambda *args: calls.append(1) or judge(*args),
    )
    rows = shortest_rows(*(FRAME[name].to_numpy() for name in NUMBERS[:6]))
    k = np.empty((2, N))
    curvatures(rows.word, FRAME["radius"].to_numpy(), k)
    found = judge_frame(FRAME, Paths(k, np.array([rows.first, rows.second])), Claim.OPTIMAL)

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
