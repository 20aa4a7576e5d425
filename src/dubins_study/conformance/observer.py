"""Put questions to one solver and note what it does to its process; runs inside the worker."""

from __future__ import annotations

import ctypes
import os
import random
import sys
import tempfile
import traceback
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
import psutil

from dubins_study.conformance.loading import declaration
from dubins_study.experiments.isolation.messages import (
    Channel,
    WorkerReply,
    decode_question,
    encode_reply,
)
from dubins_study.experiments.isolation.process_state import ProcessState, seed
from dubins_study.experiments.isolation.sandbox import bound_memory, pin_threads
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.registry import SolverError, load
from dubins_study.solvers.reply import Reply, ask, exception_text, no_answer
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose
from dubins_study.study.words import Claim, Outcome

_PACKAGE = str(FilePath(__file__).parents[1])
_MAX_TRACEBACK_CHARS = 4000


class Observation(NamedTuple):
    """A solver's reply to a question, and what else was seen.

    Args:
        reply: its reply, not judged.
        traceback: of the exception that it raised, its own frames; empty if it raised none.
        changes: names of the process's state that the solve changed.
        loaded: whether modules were imported meanwhile, which may change the state for good.
        output: the last of what was printed meanwhile.
    """

    reply: Reply
    traceback: str = ""
    changes: tuple[str, ...] = ()
    loaded: bool = False
    output: str = ""


class Observer:
    """A loaded solver, asked in this process.

    Args:
        spec, profile: of the solver.
        memory_bytes: what a solve may leave allocated is a share of this.
        interruptible: whether a KeyboardInterrupt is the caller's, and not the solver's.

    Raises:
        SolverError: as `solvers.registry.load`.
    """

    def __init__(
        self, spec: str, profile: str, memory_bytes: float, *, interruptible: bool = False
    ):
        self._spec, self._profile = spec, profile
        self.solver = load(spec, profile)
        Path(Pose(0, 0, 0), [0.0], [1.0])  # what our first path imports is not the solver's doing
        self._state = ProcessState(memory_bytes)
        self._raised: BaseException | None = None
        self._children = _children()
        self._interruptible = interruptible

    def ask(self, question: Question, limit: float) -> Observation:
        """The reply to a question, the exception's traceback, and the state that changed."""
        seed()
        self._raised = None
        generators, modules = _generators(), len(sys.modules)
        try:
            reply = ask(self.solver, question, limit, self._note)
        except KeyboardInterrupt as error:  # Ctrl-C does not reach a worker
            if self._interruptible:
                raise
            self._raised = error
            reply = no_answer(Outcome.RAISED, exception_text(error))
        loaded = len(sys.modules) != modules
        changes = [name for name in self._state.changes() if not loaded or name in _NO_IMPORTS]
        if _generators() != generators:
            changes.append(RANDOM)
        if _children() > self._children:
            changes.append("child processes")
        self._state.accept()
        self._children = _children()
        text = "" if self._raised is None else own_frames(self._raised, type(self.solver))
        return Observation(reply, text, tuple(changes), loaded)

    def ask_frame(self, questions: list[Question]) -> list[Observation]:
        """The replies to questions of one branch that are put to the solver as one frame."""
        import pandas as pd

        from dubins_study.solvers.frame import solve_frame

        frame = pd.DataFrame([asdict(question.scenario) for question in questions])
        rows = solve_frame(frame, self._spec, questions[0].branch, profile=self._profile)
        return [
            Observation(_row_reply(question, row))
            for question, (_, row) in zip(questions, rows.iterrows(), strict=True)
        ]

    def _note(self, error: BaseException) -> None:
        self._raised = error


def _row_reply(question: Question, row: Any) -> Reply:
    """The reply that a row of a solved frame stands for; its path has at most two arcs."""
    path = None
    if row["curvatures"] is not None:
        path = Path(question.scenario.start, row["curvatures"], row["lengths"])
    message = str(row["message"] or "")
    bound = float(row["lower_bound"]) if row["lower_bound"] == row["lower_bound"] else None
    solution = Solution(Claim(row["claim"]), path, None, bound, message=message)
    return Reply(Outcome(row["outcome"]), solution, Times())


