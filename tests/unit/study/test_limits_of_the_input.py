"""The edges of an admissible scenario.

All that is accepted is judged, and nothing raises.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import solve
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario, ScenarioError
from dubins_study.study.words import BRANCHES, Claim, Verdict
from tests.adversary.frames import checks_of_frames, judged
from tests.adversary.table import Table


def test_beyond_the_largest_extent():
    with pytest.raises(ScenarioError, match=r"radius is 1\.0; expected at least 1\.01 beside"):
        Scenario(target_x=1.01e13, target_y=0)


@pytest.mark.slow
def test_a_path_whose_end_no_scenario_may_have_is_judged():
    """A path with an inadmissible end is judged.

    Found by fuzzing: the end of an answer may lie beyond the largest coordinate.
    """
    scenario = Scenario(0, 0, 0.5, -1e150, 1e149, 1e150)
    exact = solve(scenario)
    beyond = Path(scenario.start, exact.path.curvatures, exact.path.lengths * (1 - 1e-9))
    at_edge = Path(scenario.start, [0.0], [1.0])
    for path in (exact.path, beyond, at_edge):
        judgement = judge(scenario, path, Claim.OPTIMAL)
        assert judgement.verdict in (Verdict.OPTIMAL, Verdict.MISSES)
    assert solve(scenario, "ipopt").verdict is Verdict.OPTIMAL


# rates and lengths of pieces: broken, next to full, next to nothing, and about the sizes of ripples
NUMBERS = st.one_of(
    st.sampled_from([0.0, -0.0, 5e-324, 1.0, -1.0, 1e13, 1e150, -1e150, 1e-150, math.pi, 2.0]),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e308, -1e308, 1e-308, 1e300, 1e100, -1e100]),
    st.sampled_from([1 + 5e-10, 1 - 2e-9, -1 + 1e-9, -1e-10, 3e-10, 1e-7, 1e-3, -1e-3, 2e-3, 0.5]),
    st.sampled_from([1e-12, 5e-7, 9e-7, 2e-6, 1e-4, 1e3, 1e6]),
    st.floats(-10, 10),
    st.floats(),
)
SIZES = st.sampled_from([1.0, 1e150, 1e-150, 1e-140, 1e137, 3e5])


@st.composite
def extreme_scenarios(draw):
    """Any accepted scenario, its sizes drawn from the limits."""
    radius = draw(SIZES)
    numbers = [
        draw(st.floats(-3, 3)) * draw(st.sampled_from([1, 8e11, 1e-12, 0])) for _ in range(4)
    ]
    heading = draw(st.sampled_from([0.0, 0.5, -1e150, 3.0]))
    scaled = [max(-1e150, min(1e150, number * radius)) for number in numbers]
    return Scenario(*scaled[:2], heading, *scaled[2:], radius, draw(st.sampled_from([1.0, 1e-150])))


@given(
    extreme_scenarios(),
    st.lists(st.tuples(NUMBERS, NUMBERS), max_size=2) | st.lists(st.tuples(NUMBERS, NUMBERS)),
    st.booleans(),
    st.sampled_from(BRANCHES),
    st.none() | NUMBERS,
    st.booleans(),
)
def test_the_check_never_raises(scenario, pieces, in_radii, branch, bound, exact):
    """The check never raises.

    Any path, drivable or not, and any bound have a verdict and a certificate; a frame's too.
    """
    unit = scenario.radius if in_radii else 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        curvature = np.array([k for k, _ in pieces]) / unit
        length = np.array([s for _, s in pieces]) * unit
    path = Path(scenario.start, curvature, length)
    if exact:  # next to the answer, and so near the target
        answer = solve(scenario, branch=branch).path
        path = answer and Path(scenario.start, answer.curvatures, answer.lengths * (1 - 1e-9))
    table = Table()
    with np.errstate(over="ignore", invalid="ignore"):
        checks_of_frames(table, [judged("extreme", scenario, branch, path, Claim.OPTIMAL, bound)])

    assert table.wrong == 0, str(table)


@pytest.mark.parametrize("heading", [2e9, -1e12, 1e16, -1e150])
def test_a_frame_knows_the_region_for_a_huge_heading(heading):
    """The target is on no circle and no word is found: nothing else computes the row anew."""
    scenario = Scenario(0.0, 0.0, heading, 0.0, -1.0, 1.0)
    table = Table()
    for branch in BRANCHES:
        one = judged("huge heading", scenario, branch, None, Claim.OPTIMAL, None)
        checks_of_frames(table, [one])

    assert table.wrong == 0, str(table)
