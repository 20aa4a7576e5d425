"""Questions and replies as they travel between a pool and its workers: only plain values.

A plug-in may return objects of its own classes, which would run its code where they are unpickled.
Therefore every message is a line of JSON; the arrays of a path are raw doubles in base64.
"""

from __future__ import annotations

import json
import socket
from binascii import a2b_base64, b2a_base64
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import fields
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.asking.reply import Reply
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Outcome

_READ_BYTES = 2**20
_MAX_TEXT_CHARS = 2000


class Channel:
    """Messages over a socket. The socket blocks in a worker, but not in the worker's pool.

    If the other end is closed, reading raises EOFError; a line that is no JSON raises ValueError.
    """

    def __init__(self, line: socket.socket):
        self.line = line
        self._received, self._unsent = bytearray(), bytearray()

    def put(self, message: Any) -> None:
        """Add a message to the buffer that `flush` sends."""
        self._unsent += json.dumps(message).encode() + b"\n"

    def flush(self) -> bool:
        """Send the buffer. Returns whether all of it was sent; always true if the socket blocks."""
        try:
            while self._unsent:
                del self._unsent[: self.line.send(self._unsent)]
        except BlockingIOError:
            return False
        return True

    def receive(self) -> Any:
        """Wait for one message."""
        while (message := self.next_received()) is None:
            self._read()
        return message

    def received(self) -> Iterator[Any]:
        """The messages that have arrived, without waiting; the socket must not block."""
        with suppress(BlockingIOError):
            self._read()
        while (message := self.next_received()) is not None:
            yield message

    def next_received(self) -> Any:
        """The next message that has been read already; None if there is none."""
        end = self._received.find(b"\n") + 1
        if not end:
            return None
        text = self._received[:end]
        del self._received[:end]
        return json.loads(text)

    def _read(self) -> None:
        data = self.line.recv(_READ_BYTES)
        if not data:
            raise EOFError
        self._received += data


class WorkerReply(NamedTuple):
    """A solver's reply, with the start time and the versions that a row records."""

    reply: Reply
    started: str = ""  # when the solve started (UTC, ISO 8601); empty if it did not start
    versions: str = ""  # of the solver's libraries, as JSON
    code_digest: str = ""  # of the solver's code (see `code_digest`); empty if it did not load
    # what the solve added to the memory of its process, and what its engine takes for nothing
    memory_mib: float | None = None
    floor_s: float | None = None


# `dataclasses.astuple` copies every value, which takes longer than the rest of the message.
_scenario_values = attrgetter(*(field.name for field in fields(Scenario)))


def encode_question(question: Question) -> list[Any]:
    """A question as plain values."""
    guess = _encode_path(question.initial_guess)
    return [_scenario_values(question.scenario), question.branch, guess, question.repeat]


def decode_question(values: list[Any]) -> Question:
    """The question that was encoded."""
    scenario, branch, guess, repeat = values
    return Question(Scenario(*scenario, _radians=True), branch, _decode_path(guess), repeat)


def _encode_path(path: Path | None) -> list[Any] | None:
    if path is None:
        return None
    arrays = path.curvatures.tobytes() + path.lengths.tobytes()
    return [*map(float, path.start), b2a_base64(arrays, newline=False).decode()]


def _decode_path(values: list[Any] | None) -> Path | None:
    if values is None:
        return None
    *start, arrays = values
    return Path(Pose(*start), *np.frombuffer(a2b_base64(arrays)).reshape(2, -1))


def encode_reply(sent: WorkerReply) -> list[Any]:
    """A reply as plain values, those of the solution by name."""
    outcome, solution, times = sent.reply  # of plain values, as `ask` hands it on
    values = {
        name: value[:_MAX_TEXT_CHARS] if isinstance(value, str) else value
        for name, value in vars(solution).items()
    }
    values["path"] = _encode_path(solution.path)
    values["trace"] = [(count, _encode_path(path)) for count, path in solution.trace]
    if solution.point is not None:
        values["point"] = b2a_base64(solution.point.tobytes(), newline=False).decode()
    return [outcome, vars(times), values, *sent[1:]]


def decode_reply(values: list[Any]) -> WorkerReply:
    """The reply that was encoded; raises some exception if the values do not encode one."""
    outcome, times, solution, *sent = values
    point = None if solution["point"] is None else np.frombuffer(a2b_base64(solution["point"]))
    trace = [(count, _decode_path(path)) for count, path in solution["trace"]]
    path = _decode_path(solution["path"])
    solution = Solution(**solution | {"path": path, "trace": trace, "point": point})
    return WorkerReply(Reply(Outcome(outcome), solution, Times(**times)), *sent)
