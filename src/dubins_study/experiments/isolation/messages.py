"""Jobs and replies as they travel between a pool and its workers: only plain values.

A plug-in may return objects of its own classes, which would run its code where they are unpickled.
Therefore every message is a line of JSON, the arrays of a path are raw doubles in base64, and every
value of a reply is converted to Python's own int, float or str.
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

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.reply import Reply
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Outcome

_READ_BYTES = 2**20
_MAX_MESSAGE_BYTES = 2**32
_MAX_TEXT_CHARS = 2000


class MessageError(ValueError):
    """A channel received something that is not a message."""


class Channel:
    """Messages over a socket. The socket blocks in a worker, but not in the worker's pool."""

    def __init__(self, line: socket.socket):
        self.line = line
        self._received, self._unsent = bytearray(), bytearray()

    def put(self, message: list[Any]) -> None:
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
        """Wait for one message.

        Raises:
            EOFError: if the other end is closed.
        """
        while (message := self.next_received()) is None:
            self._read()
        return message

    def received(self) -> Iterator[Any]:
        """The messages that have arrived, without waiting; the socket must not block.

        Raises:
            EOFError: if the other end is closed.
            MessageError: if something arrived that is not a message.
        """
        with suppress(BlockingIOError):
            self._read()
        while (message := self.next_received()) is not None:
            yield message

    def _read(self) -> None:
        data = self.line.recv(_READ_BYTES)
        if not data:
            raise EOFError
        self._received += data

    def next_received(self) -> Any:
        """The next message that `receive` has read already; None if there is none."""
        invalid = self._received and not self._received.startswith(b"[")
        if invalid or len(self._received) > _MAX_MESSAGE_BYTES:
            raise MessageError("rubbish, which is no message")
        end = self._received.find(b"\n") + 1
        if not end:
            return None
        text = self._received[:end]
        del self._received[:end]
        try:
            return json.loads(text)
        except (ValueError, RecursionError) as error:
            raise MessageError(f"a message that cannot be read: {error}") from None


class WorkerReply(NamedTuple):
    """A solver's reply, with the start time and the versions that a row records.

    Args:
        reply: the solver's reply to the question.
        started: when the solve started (UTC, ISO 8601); empty if it did not start.
        versions: versions of the solver's libraries, as JSON.
        code_digest: digest of the solver's code (see `code_digest`); empty if it did not load.
    """

    reply: Reply
    started: str = ""
    versions: str = ""
    code_digest: str = ""


# `dataclasses.astuple` copies every value, which takes longer than the rest of the message.
_scenario_values = attrgetter(*(field.name for field in fields(Scenario)))


def encode_question(question: Question) -> list[Any]:
    """A question as plain values."""
    guess = _encode_path(question.initial_guess)
    return [_scenario_values(question.scenario), question.branch, guess, question.repeat]


def decode_question(values: list[Any]) -> Question:
    """The question that was encoded."""
    scenario, branch, guess, repeat = values
    return Question(Scenario(*scenario), branch, _decode_path(guess), repeat)


def _encode_path(path: Path | None) -> list[Any] | None:
    """A path's start, followed by its two arrays in one text."""
    if path is None:
        return None
    arrays = [np.asarray(values, np.float64).tobytes() for values in (path.curvature, path.length)]
    return [*map(float, path.start), b2a_base64(b"".join(arrays), newline=False).decode()]


def _decode_path(values: list[Any] | None) -> Path | None:
    if values is None:
        return None
    *start, arrays = values
    return Path(Pose(*start), *np.frombuffer(a2b_base64(arrays)).reshape(2, -1))


def encode_reply(sent: WorkerReply) -> list[Any]:
    """A reply as plain values, those of the solution by name."""
    outcome, solution, times = sent.reply  # of plain values, as `ask` hands it on
    values = {name: _short(value) for name, value in vars(solution).items()}
    values["path"] = _encode_path(solution.path)
    return [outcome, vars(times), values, *sent[1:]]


def decode_reply(values: list[Any]) -> WorkerReply:
    """The reply that was encoded.

    Raises:
        Exception: if the values do not encode a reply.
    """
    outcome, times, solution, *texts = values
    solution = Solution(**solution | {"path": _decode_path(solution["path"])})
    return WorkerReply(Reply(Outcome(outcome), solution, Times(**times)), *map(str, texts))


def _short(value: Any) -> Any:
    return value[:_MAX_TEXT_CHARS] if isinstance(value, str) else value
