"""The code in a worker process: put questions to solvers, and send their replies back."""

from __future__ import annotations

import json
import math
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.experiments.code_digest import code_digest
from dubins_study.experiments.isolation.messages import (
    Channel,
    WorkerReply,
    decode_question,
    encode_reply,
)
from dubins_study.experiments.isolation.process_state import (
    ProcessState,
    bound_process,
    peak_bytes,
    reset_peak,
    seed,
)
from dubins_study.experiments.provenance import now, versions
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import load, reported_versions, unavailable
from dubins_study.solvers.reply import ask, exception_text, no_answer
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import VIA_POINTS, Outcome

# Size of the calibration probe: loops of plain Python, operations on small arrays, repeats.
_LOOPS, _ARRAYS, _REPEATS = 9000, 300, 3
_BYTES_PER_MIB = 2**20
# Easy question that every solver is asked once before its first recorded answer.
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")
_WARM_UP_ROUTE = replace(_WARM_UP, via=((-6.0, 1.0),))  # loops of routes take a second to load
_WARM_UP_ROUTE_S = 2.0  # a proof of two legs may take longer


def answer_tasks(channel: Channel, handle: Callable[[list[Any]], tuple[Any, bool]]) -> None:
    """Say that this process is ready, and answer tasks until the channel is closed.

    An answer is what `handle` returns: a value that JSON can hold, and whether the process must be
    replaced. A worker that had to wait says that it begins its next task.
    """
    process, value, changed = os.getpid(), None, False
    while True:
        channel.put([value, changed])
        channel.line.setblocking(True)  # a solver may have made the socket non-blocking
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
    """The loaded solvers, and the state of the process that they share."""

    def __init__(self, memory_limit: float):
        # The encoded reply to all questions stands for a solver that cannot be loaded.
        self._solvers: dict[tuple[str, str], _LoadedSolver | list[Any]] = {}
        self._state = ProcessState(memory_limit)

    def handle(self, task: list[Any]) -> tuple[Any, bool]:
        """The answer to a task, and whether the process was changed by it."""
        kind, *arguments = task
        if kind == "solve":
            return self._solve(*arguments), bool(self._state.changes())
        if kind == "probe":
            return probe(), False
        if kind == "load":
            self._load(*arguments)
        else:
            self._warm_up(*arguments)
        self._state.accept()
        return None, False

    def _load(self, spec: str, profile: str) -> None:
        started, digest = now(), ""
        try:
            solver = load(spec, profile)
            digest = code_digest(spec, profile)
            packages = versions(tuple(solver.packages)) | reported_versions(solver)
            self._solvers[spec, profile] = _LoadedSolver(solver, json.dumps(packages), digest)
        except BaseException as error:  # a plug-in may raise anything, anywhere: recorded as rows
            self._solvers[spec, profile] = _error_reply(error, started, digest)

    def _warm_up(self, spec: str, profile: str, limit: float, route: bool, floors: bool) -> None:
        """Ask an easy question, so that a solver's imports, templates and caches are ready.

        Of a leg, or of a route where the solver takes one. With `floors` and a leg, measure the
        floor of the solver's times as well.
        """
        loaded = self._solvers[spec, profile]
        if isinstance(loaded, list):
            return
        started = now()
        try:
            seed()
            branch = loaded.solver.branches[0]
            if route:
                if VIA_POINTS in loaded.solver.takes:
                    short = min(limit, _WARM_UP_ROUTE_S)
                    ask(loaded.solver, Question(_WARM_UP_ROUTE, branch), short)
                return
            ask(loaded.solver, Question(_WARM_UP, branch), limit)
            if floors and unavailable(loaded.solver) is None:
                from dubins_study.experiments.isolation.floor import floor_s

                floor = floor_s(loaded.solver)
                self._solvers[spec, profile] = loaded._replace(floor_s=floor)
        except BaseException as error:
            self._solvers[spec, profile] = _error_reply(error, started, loaded.code_digest)

    def _solve(self, spec: str, profile: str, question: list[Any], time_limit: float) -> list[Any]:
        """The encoded reply to a question."""
        loaded = self._solvers[spec, profile]
        if isinstance(loaded, list):
            return loaded
        started = now()
        try:
            decoded = decode_question(question)
            seed()
            before = reset_peak()
            started = now()
            reply = ask(loaded.solver, decoded, time_limit)
            peak = None if before is None else peak_bytes()
            memory = None if before is None or peak is None else (peak - before) / _BYTES_PER_MIB
            texts = started, loaded.versions, loaded.code_digest
            return encode_reply(WorkerReply(reply, *texts, memory, loaded.floor_s))
        except BaseException as error:
            return _error_reply(error, started, loaded.code_digest)


def _error_reply(error: BaseException, started: str, digest: str) -> list[Any]:
    outcome = Outcome.OUT_OF_MEMORY if isinstance(error, MemoryError) else Outcome.RAISED
    return encode_reply(WorkerReply(no_answer(outcome, exception_text(error)), started, "", digest))


def probe() -> float:
    """Duration (s) of a fixed piece of work in this process, the shortest of three repeats.

    One repeat takes about a millisecond: half for plain Python, half for numpy on arrays of a few
    dozen numbers, as in the solvers.
    """
    return min(_probe_duration() for _ in range(_REPEATS))


def _probe_duration() -> float:
    matrix = np.linspace(0.0, 1.0, 36 * 36).reshape(36, 36)
    vector = np.linspace(-1.0, 1.0, 36)
    began = perf_counter()
    total = 0.0
    for i in range(_LOOPS):
        total += math.sin(i) * 0.5
    for _ in range(_ARRAYS):
        vector = matrix @ vector
        vector /= float(np.abs(vector).max()) or 1.0
    return perf_counter() - began
