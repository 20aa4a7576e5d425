"""A solver, asked in this process: its replies, what it says of itself, and what it changes."""

from __future__ import annotations

import ctypes
import os
import random
import sys
import tempfile
import traceback
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from inspect import get_annotations
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
import psutil

from dubins_study.experiments.isolation.messages import (
    Channel,
    WorkerReply,
    decode_question,
    encode_reply,
)
from dubins_study.experiments.isolation.process_state import ProcessState, seed
from dubins_study.experiments.isolation.sandbox import bound_memory, pin_threads
from dubins_study.experiments.isolation.worker import answer_tasks
from dubins_study.solvers.profiles import PROFILES
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.registry import SolverError, load, settings, stated_method, unavailable
from dubins_study.solvers.reply import Reply, ask, exception_text, no_answer
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose
from dubins_study.study.words import Claim, Outcome

MEMORY_BYTES = 4 * 2**30
TEMPORARY = "temporary"  # folder for temporary files, in the folder of the worker
# name of the state of `random` and of `numpy.random`, which a run seeds before every solve
RANDOM = "global random generators"
# state that no import changes: what has changed while modules were imported is the solver's doing
_NO_IMPORTS = {
    *("working directory", "umask", "numpy's error handling", "decimal context", "timers"),
    *("standard streams", "recursion limit", "garbage collector", "trace functions"),
}
_PACKAGE = str(FilePath(__file__).parents[1])
_MAX_TRACEBACK_CHARS = 4000


class Observation(NamedTuple):
    """A solver's reply to a question, not judged, and what else was seen.

    `traceback` has the solver's own frames of the exception that it raised; `changes` names the
    state of the process that the solve changed; `loaded` says whether modules were imported, which
    may change the state for good; `output` is the last of what was printed.
    """

    reply: Reply
    traceback: str = ""
    changes: tuple[str, ...] = ()
    loaded: bool = False
    output: str = ""


class Observer:
    """A loaded solver. `interruptible`: whether a KeyboardInterrupt is the caller's."""

    def __init__(self, spec: str, profile: str, *, interruptible: bool):
        self._spec, self._profile = spec, profile
        self.solver = load(spec, profile)
        Path(Pose(0, 0, 0), [0.0], [1.0])  # what our first path imports is not the solver's doing
        self._state = ProcessState(MEMORY_BYTES)
        self._children = _children()
        self._interruptible = interruptible

    def ask(self, question: Question, limit: float) -> Observation:
        """The reply to a question, the exception's traceback, and the state that changed."""
        seed()
        raised: list[BaseException] = []
        generators, modules = _generators(), len(sys.modules)
        try:
            reply = ask(self.solver, question, limit, raised.append)
        except KeyboardInterrupt as error:  # Ctrl-C does not reach a worker
            if self._interruptible:
                raise
            raised.append(error)
            reply = no_answer(Outcome.RAISED, exception_text(error))
        loaded = len(sys.modules) != modules
        changes = [name for name in self._state.changes() if not loaded or name in _NO_IMPORTS]
        if _generators() != generators:
            changes.append(RANDOM)
        if _children() > self._children:
            changes.append("child processes")
        self._state.accept()
        self._children = _children()
        text = own_frames(raised[-1], type(self.solver)) if raised else ""
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


def _row_reply(question: Question, row: Any) -> Reply:
    """The reply that a row of a solved frame stands for; its path has at most two arcs."""
    path = None
    if row["curvatures"] is not None:
        path = Path(question.scenario.start, row["curvatures"], row["lengths"])
    bound = float(row["lower_bound"]) if row["lower_bound"] == row["lower_bound"] else None
    message = str(row["message"] or "")
    solution = Solution(Claim(row["claim"]), path, lower_bound=bound, message=message)
    return Reply(Outcome(row["outcome"]), solution, Times())


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
    near = [
        frame
        for frame in outside
        if folder
        and frame.filename.startswith(folder)
        # an environment may lie inside the solver's folder
        and "site-packages" not in frame.filename.removeprefix(folder)
    ]
    kept = near or outside
    entries = "".join(traceback.format_list(kept)).splitlines(keepends=True)
    lines = [line for line in entries if line.strip(" ^~\n")]  # no marks below parts of the source
    if kept and outside[-1] is not kept[-1]:
        last = outside[-1]
        lines.append(f'  raised in "{last.filename}", line {last.lineno}, in {last.name}\n')
    return ("".join(lines) + exception_text(error))[-_MAX_TRACEBACK_CHARS:]


