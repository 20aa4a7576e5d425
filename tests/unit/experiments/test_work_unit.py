"""Rest of a work unit once rows exist."""

import json
import math
import socket

import numpy as np
import pytest

from dubins_study.experiments.executors.executor import WorkUnit
from dubins_study.experiments.isolation.messages import (
    Channel,
    decode_question,
    encode_question,
)
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.solvers.protocol import Method, Question
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

RUN = RunSettings("run", 60.0, jobs=2, executor="dask")


def cell(number: int, scenario: Scenario, start: str = "warm") -> Cell:
    key = (f"id{number}", "slsqp", "default", "best", start, 0, "0" * 12)
    return Cell(*key, scenario, Method(), 60.0)


# three easy questions in a row, and one beside them
SWEEP = tuple(cell(n, Scenario(0, 0, 0, 9, 3, 1 + n / 8)) for n in range(4))
ALONE = (cell(9, Scenario(0, 0, 0, 5, 5, 1), "cold"),)


def test_a_sweep_is_left_whole_until_all_its_cells_are_done():
    """A sweep stays whole until all cells are done.

    Each of its cells starts from the path of the one before, which no row need hold.
    """
    unit = WorkUnit(RUN, [SWEEP, ALONE])
    keys = [one.key for one in SWEEP]

    assert unit.remaining(set()).chains == [SWEEP, ALONE]
    assert unit.remaining({*keys[:2], ALONE[0].key}).chains == [SWEEP]
    assert unit.remaining({*keys}).chains == [ALONE]


@pytest.mark.parametrize(
    "route", [{}, {"via": [(0.1, -1e-300), (1 / 3, 7)]}, {"final_heading": 0.1}, {"via": [(2, 1)]}]
)
def test_a_question_travels_as_json(route):
    """A question travels as JSON.

    It comes back bit by bit, with its via points and final heading.
    """
    question = Question(Scenario(1, 2, 0.1, 3, 4, 2, label="ä", **route), repeat=3)

    assert decode_question(json.loads(json.dumps(encode_question(question)))) == question


def test_paths_and_arrays_travel_in_messages():
    """Paths and arrays travel in messages.

    They come back bit by bit; a setting of any name is no path.
    """
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
