"""The code in a worker process.

The process puts questions to solvers, and sends the replies to its pool.
"""

from __future__ import annotations

import json
import math
import os
import signal
import timeit
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from dubins_study.asking.reply import Reply, ask, raised_answer
from dubins_study.experiments.code_digest import code_digest
from dubins_study.experiments.isolation.messages import Channel, decode_question, encode_reply
from dubins_study.experiments.isolation.process_state import (
    ProcessState,
    bound_process,
    peak_kib,
    seed,
)
from dubins_study.experiments.provenance import now, versions
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import load, ours, reported_versions, unavailable
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import VIA_POINTS

# Size of the calibration probe, half of it plain Python and half numpy on small arrays: loops,
# operations on arrays, repeats.
_LOOPS = 9000
_ARRAYS = 300
_REPEATS = 3
_KIB_PER_MIB = 2**10
# Easy question that every solver is asked once before its first recorded answer.
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")
_WARM_UP_ROUTE = replace(_WARM_UP, via=((-6.0, 1.0),))  # loops of routes take a second to load
_WARM_UP_ROUTE_S = 2.0  # a proof of two legs may take longer


def answer_tasks(channel: Channel, handle: Callable[[list[Any]], tuple[Any, bool]]) -> None:
    """Answer tasks until the channel is closed.

    `handle` takes a task and returns the answer, which JSON can hold, and whether the process must
    be replaced. Both are sent as one message. The first message, `[None, False]`, says that the
    process is ready. If no task is waiting, the arrival of the next one is confirmed by "begun".
    """
    process = os.getpid()
    value = None
    changed = False
    while True:
        channel.put([value, changed])
        channel.flush()
        while changed:  # this process answers no further task; its owner will replace it
            signal.pause()
        task = channel.next_received()
        if task is None:
            task = channel.receive()
            channel.put("begun")
            channel.flush()
        value, changed = handle(task)
        if os.getpid() != process:  # a child that a solver has forked must not answer
            os._exit(1)


def serve(channel: Channel, memory_limit: int) -> None:
    """Answer the tasks of a pool (`pool.WorkerPool`)."""
    bound_process(memory_limit)
    answer_tasks(channel, _Worker(memory_limit).handle)


class _LoadedSolver(NamedTuple):
    solver: Solver
    versions: str
    code_digest: str
    floor_s: float | None = None


class _Worker:
    """The loaded solvers and their process's state."""

    def __init__(self, memory_limit: float):
        self._solvers: dict[tuple[str, str], _LoadedSolver] = {}
        # Solver that cannot be loaded or warmed up -> the reply to all questions.
        self._refused: dict[tuple[str, str], Reply] = {}
        self._state = ProcessState(memory_limit)

    def handle(self, task: list[Any]) -> tuple[Any, bool]:
        """Answer to a task, and whether the process changed.

        Only changes by a plug-in count. A task is one of ["probe"], ["load", spec, profile],
        ["warm up", spec, profile, route, limit, floors] and
        ["solve", spec, profile, question, limit].
        """
        kind, *arguments = task
        if kind == "probe":
            return probe(), False
        if kind == "solve":
            return self._solve(*arguments)
        self._prepare(*arguments)
        return None, False

    def _prepare(self, spec: str, profile: str, *warm_up: Any) -> None:
        """Load a solver, or warm up a loaded one.

        `warm_up` is empty, or has the further arguments of `_warmed_up`. If this fails, the failure
        is the reply to all questions to the solver.
        """
        key = spec, profile
        if key not in self._refused:
            try:
                if warm_up:
                    self._solvers[key] = _warmed_up(self._solvers[key], *warm_up)
                else:
                    self._solvers[key] = _load(*key)
            except BaseException as error:  # a plug-in may raise anything
                self._refused[key] = _failure(error, *key)
        self._state.accept()

    def _solve(
        self, spec: str, profile: str, question: list[Any], time_limit: float
    ) -> tuple[list[Any], bool]:
        """Encoded reply, and whether the process changed.

        Only changes by a plug-in count.
        """
        key = spec, profile
        reply = self._refused.get(key)
        if reply is None:
            try:
                reply = _reply(self._solvers[key], question, time_limit)
            except BaseException as error:  # a plug-in may raise anything, anywhere
                reply = _failure(error, *key)
        changed = not ours(spec) and bool(self._state.changes())
        return encode_reply(reply), changed


def _failure(error: BaseException, spec: str, profile: str) -> Reply:
    """The reply of a solver that raised outside `ask`."""
    return raised_answer(error)._replace(started=now(), code_digest=_digest(spec, profile))


def _digest(spec: str, profile: str) -> str:
    """The digest of a solver's code.

    Empty if the solver's code cannot be loaded or read.
    """
    try:
        return code_digest(spec, profile)
    except BaseException:  # of a plug-in
        return ""


def _load(spec: str, profile: str) -> _LoadedSolver:
    solver = load(spec, profile)
    packages = versions(tuple(solver.packages)) | reported_versions(solver)
    return _LoadedSolver(solver, json.dumps(packages), code_digest(spec, profile))


def _warmed_up(loaded: _LoadedSolver, route: bool, limit: float, floors: bool) -> _LoadedSolver:
    """Ask an easy question, and return the solver.

    After that, imports and caches are ready. With `route` the question has a via point. With
    `floors` the returned solver has a floor, measured in the warm-up on a leg. `limit` is in s.
    """
    seed()
    solver = loaded.solver
    branch = solver.branches[0]
    if not route:
        ask(solver, Question(_WARM_UP, branch), limit)
    elif VIA_POINTS in solver.takes:
        ask(solver, Question(_WARM_UP_ROUTE, branch), min(limit, _WARM_UP_ROUTE_S))
    if route or not floors or unavailable(solver) is not None:
        return loaded
    from dubins_study.experiments.isolation.floor import floor_s

    return loaded._replace(floor_s=floor_s(solver))


def _reply(loaded: _LoadedSolver, encoded: list[Any], time_limit: float) -> Reply:
    """The reply to an encoded question.

    Start time, versions, code digest, memory and floor are filled in for its row.
    """
    question = decode_question(encoded)
    seed()
    before = peak_kib(reset=True)
    started = now()
    reply = ask(loaded.solver, question, time_limit)
    memory_mib = None  # where the peak cannot be read
    if before and (peak := peak_kib()):
        memory_mib = (peak - before) / _KIB_PER_MIB
    return reply._replace(
        started=started,
        versions=loaded.versions,
        code_digest=loaded.code_digest,
        memory_mib=memory_mib,
        floor_s=loaded.floor_s,
    )


def probe() -> float:
    """Seconds that a millisecond of work takes here.

    The shortest of three repeats counts.
    """
    return min(timeit.repeat(_probe_work, number=1, repeat=_REPEATS))


def _probe_work() -> None:
    matrix = np.linspace(0.0, 1.0, 36 * 36).reshape(36, 36)
    vector = np.linspace(-1.0, 1.0, 36)
    total = 0.0
    for i in range(_LOOPS):
        total += math.sin(i) * 0.5
    for _ in range(_ARRAYS):
        vector = matrix @ vector
        vector /= float(np.abs(vector).max()) or 1.0