def declaration(solver: Solver, spec: str) -> dict[str, Any]:
    """What a solver says of itself, as plain values; a plug-in's own code answers."""
    kind = type(solver)
    raised = False
    try:
        solver.unavailable()
    except Exception:
        raised = True
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
        "no_settings": _no_settings(kind),
        "frozen": not is_dataclass(kind) or kind.__dataclass_params__.frozen,
        "setting_problems": _setting_problems(solver, spec),
        "unavailable": unavailable(solver),
        "reason_raised": raised,
    }


def _no_settings(kind: type[Solver]) -> list[str] | None:
    """What looks like settings and is none for want of a dataclass; None if nothing is missing."""
    own = kind.__mro__[: kind.__mro__.index(Solver)]
    declared = {name: str(type_) for one in own for name, type_ in get_annotations(one).items()}
    fields = getattr(kind, "__dataclass_fields__", {})
    names = [
        name
        for name, type_ in declared.items()
        if name not in fields and not hasattr(Solver, name) and "ClassVar" not in type_
    ]
    return names if names or not is_dataclass(kind) else None


_DEFAULT = "give each setting a default of type int, float, bool or str"
_TEXT = "a spec has no room for a comma, a bracket or spaces at the ends; use a word as the default"


def _setting_problems(solver: Solver, spec: str) -> list[tuple[str, str]]:
    """Settings that a spec cannot set to the value that they have, each with what to do."""
    name = spec.partition("[")[0]
    problems = []
    for profile in PROFILES:
        try:
            load(spec, profile)
        except SolverError as error:
            advice = "a profile is a dict of settings that the class accepts"
            problems.append((f"the profile {profile}: {error}", advice))
    for key, value in settings(solver).items():
        if value == "":  # nothing that a spec could write
            continue
        kind = type(value).__name__
        if kind not in ("int", "float", "bool", "str"):
            problems.append((f"{key}: its default {value!r:.40} is a {kind}", _DEFAULT))
            continue
        advice = _TEXT if isinstance(value, str) else "the class must accept its own default"
        try:
            again = settings(load(f"{name}[{key}={value}]"))[key]
        except Exception as error:
            problems.append((f"{key}={value}: {exception_text(error)}", advice))
        else:
            if again != value or type(again) is not type(value):
                problems.append((f"{key}={value!r}: it comes back as {again!r}", advice))
    return problems


def serve(channel: Channel, spec: str, profile: str, folder: str) -> None:
    """Answer the tasks of an `interview.Worker`, in a process of its own.

    The first task is ["load"]; its answer is ["loaded", declaration], ["refused", message] or
    ["broken", message, traceback]. Any other task is ["ask", questions, limit, whether as one
    frame]; its answer has an observation for each question.
    """
    bound_memory(MEMORY_BYTES)
    pin_threads()
    os.chdir(folder)
    os.environ["TMPDIR"] = tempfile.tempdir = f"{folder}/{TEMPORARY}"
    loaded: list[Observer] = []

    def load_solver() -> list[Any]:
        try:
            loaded.append(Observer(spec, profile, interruptible=False))
            return ["loaded", declaration(loaded[0].solver, spec)]
        except SolverError as error:
            text = own_frames(error.__cause__) if error.__cause__ else ""
            return ["broken", str(error), text] if text else ["refused", str(error)]
        except BaseException as error:  # a plug-in's property may raise anything
            return ["broken", exception_text(error), own_frames(error)]

    def handle(task: list[Any]) -> tuple[list[Any], bool]:
        if task[0] == "load":
            return load_solver(), False
        _, encoded, limit, as_frame = task
        questions = [decode_question(values) for values in encoded]
        [observer] = loaded
        seen = observer.ask_frame(questions) if as_frame else [observer.ask(questions[0], limit)]
        with suppress(Exception):
            ctypes.CDLL(None).fflush(None)  # what C printed belongs to this question
        return [[encode_reply(WorkerReply(one.reply)), *one[1:4]] for one in seen], False

    answer_tasks(channel, handle)
