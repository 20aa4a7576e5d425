"""What one worker process does: put questions to solvers, and send back what they reply."""

from __future__ import annotations

import json
import os
import signal
from functools import lru_cache
from multiprocessing.connection import Connection
from typing import NamedTuple

from experiments.clock import Clock, Phase
from experiments.containment import contained
from experiments.isolation import isolate
from experiments.provenance import now, solver_versions
from experiments.wire import Packed, packed
from solvers.answer import Reply, ask, nothing, told
from solvers.protocol import AnySolver, Outcome, Question
from solvers.registry import load
from study.path import Path
from study.scenario import Scenario

# an easy question, asked once of every solver before its first recorded answer
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")


class Order(NamedTuple):
    """One question for a worker: `number` tells its supervisor which one it is at."""

    number: int
    solver: str
    profile: str
    scenario: Scenario
    branch: str
    start: Path | None
    limit: float
    warm_up: bool  # whether a solver that is new here is asked an easy question first


_clock: Clock | None = None


def begin(clock: Clock, output: Connection, memory: int) -> None:
    """Make this process a worker.

    One that pebble starts in place of one that ended waits to be stopped: what the clock says of
    the first is still to be read.
    """
    global _clock
    while clock.read().pid:
        signal.pause()
    isolate(output, memory)
    _clock = clock
    clock.write(os.getpid(), -1, Phase.IDLE)


def answers(orders: list[Order]) -> list[Packed]:
    """Put several questions one after another, and send the replies back in one message."""
    return [answer(order) for order in orders]


def answer(order: Order) -> Packed:
    """Put one question to one solver. Whatever happens short of the process's end is a reply."""
    started = now()
    try:
        with contained():
            _tell(order.number, Phase.PREPARING)
            solver = _ready(order.solver, order.profile, order.warm_up)
            question = Question(order.scenario, order.branch, order.start)
            started = now()
            _tell(order.number, Phase.SOLVING)
            reply = ask(solver, question, order.limit)
            return packed(reply, started, _versions(order.solver))
    except BaseException as error:  # a plug-in that breaks more than its own calls is a row too
        return packed(_failed(error), started, "")
    finally:
        _tell(-1, Phase.IDLE)


def _failed(error: BaseException) -> Reply:
    outcome = Outcome.OUT_OF_MEMORY if isinstance(error, MemoryError) else Outcome.RAISED
    return nothing(outcome, told(error))


def _tell(number: int, phase: Phase) -> None:
    if _clock is not None:
        _clock.write(os.getpid(), number, phase)


@lru_cache(maxsize=256)
def _ready(spec: str, profile: str, warm_up: bool) -> AnySolver:
    """A solver that has its imports, templates and caches behind it."""
    solver = load(spec, profile)
    if warm_up:
        ask(solver, Question(_WARM_UP, solver.branches[0]))
    return solver


@lru_cache(maxsize=256)
def _versions(spec: str) -> str:
    return json.dumps(solver_versions(load(spec)))
