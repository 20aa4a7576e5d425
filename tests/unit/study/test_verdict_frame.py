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
from dubins_study.study.path import Paths
from dubins_study.study.scenario import NUMBERS, Scenario
from dubins_study.study.words import Claim, Verdict

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
    with pytest.raises(ValueError, match=r"lengths has shape \(2, 3\); expected \(2, 4\)"):
        Paths(np.zeros((2, 4)), np.zeros((2, 3)))


def test_a_longer_path_of_a_tie_is_in_the_right_basin():
    """Straight behind, LS and RS tie: either word, coarsely driven, turns the right way."""
    behind = Scenario(0, 0, 0, -1, 0, 1)
    paths = [shortest_path(replace(behind, radius=1.1), word) for word in ("LS", "RS")]
    controls = (np.array([getattr(p, name) for p in paths]).T for name in ("curvatures", "lengths"))
    found = judge_frame(scenario_frame([behind, behind]), Paths(*controls))

    assert [VERDICTS[code] for code in found.verdict] == [Verdict.LONGER] * 2
    assert not found.wrong_basin.any()
    assert not any(judge(behind, path).wrong_basin for path in paths)
