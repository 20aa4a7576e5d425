"""Dense tracks have sane routes and honest limits.

That holds whatever the limit of time.
"""

import gc
from time import process_time

import pytest

from dubins_study import Scenario
from dubins_study.asking.attempt import judged
from dubins_study.asking.reply import ask
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question
from dubins_study.study.route.search import compile_loops, search
from dubins_study.study.tolerances import tolerances
from tests.adversary import dense

SANE = 1.01  # times the shorter of two routes that take milliseconds
ROUNDING = 1e-9  # relative, of two programs that add thousands of lengths
LATE_S = 0.3  # what solving may take beyond its limit


@pytest.mark.slow
@pytest.mark.parametrize("limit", [1.0, 3.0])
@pytest.mark.parametrize("seed", range(12))
def test_dense_tracks_have_sane_routes(seed, limit):
    """A sane path, an honest interval, in time.

    The tracks have 50 to 5 000 points; the search has a limit.
    """
    _, points, first = dense.track_of_seed(seed)
    bisecting, program = dense.lengths(points, first)
    (x, y), *via, (target_x, target_y) = points.tolist()
    scenario = Scenario(x, y, first, target_x, target_y, via=[tuple(point) for point in via])
    question = Question(scenario)
    compile_loops()
    gc.collect()  # or a collection of all that other tests left falls into the limit: up to 1 s

    began = process_time()  # a busy machine takes the wall clock, not the processor
    reply = ask(Analytic(), question, limit)
    spent = process_time() - began
    answer = judged("analytic", question, reply, tolerances("default", limit))

    assert spent <= limit + LATE_S
    if spent > 0.5 * answer.solve_s:  # a busy machine may give too little of the limit
        assert answer.length <= SANE * min(bisecting, program)
    assert answer.reference_low <= program * (1.0 + ROUNDING)
    assert answer.reference_low <= answer.length * (1.0 + ROUNDING)
    assert answer.verdict in ("optimal", "undecided")
    assert not answer.false_bound


@pytest.mark.many(1)
@pytest.mark.parametrize("seed", [5, 7, 15])
def test_more_effort_makes_no_path_longer(seed):
    """More effort makes no path longer.

    The search does the same work in the same order, and keeps the best route.
    """
    _, points, first = dense.track_of_seed(seed)
    bisecting, program = dense.lengths(points, first)

    searches = [search(points, first, boxes=boxes) for boxes in (0, 1_000, 10_000, 100_000)]

    lengths = [route.length for route in searches]
    assert lengths[0] <= SANE * min(bisecting, program)
    assert lengths == sorted(lengths, reverse=True)
    assert [route.low for route in searches] == sorted(route.low for route in searches)


@pytest.mark.smoke
@pytest.mark.parametrize(("points", "spacing"), [(200, 0.2), (5000, 0.5)])
def test_the_first_route_of_a_circle_has_no_loops(points, spacing):
    """The first route of a circle has no loops.

    Its points lie on a circle of 5R. No effort is spent but for the first route.
    """
    track = dense.circle(points, spacing, radius=5.0)

    route = search(track, 0.0, boxes=0)

    assert route.low <= route.length <= route.low * 1.01
