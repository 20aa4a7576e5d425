"""The code in a worker process: put questions to solvers, and send their replies back."""

from __future__ import annotations

import json
import math
import os
import signal
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
from dubins_study.experiments.isolation.process_state import ProcessState, seed
from dubins_study.experiments.isolation.sandbox import bound_memory, pin_threads
from dubins_study.experiments.isolation.worker_status import Phase, WorkerStatus
from dubins_study.experiments.provenance import now, versions
from dubins_study.solvers.library_versions import reported_versions
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import load
from dubins_study.solvers.reply import ask, exception_text, no_answer
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Outcome

# Job number that requests a calibration probe instead of a solve.
PROBE = 0
# Size of the calibration probe: loops of plain Python, operations on small arrays, repeats.
_LOOPS, _ARRAYS, _REPEATS = 9000, 300, 3
# Easy question that every solver is asked once before its first recorded answer.
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")


class _Job(NamedTuple):
    """One question as the pool sends it; `warm_up` says whether a new solver is warmed up."""

    number: int
    solver: str
    profile: str
    question: list[Any]
    time_limit: float
    warm_up: bool


class _LoadedSolver(NamedTuple):
    solver: Solver
    versions: str
    code_digest: str


def serve(channel: Channel, memory_limit: int, status_memory: int) -> None:
    """Answer jobs until the channel is closed."""
    status = WorkerStatus(status_memory)
    bound_memory(memory_limit)
    pin_threads()
    worker = _Worker(status, memory_limit)
    while True:
        message, changed = channel.receive(), False
        if message[0] == PROBE:
            answer: Any = probe()
        elif message[0] < status.withdrawn:
            continue
        else:
            answer = worker.answer(_Job(*message))
            changed = worker.state.changed()
        channel.put([message[0], answer, changed])
        channel.line.setblocking(True)  # a solver may have made the socket non-blocking
        channel.flush()
        while changed:  # this process answers no further job; the pool will replace it
            signal.pause()


class _Worker:
    """The loaded solvers, and the state of the process that they share."""

    def __init__(self, status: WorkerStatus, memory_limit: float):
        self._status, self._pid = status, os.getpid()
        self._solvers: dict[tuple[str, str], _LoadedSolver] = {}
        # Code digests of all solvers that were loaded, even if their warm-up failed.
        self._digests: dict[tuple[str, str], str] = {}
        self.state = ProcessState(memory_limit)
        status.write(0, Phase.IDLE)

    def answer(self, job: _Job) -> list[Any]:
        """The encoded reply to one job; an exception of the solver becomes a reply too."""
        started, key = now(), (job.solver, job.profile)
        try:
            question = decode_question(job.question)
            loaded = self._solvers.get(key) or self._load(job)
            seed()
            started = now()
            self._status.write(job.number, Phase.SOLVING)
            reply = ask(loaded.solver, question, job.time_limit)
            self._exit_if_forked()
            return encode_reply(WorkerReply(reply, started, loaded.versions, loaded.code_digest))
        except BaseException as error:  # a plug-in may raise anything, anywhere: recorded as a row
            self._exit_if_forked()
            outcome = Outcome.OUT_OF_MEMORY if isinstance(error, MemoryError) else Outcome.RAISED
            digest = self._digests.get(key, "")
            return encode_reply(
                WorkerReply(no_answer(outcome, exception_text(error)), started, "", digest)
            )
        finally:
            self._status.write(job.number, Phase.IDLE)

    def _load(self, job: _Job) -> _LoadedSolver:
        """Load a solver and warm it up, so that its imports, templates and caches are ready."""
        key = job.solver, job.profile
        self._status.write(job.number, Phase.LOADING)
        solver = load(*key)
        digest = self._digests[key] = code_digest(*key)
        row_versions = json.dumps(versions(tuple(solver.packages)) | reported_versions(solver))
        if job.warm_up:
            self._status.write(job.number, Phase.WARMING_UP)
            seed()
            ask(solver, Question(_WARM_UP, solver.branches[0]), job.time_limit)
            self._exit_if_forked()
        loaded = self._solvers[key] = _LoadedSolver(solver, row_versions, digest)
        self.state.accept()
        return loaded

    def _exit_if_forked(self) -> None:
        """Exit if this is a child that a solver has forked: only the worker itself may answer."""
        if os.getpid() != self._pid:
            os._exit(1)


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
