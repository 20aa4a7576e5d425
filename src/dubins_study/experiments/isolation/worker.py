"""What a worker process does: put questions to solvers, and send back what they reply."""

from __future__ import annotations

import json
import math
import os
import signal
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.experiments.code_digest import code_digest
from dubins_study.experiments.isolation.job_clock import JobClock, Phase
from dubins_study.experiments.isolation.messages import (
    Channel,
    WorkerReply,
    decode_question,
    encode_reply,
)
from dubins_study.experiments.isolation.sandbox import bound_memory, pin_threads
from dubins_study.experiments.isolation.worker_state import WorkerState, seed
from dubins_study.experiments.provenance import now, versions
from dubins_study.solvers.library_versions import reported_versions
from dubins_study.solvers.protocol import Outcome, Question, Solver
from dubins_study.solvers.registry import load
from dubins_study.solvers.reply import ask, exception_text, no_answer
from dubins_study.study.scenario import Scenario

# stands for a job's number where the calibration's piece of work is to be timed
PROBE = 0
# the calibration's piece of work: about a millisecond, half of it numpy on small arrays
_LOOPS, _ARRAYS, _REPEATS = 9000, 300, 3
# an easy question, asked once of every solver before its first recorded answer
_WARM_UP = Scenario(x=0, y=0, heading=0.3, target_x=3, target_y=2, radius=1, label="warm-up")


class _Job(NamedTuple):
    """One question as the pool sends it; `warm_up` is for a solver that is new here."""

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


def serve(channel: Channel, memory_limit: int, clock: int) -> None:
    """Answer jobs until the channel is closed."""
    shared = JobClock(clock)
    bound_memory(memory_limit)
    pin_threads()
    worker = _Worker(shared, memory_limit)
    while True:
        message, changed = channel.receive(), False
        if message[0] == PROBE:
            answer: Any = probe()
        elif message[0] < shared.withdrawn:
            continue
        else:
            answer = worker.answer(_Job(*message))
            changed = worker.state.changed()
        channel.put([message[0], answer, changed])
        channel.line.setblocking(True)  # a solver may have set it not to block
        channel.flush()
        while changed:  # this process answers no more, and waits to be replaced
            signal.pause()


class _Worker:
    """Solvers that are loaded here, and the state of the process that they share."""

    def __init__(self, clock: JobClock, memory_limit: float):
        self._clock, self._pid = clock, os.getpid()
        self._solvers: dict[tuple[str, str], _LoadedSolver] = {}
        # of the code of solvers that were loaded, even if their warm-up failed
        self._digests: dict[tuple[str, str], str] = {}
        self.state = WorkerState(memory_limit)
        clock.write(0, Phase.IDLE)

    def answer(self, job: _Job) -> list[Any]:
        """The encoded reply to one job: whatever happens, short of the process's end."""
        started, key = now(), (job.solver, job.profile)
        try:
            question = decode_question(job.question)
            loaded = self._solvers.get(key) or self._load(job)
            seed()
            started = now()
            self._clock.write(job.number, Phase.SOLVING)
            reply = ask(loaded.solver, question, job.time_limit)
            self._end_copy()
            return encode_reply(WorkerReply(reply, started, loaded.versions, loaded.code_digest))
        except BaseException as error:  # a plug-in that breaks more than its own calls is a row too
            self._end_copy()
            outcome = Outcome.OUT_OF_MEMORY if isinstance(error, MemoryError) else Outcome.RAISED
            digest = self._digests.get(key, "")
            return encode_reply(
                WorkerReply(no_answer(outcome, exception_text(error)), started, "", digest)
            )
        finally:
            self._clock.write(job.number, Phase.IDLE)

    def _load(self, job: _Job) -> _LoadedSolver:
        """A solver that has its imports, templates and caches behind it."""
        key = job.solver, job.profile
        self._clock.write(job.number, Phase.LOADING)
        solver = load(*key)
        digest = self._digests[key] = code_digest(*key)
        row_versions = json.dumps(versions(tuple(solver.packages)) | reported_versions(solver))
        if job.warm_up:
            self._clock.write(job.number, Phase.WARMING_UP)
            seed()
            ask(solver, Question(_WARM_UP, solver.branches[0]), job.time_limit)
            self._end_copy()
        loaded = self._solvers[key] = _LoadedSolver(solver, row_versions, digest)
        self.state.accept()
        return loaded

    def _end_copy(self) -> None:
        """End a child that a solver forked and lost: it must not answer in its parent's place."""
        if os.getpid() != self._pid:
            os._exit(1)


def probe() -> float:
    """Seconds that the work takes in this process: the least of 3, about a millisecond each.

    Half of it is plain Python, half numpy on arrays of a few dozen numbers, as in these solvers.
    """
    return min(_timed() for _ in range(_REPEATS))


def _timed() -> float:
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
