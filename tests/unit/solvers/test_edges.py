"""Targets on and beside the edges.

They mean the same for the closed form, other solvers and the check.

The campaign holds frames and the check beside the truth for each of `FOUND`.
"""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.experiments.solve import solve
from dubins_study.study.body_coordinates import local
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.closed_form.shortest import as_path, shortest
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.adversary.generators import FOUND
from tests.cases import placed

# the branch at whose edge each of them lies
BRANCH = {
    **dict.fromkeys(("beside (0, 4)", "just behind the start"), "LR"),
    **dict.fromkeys(("beside (0, -4)", "next to the start"), "RL"),
    **dict.fromkeys(
        ("top, far from the origin", "top, heading down", "top, ahead by a hair"), "RL"
    ),
}


@pytest.mark.parametrize("name", FOUND)
@pytest.mark.parametrize("solver", ["analytic", "shooting", "slsqp"])
def test_right_answers_are_right(name, solver):
    """Right answers are right.

    Whichever target within delta a solver answers for, its length is right.

    The closed form's is proved, too. Next to the start other solvers answer for a target farther
    off than delta, as their tolerances allow, which is right but proves nothing.
    """
    answer = solve(FOUND[name], solver, BRANCH.get(name, "best"))

    assert not answer.false_claim
    assert not answer.false_bound
    if answer.path is None:
        assert (answer.claim, answer.verdict) == ("infeasible", "none exists")
    else:
        assert answer.verdict == "optimal"
        assert answer.proof == "proved" or (solver != "analytic" and "start" in name)


def test_a_full_turn_to_a_target_that_is_the_start_exactly_is_longer():
    scenario = Scenario(0, 0, 0.4, 0, 0, 1)
    for branch in ("best", "LS", "RL"):
        assert enclose(scenario, branch)[:3] == (0.0, math.ulp(0.0), False)
        turn = judge(
            scenario,
            as_path(scenario.start, scenario.radius, "L", (2 * math.pi, 0.0)),
            branch=branch,
        )
        assert turn.verdict in ("longer", "misses")


@given(
    st.floats(0.3, 2.9),
    st.floats(-1e5, 1e5),
    st.floats(-math.pi, math.pi),
    st.floats(-1.0, 1.0),
)
def test_on_a_front_half_both_lengths_are_right_and_none_between(angle, offset, heading, off):
    """On a front half two lengths are right.

    None between them is. Beside the circle by up to delta / 2 the arc and the path from inside are
    both right.
    """

    def seen(r: float) -> Scenario:
        """A target seen from C_L.

        It is seen under an arc angle, at a distance r.
        """
        return placed(r * math.sin(angle), 1 - r * math.cos(angle), offset, -offset, heading)

    scenario = seen(1 + off * 0.4 * local(seen(1.0)).delta)
    inside = shortest(seen(1 - 10 * local(scenario).delta))
    arc = as_path(scenario.start, scenario.radius, "L", (angle, 0.0))
    around = as_path(scenario.start, scenario.radius, inside.word, inside.segments)

    for path in (arc, around):
        judgement = judge(scenario, path, Claim.OPTIMAL)
        assert (judgement.verdict, judgement.region) == ("optimal", "circle"), path
        assert certify(scenario, path, judgement).proof == "proved"
    assert around.length - arc.length > 0.1
    longer = as_path(scenario.start, scenario.radius, "L", (angle + 2 * math.pi, 0.0))
    assert judge(scenario, longer, Claim.OPTIMAL).false_claim
