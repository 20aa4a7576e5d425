"""Put questions to one solver and note what it does to its process; runs inside the worker."""

from __future__ import annotations

import ctypes
import os
import random
import sys
import traceback
from contextlib import suppress
from dataclasses import is_dataclass
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
import psutil

from dubins_study.experiments.code_digest import plain_settings
from dubins_study.experiments.isolation.messages import (
    Channel,
    WorkerReply,
    decode_question,
    encode_reply,
)
from dubins_study.experiments.isolation.process_state import ProcessState, seed
from dubins_study.experiments.isolation.sandbox import bound_memory, pin_threads
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import SolverError, load, settings, stated_method, unavailable
from dubins_study.solvers.reply import Reply, ask, exception_text

_PACKAGE = str(FilePath(__file__).parents[1])
_MAX_TRACEBACK_CHARS = 4000


class Observation(NamedTuple):
    """A solver's reply to a question, and what else was seen.

    Args:
        reply: its reply, not judged.
        traceback: of the exception that it raised, its own frames; empty if it raised none.
        changes: names of the process's state that the solve changed.
        output: the last of what was printed meanwhile.
    """

    reply: Reply
    traceback: str = ""
    changes: tuple[str, ...] = ()
    output: str = ""


class Observer:
    """A loaded solver, asked in this process.

    Args:
        spec, profile: of the solver.
        memory_bytes: what a solve may leave allocated is a share of this.

    Raises:
        SolverError: as `solvers.registry.load`.
    """

    def __init__(self, spec: str, profile: str, memory_bytes: float):
        self.solver = load(spec, profile)
        self._state = ProcessState(memory_bytes)
        self._raised: BaseException | None = None
        self._children = _children()

    def ask(self, question: Question, limit: float) -> Observation:
        """The reply to a question, the exception's traceback, and the state that changed."""
        seed()
        self._raised = None
        generators = _generators()
        reply = ask(self.solver, question, limit, self._note)
        changes = self._state.changes()
        if _generators() != generators:
            changes.append(RANDOM)
        if _children() > self._children:
            changes.append("child processes")
        self._state.accept()
        self._children = _children()
        text = "" if self._raised is None else own_frames(self._raised, type(self.solver))
        return Observation(reply, text, tuple(changes))

    def _note(self, error: BaseException) -> None:
        self._raised = error


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
    lines = traceback.format_list(kept)
    if kept and outside[-1] is not kept[-1]:
        last = outside[-1]
        lines.append(f'  raised in "{last.filename}", line {last.lineno}, in {last.name}\n')
    return ("".join(lines) + exception_text(error))[-_MAX_TRACEBACK_CHARS:]


def _within(file: str, folder: str) -> bool:
    """Whether a file lies in a folder, and not in an environment inside it."""
    return file.startswith(folder) and "site-packages" not in file.removeprefix(folder)


def declaration(solver: Solver, spec: str) -> dict[str, Any]:
    """What a solver says of itself, as plain values; a plug-in's own code answers."""
    kind = type(solver)
    return {
        "name": str(kind.name),
        "guarantee": str(kind.guarantee),
        "branches": list(kind.branches),
        "warm": bool(kind.warm),
        "packages": list(kind.packages),
        "summary": str(kind.summary),
        "method": list(stated_method(solver)),
        "keeps_limit": bool(solver.keeps_limit),
        "whole_frames": kind.solve_frame is not None,
        "settings": plain_settings(solver),
        "frozen": not is_dataclass(kind) or kind.__dataclass_params__.frozen,
        "setting_problems": setting_problems(solver, spec),
        "unavailable": unavailable(solver),
    }


def serve(channel: Channel, spec: str, profile: str, folder: str, memory_bytes: int) -> None:
    """Load a solver, describe it, and answer questions until the channel is closed.

    The first message is ["loaded", declaration], ["refused", message] or
    ["broken", message, traceback]; each later one ["answer", reply, traceback, changes].
    """
    bound_memory(memory_bytes)
    pin_threads()
    os.chdir(folder)
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
        values, limit = channel.receive()
        seen = observer.ask(decode_question(values), limit)
        if os.getpid() != process:  # a child that the solver forked must not answer
            os._exit(1)
        with suppress(Exception):
            ctypes.CDLL(None).fflush(None)  # what C printed belongs to this question
        reply = encode_reply(WorkerReply(seen.reply))
        _send(channel, ["answer", reply, seen.traceback, list(seen.changes)])


def _send(channel: Channel, message: list[Any]) -> None:
    channel.put(message)
    channel.line.setblocking(True)  # a solver may have made the socket non-blocking
    channel.flush()


def setting_problems(solver: Solver, spec: str) -> list[str]:
    """Settings that a spec cannot set to the value that they have."""
    name = spec.partition("[")[0]
    problems = []
    for key, value in settings(solver).items():
        try:
            again = settings(load(f"{name}[{key}={value}]"))[key]
        except Exception as error:
            problems.append(f"{key}={value}: {exception_text(error)}")
        else:
            if again != value or type(again) is not type(value):
                problems.append(f"{key}={value!r} comes back as {again!r}")
    return problems
