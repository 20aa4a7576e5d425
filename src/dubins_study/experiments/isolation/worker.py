"""What one worker process does: put questions to solvers, and send back what they reply."""

from __future__ import annotations

import json
import os
import signal
from functools import lru_cache
from multiprocessing.connection import Connection
from time import monotonic
from typing import NamedTuple

from dubins_study.experiments.isolation.clock import Clock, Phase
from dubins_study.experiments.isolation.containment import bound, contained
from dubins_study.experiments.isolation.messages import Packed, packed
from dubins_study.experiments.isolation.sandbox import depend, isolate
from dubins_study.experiments.plan.code_digest import code
from dubins_study.experiments.provenance import now, solver_versions
from dubins_study.solvers.attempt import Reply, ask, nothing, told
from dubins_study.solvers.protocol import Outcome, Question, Solver
from dubins_study.solvers.registry import load
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

# an easy question, asked once of every solver before its first recorded answer
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")


class Order(NamedTuple):
    """One question for a worker: `number` tells its supervisor which one it is at."""

    number: int
    solver: str
    profile: str
    scenario: Scenario
    branch: str
    initial_guess: Path | None
    limit: float
    warm_up: bool  # whether a solver that is new here is asked an easy question first


# s of solving after which replies are sent
_MOMENT = 0.1

_clock: Clock | None = None
_pid = 0


def begin(clock: Clock, output: Connection, memory: int) -> None:
    """Make this process a worker."""
    global _clock, _pid
    depend()
    bound(memory)
    isolate(output, memory)
    _clock, _pid = clock, os.getpid()
    clock.write(_pid, -1, Phase.IDLE)


def answers(orders: list[Order]) -> list[Packed]:
    """Put several questions one after another, and send the replies back in one message.

    Once that has taken a moment the rest is left for another message: replies that wait are lost
    if the run is killed, and an interrupted run waits for no more than the solve under way. A
    worker that a solver has left worn stops as well, and answers no more until it is replaced.
    """
    replies, began = [], monotonic()
    for order in orders:
        replies.append(answer(order))
        if replies[-1].worn or monotonic() - began > _MOMENT:
            break
    return replies


_worn = False


def answer(order: Order) -> Packed:
    """Put one question to one solver. Whatever happens short of the process's end is a reply.

    A worker that a solver has left worn answers no more, and waits to be replaced.
    """
    global _worn
    while _worn:
        signal.pause()
    started, state = now(), None
    try:
        with contained() as state:
            loaded = (order.solver, order.profile) not in _solvers
            solver = _ready(order)
            state.pardon(loaded)
            question = Question(order.scenario, order.branch, order.initial_guess)
            started = now()
            _tell(order.number, Phase.SOLVING)
            reply = ask(solver, question, order.limit)
            sent = packed(reply, started, _versions(order.solver), _code(order))
    except BaseException as error:  # a plug-in that breaks more than its own calls is a row too
        sent = packed(_failed(error), started, "", _code(order))
    finally:
        _tell(order.number, Phase.IDLE)
    _worn = state is not None and state.worn
    return sent._replace(worn=_worn)


def _failed(error: BaseException) -> Reply:
    outcome = Outcome.OUT_OF_MEMORY if isinstance(error, MemoryError) else Outcome.RAISED
    return nothing(outcome, told(error))


def _tell(number: int, phase: Phase) -> None:
    if _clock is None:
        return
    if os.getpid() != _pid:
        # a child that a solver forked and lost: it must not answer in its parent's place
        os._exit(1)
    _clock.write(_pid, number, phase)


_solvers: dict[tuple[str, str], Solver] = {}
# of those that were loaded: the digests of their code, read as they were
_codes: dict[tuple[str, str], str] = {}


def _ready(order: Order) -> Solver:
    """A solver that has its imports, templates and caches behind it."""
    key = order.solver, order.profile
    if key not in _solvers:
        _tell(order.number, Phase.PREPARING)
        solver = load(*key)
        _codes[key] = code(*key)
        _versions(order.solver)  # which may have to load the libraries
        if order.warm_up:
            _tell(order.number, Phase.WARMING_UP)
            ask(solver, Question(_WARM_UP, solver.branches[0]), order.limit)
        _solvers[key] = solver
    return _solvers[key]


def _code(order: Order) -> str:
    return _codes.get((order.solver, order.profile), "")


@lru_cache(maxsize=256)
def _versions(spec: str) -> str:
    return json.dumps(solver_versions(load(spec)))
