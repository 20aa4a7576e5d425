"""A solver that is asked in this process.

Its replies, its declaration and its changes are observed.
"""

from __future__ import annotations

import ctypes
import os
import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import suppress
from itertools import dropwhile
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import psutil

from dubins_study.asking.reply import Reply, ask, exception_text, raised_answer
from dubins_study.experiments.isolation.messages import Channel, decode_question, encode_reply
from dubins_study.experiments.isolation.process_state import ProcessState, bound_process, seed
from dubins_study.experiments.isolation.worker import answer_tasks
from dubins_study.solvers.protocol import NOT_STATED, Guarantee, Question, Solver
from dubins_study.solvers.registry import (
    UNKNOWN,
    SolverError,
    load,
    settings,
    stated_method,
    unavailable,
)
from dubins_study.study.kinds.table import EVERY_BRANCH
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose
from dubins_study.study.words import FINAL_HEADING, FREE_FINAL_HEADING

MEMORY_BYTES = 4 * 2**30
TEMPORARY = "temporary"  # folder for temporary files, in the folder of the worker
# state that no import changes: what has changed while modules were imported is the solver's doing
_NO_IMPORTS = {
    "working directory",
    "numpy's error handling",
    "timers",
    "standard streams",
    "recursion limit",
    "garbage collector",
    "clock",
}
# Files of this package whose functions call a solver's code.
_PACKAGE = FilePath(__file__).parents[1]
_ASKING = {__file__, *(str(_PACKAGE / name) for name in ("asking/reply.py", "solvers/registry.py"))}
_MAX_TRACEBACK_CHARS = 4000


