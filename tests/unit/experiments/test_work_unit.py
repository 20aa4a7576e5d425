"""Work units: what is left of them once there are rows."""

import json
import math
import socket

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.asking.reply import Reply
from dubins_study.experiments.executors.executor import WorkUnit
from dubins_study.experiments.executors.local import row_of
from dubins_study.experiments.isolation.messages import (
    Channel,
    decode_question,
    encode_question,
)
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.solvers.protocol import Method, Question, Solution
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.rows.parts import row_key, row_path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome

RUN = RunSettings("run", 60.0, jobs=2, executor="dask")


def cell(number: int, scenario: Scenario, start: str = "warm") -> Cell:
    key = (f"id{number}", "slsqp", "default", "best", start, 0, "0" * 12)
    return Cell(*key, scenario, Method(), 60.0)


def solved(one: Cell, arrives: bool = True):
    path = shortest_path(one.scenario)
    solution = Solution(Claim.LOCAL, path) if arrives else Solution(Claim.FAILED)
    reply = Reply(Outcome.RETURNED, solution, Times(0.1, 0.2, math.nan))
    return row_of(one, one.question(), RUN, reply)


# three easy questions in a row, and one beside them
SWEEP = tuple(cell(n, Scenario(0, 0, 0, 9, 3, 1 + n / 8)) for n in range(4))
ALONE = (cell(9, Scenario(0, 0, 0, 5, 5, 1), "cold"),)


def left_of(chains, before, rows):
    """What is left of chains once there are rows of some of their cells."""
    done = {row_key(row): row_path(row) for row in rows}
    rest = WorkUnit(RUN, chains, before).remaining(done)
    return rest.chains, rest.before


def test_what_is_left_begins_after_the_last_row_with_its_path():
    rows = [solved(SWEEP[0]), solved(SWEEP[1]), solved(ALONE[0])]
    left, before = left_of([SWEEP, ALONE], {}, rows)

    assert left == [SWEEP[2:]]
    assert before == {SWEEP[2].key: shortest_path(SWEEP[1].scenario)}


def test_after_a_failure_the_last_path_serves_on():
    """As it does where one pool solves the whole chain."""
    path_before = shortest_path(SWEEP[3].scenario)
    failed = [solved(SWEEP[0], arrives=False)]

    assert left_of([SWEEP], {}, failed) == ([SWEEP[1:]], {})
    left, before = left_of([SWEEP], {SWEEP[0].key: path_before}, failed)
    assert (left, before) == ([SWEEP[1:]], {SWEEP[1].key: path_before})


@given(st.lists(st.integers(1, 5), max_size=6), st.integers(1, 8))
def test_pieces_make_up_the_whole(sizes, most):
    """However a work unit is cut, each cell is in one piece, and no chain overtakes itself."""
    easy = Scenario(0, 0, 0, 9, 3, 1)
    chains = [tuple(cell(10 * n + i, easy) for i in range(k)) for n, k in enumerate(sizes)]
    left, seen = chains, []
    while left:
        first = [one for chain in left for one in chain][:most]
        rows = [solved(one) for one in first]
        seen += [row_key(row) for row in rows]
        left, _ = left_of(left, {}, rows)

    assert seen == [one.key for chain in chains for one in chain]


@pytest.mark.parametrize(
    "route", [{}, {"via": [(0.1, -1e-300), (1 / 3, 7)]}, {"final_heading": 0.1}, {"via": [(2, 1)]}]
)
def test_a_question_travels_as_json(route):
    """Bit by bit, with its via points and final heading."""
    question = Question(Scenario(1, 2, 0.1, 3, 4, 2, label="ä", **route), repeat=3)

    assert decode_question(json.loads(json.dumps(encode_question(question)))) == question


def test_paths_and_arrays_travel_in_messages():
    """Bit by bit; a setting of any name is no path."""
    end, other_end = socket.socketpair()
    path = Path((0.1, -1e-300, 3), [1 / 3, 0.0], [math.nan, 2.0])
    sent = {"settings": {"path": "x"}, "path": path, "arrays": [np.array([0.1, -0.0])]}
    with end, other_end:
        channel = Channel(end)
        channel.put(sent)
        channel.flush()
        received = Channel(other_end).receive()

    assert received["settings"] == {"path": "x"}
    assert received["path"].start == path.start
    assert received["path"].lengths.tobytes() == path.lengths.tobytes()
    assert received["arrays"][0].tobytes() == sent["arrays"][0].tobytes()