# folder for temporary files, in the folder of the worker
TEMPORARY = "temporary"
# state that no import changes: what has changed while modules were imported is the solver's doing
_NO_IMPORTS = {
    *("working directory", "umask", "numpy's error handling", "decimal context", "timers"),
    *("standard streams", "recursion limit", "garbage collector", "trace functions"),
}
# name of the state of `random` and of `numpy.random`, which a run seeds before every solve
RANDOM = "global random generators"


def _generators() -> tuple[Any, ...]:
    name, keys, place, *rest = np.random.get_state()  # noqa: NPY002
    return random.getstate(), name, bytes(np.asarray(keys)), place, rest


def _children() -> int:
    with suppress(psutil.Error):
        return len(psutil.Process().children(recursive=True))
    return 0


def own_frames(error: BaseException, kind: type[Any] | None = None) -> str:
    """The traceback of a solver's exception without the frames of this package around it.

    Frames of the libraries that the solver calls are left out but for the innermost one.
    """
    source = getattr(sys.modules.get(kind.__module__ if kind else ""), "__file__", None) or ""
    ours = source.startswith(_PACKAGE)
    folder = str(FilePath(source).resolve().parent) if source else ""
    outside = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if not frame.filename.startswith("<frozen")
        and ((ours and "reply.py" not in frame.filename) or not frame.filename.startswith(_PACKAGE))
    ]
    near = [frame for frame in outside if folder and _within(frame.filename, folder)]
    kept = near or outside
    lines = [_without_marks(entry) for entry in traceback.format_list(kept)]
    if kept and outside[-1] is not kept[-1]:
        last = outside[-1]
        lines.append(f'  raised in "{last.filename}", line {last.lineno}, in {last.name}\n')
    return ("".join(lines) + exception_text(error))[-_MAX_TRACEBACK_CHARS:]


def _without_marks(entry: str) -> str:
    """A frame's lines without the one that underlines a part of the source."""
    return "".join(line for line in entry.splitlines(True) if line.strip(" ^~\n"))


def _within(file: str, folder: str) -> bool:
    """Whether a file lies in a folder, and not in an environment inside it."""
    return file.startswith(folder) and "site-packages" not in file.removeprefix(folder)


def serve(channel: Channel, spec: str, profile: str, folder: str, memory_bytes: int) -> None:
    """Load a solver, describe it, and answer requests until the channel is closed.

    The first message is ["loaded", declaration], ["refused", message] or
    ["broken", message, traceback]. A request is [questions, limit, whether as one frame], its
    answer one observation for each question.
    """
    bound_memory(memory_bytes)
    pin_threads()
    os.chdir(folder)
    os.environ["TMPDIR"] = tempfile.tempdir = f"{folder}/{TEMPORARY}"
    try:
        observer = Observer(spec, profile, memory_bytes)
        first = ["loaded", declaration(observer.solver, spec)]
    except SolverError as error:
        cause = error.__cause__
        text = "" if cause is None else own_frames(cause)
        first = ["broken", str(error), text] if text else ["refused", str(error)]
    except BaseException as error:  # a plug-in's property may raise anything
        first = ["broken", exception_text(error), own_frames(error)]
    _send(channel, first)
    process = os.getpid()
    while True:
        encoded, limit, as_frame = channel.receive()
        questions = [decode_question(values) for values in encoded]
        seen = observer.ask_frame(questions) if as_frame else [observer.ask(questions[0], limit)]
        if os.getpid() != process:  # a child that the solver forked must not answer
            os._exit(1)
        with suppress(Exception):
            ctypes.CDLL(None).fflush(None)  # what C printed belongs to this question
        _send(channel, ["answers", [_encoded(one) for one in seen]])


def _encoded(seen: Observation) -> list[Any]:
    return [encode_reply(WorkerReply(seen.reply)), seen.traceback, seen.changes, seen.loaded]


def _send(channel: Channel, message: list[Any]) -> None:
    channel.put(message)
    channel.line.setblocking(True)  # a solver may have made the socket non-blocking
    channel.flush()