class Observation(NamedTuple):
    """A solver's reply, not judged, with its effects.

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
    """A loaded solver in the caller's process.

    Used under a debugger, and in the process of an `interview.Worker`.
    """

    folder = None

    def __init__(self, spec: str, profile: str):
        self._state = ProcessState(MEMORY_BYTES)
        self.solver = load(spec, profile)
        Path(Pose(0, 0, 0), [0.0], [1.0])  # what our first path imports is not the solver's doing
        self._state.accept()
        self._children = _children()
        self.declared = declaration(self.solver)

    def ask(self, question: Question, limit: float) -> Observation:
        """The reply to a question, and the solve's effects.

        The effects are the traceback of an exception, the names of changed state, and whether
        modules were imported. `limit` is in seconds.
        """
        seed()
        raised: list[BaseException] = []
        modules = len(sys.modules)
        reply = ask(self.solver, question, limit, raised.append)
        loaded = len(sys.modules) != modules
        # an import may change all state but `_NO_IMPORTS` for good, which is no fault
        changes = [name for name in self._state.changes() if not loaded or name in _NO_IMPORTS]
        if _children() > self._children:
            changes.append("child processes")
        self._state.accept()
        self._children = _children()
        frames = ""
        if raised:
            frames = own_frames(raised[-1])
        return Observation(reply, frames, tuple(changes), loaded)

    def restart(self) -> None:
        """There is only one process to ask in."""

    def close(self) -> None:
        """Nothing to end."""


def _children() -> int:
    with suppress(psutil.Error):
        return len(psutil.Process().children(recursive=True))
    return 0


def own_frames(error: BaseException) -> str:
    """The traceback of a solver's exception.

    The frames of this package that asked the solver are left out.
    """
    frames = dropwhile(
        lambda frame: frame.filename.startswith("<frozen") or frame.filename in _ASKING,
        traceback.extract_tb(error.__traceback__),
    )
    text = "".join(traceback.format_list([*frames]))
    return (text + exception_text(error))[-_MAX_TRACEBACK_CHARS:]


def declaration(solver: Solver) -> dict[str, Any]:
    """A solver's declaration, in plain values.

    Its `problems` are tuples (status, what was seen, advice).
    """
    kind = type(solver)
    return {
        "name": str(kind.name),
        "guarantee": str(kind.guarantee),
        "branches": list(kind.branches),
        "takes": sorted(kind.takes),
        "warm": bool(kind.warm),
        "method": list(stated_method(solver)),
        "keeps_limit": bool(solver.keeps_limit),
        "unavailable": unavailable(solver),
        "problems": [*_wrong_declaration(solver), *_wrong_settings(solver)],
    }


def _wrong_declaration(solver: Solver) -> Iterator[tuple[str, str, str]]:
    """Yield the problems of a declaration.

    Each is (status, what was seen, advice), such as ("fail", "branches is empty", "expected ...").
    The statuses are those of `conformance.report.Status`.
    """
    kind = type(solver)
    unknown = [name for name in kind.branches if name not in EVERY_BRANCH]
    if unknown or not kind.branches:
        observed = "branches is empty"
        if unknown:
            observed = f"branches names {unknown[0]!r}"
        yield "fail", observed, f"expected some of: {', '.join(EVERY_BRANCH)}"
    if not kind.takes & {FREE_FINAL_HEADING, FINAL_HEADING}:
        observed = f"takes is {sorted(kind.takes)}, and every scenario needs more"
        yield "fail", observed, f"add {FREE_FINAL_HEADING!r}, {FINAL_HEADING!r} or both"
    if kind.guarantee not in set(Guarantee):
        yield "fail", f"guarantee is {kind.guarantee!r}", f"expected one of: {', '.join(Guarantee)}"
    if (reason := unavailable(solver)) is not None:
        observed = f"it cannot run here: {reason}"
        if reason.startswith(UNKNOWN):
            yield "fail", observed, "unavailable() does not raise: it returns a text, or None"
        else:
            yield "note", observed, ""
    if stated_method(solver)[:2] == NOT_STATED[:2]:  # formulation and engine
        advice = 'add method = ("penalty", "my engine", "random"): formulation, engine, guess'
        yield "note", "it does not state its method", advice


def _wrong_settings(solver: Solver) -> Iterator[tuple[str, str, str]]:
    """Yield the problems of a solver's settings.

    Each is (status, what was seen, advice). A problem is a setting that a spec cannot set, or a
    class that is no frozen dataclass.
    """
    kind = type(solver)
    for key, value in settings(solver).items():
        if not isinstance(value, int | float | str):
            problem = f"{key}: its default {value!r:.40} is a {type(value).__name__}"
            advice = "give each setting a default of type int, float, bool or str"
            yield "note", f"a spec cannot set {problem}", advice
    parameters = getattr(kind, "__dataclass_params__", None)
    if parameters is None or not parameters.frozen:
        advice = "write @dataclass(frozen=True) above its class: its fields are then its settings"
        yield "note", "it is no frozen dataclass", advice


def serve(channel: Channel, spec: str, profile: str, folder: str) -> None:
    """Answer the tasks of an `interview.Worker`.

    This runs in a process of its own, in `folder`.

    The first task is ["load"]; its answer is ["loaded", declaration], ["refused", message] or
    ["broken", message, traceback]. Any other task is ["ask", question, limit]; its answer is an
    observation: [reply, traceback, changes, loaded].
    """
    bound_process(MEMORY_BYTES)
    os.chdir(folder)
    os.environ["TMPDIR"] = tempfile.tempdir = f"{folder}/{TEMPORARY}"
    loaded: list[Observer] = []

    def load_solver() -> list[Any]:
        try:
            loaded.append(Observer(spec, profile))
            return ["loaded", loaded[0].declared]
        except SolverError as error:
            if error.__cause__ is None:
                return ["refused", str(error)]
            return ["broken", str(error), own_frames(error.__cause__)]
        except BaseException as error:  # a plug-in's property may raise anything
            return ["broken", exception_text(error), own_frames(error)]

    def handle(task: list[Any]) -> tuple[list[Any], bool]:
        if task[0] == "load":
            return load_solver(), False
        _, encoded, limit = task
        [observer] = loaded
        try:
            seen = observer.ask(decode_question(encoded), limit)
        except KeyboardInterrupt as error:  # the solver's own: Ctrl-C does not reach this process
            seen = Observation(raised_answer(error), own_frames(error))
        with suppress(Exception):
            ctypes.CDLL(None).fflush(None)  # what C printed belongs to this question
        return [encode_reply(seen.reply), seen.traceback, seen.changes, seen.loaded], False

    answer_tasks(channel, handle)
