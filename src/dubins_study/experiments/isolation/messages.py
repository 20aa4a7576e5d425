"""Questions and replies as pools and workers send them.

Messages hold only plain values.

A plug-in may return objects of its own classes, which would run its code where they are unpickled.
Therefore every message is a line of JSON. A channel also takes paths and arrays of doubles. Each
becomes an object with a single key, which no setting can have; the bytes of an array are in base64.
"""

from __future__ import annotations

import json
import socket
from binascii import a2b_base64, b2a_base64
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import fields
from operator import attrgetter
from typing import Any

import numpy as np

from dubins_study.asking.reply import Reply
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Outcome

_READ_BYTES = 2**20
_MAX_TEXT_CHARS = 2000
# Keys of encoded paths and arrays; with a space, since settings are names of Python.
_PATH = "a path"
_ARRAY = "an array"


def _encode(value: Any) -> dict[str, Any]:
    """The object that a path or an array becomes.

    A path becomes `{"a path": [x, y, heading, curvatures, lengths]}`.
    """
    if isinstance(value, Path):
        return {_PATH: [*value.start, value.curvatures, value.lengths]}
    return {_ARRAY: b2a_base64(value.tobytes(), newline=False).decode()}


def _decode(values: dict[str, Any]) -> Any:
    """The path or the array that was encoded.

    Any other object stays as it is.
    """
    if values.keys() == {_PATH}:
        *start, curvatures, lengths = values[_PATH]
        return Path(Pose(*start), curvatures, lengths)
    if values.keys() == {_ARRAY}:
        return np.frombuffer(a2b_base64(values[_ARRAY]))
    return values


_ENCODER = json.JSONEncoder(default=_encode)
_DECODER = json.JSONDecoder(object_hook=_decode)


class Channel:
    """Messages over a socket.

    The socket blocks in a worker, but not in the worker's pool.

    If the other end is closed, reading raises EOFError; a line that is no JSON raises ValueError.
    """

    def __init__(self, line: socket.socket):
        self.line = line
        self._received = bytearray()
        self._unsent = bytearray()

    def put(self, message: Any) -> None:
        """Add a message to the buffer that `flush` sends."""
        self._unsent += _ENCODER.encode(message).encode() + b"\n"

    def flush(self) -> bool:
        """Send the buffer; return whether it is empty then.

        The result is always true if the socket blocks.
        """
        try:
            while self._unsent:
                del self._unsent[: self.line.send(self._unsent)]
        except BlockingIOError:
            return False
        return True

    def receive(self) -> Any:
        """Wait for the next message and return it."""
        while (message := self.next_received()) is None:
            self._read()
        return message

    def received(self) -> Iterator[Any]:
        """The messages that have arrived, without waiting.

        The socket must not block.
        """
        with suppress(BlockingIOError):
            self._read()
        while (message := self.next_received()) is not None:
            yield message

    def next_received(self) -> Any:
        """The next message that has arrived, or None."""
        end = self._received.find(b"\n") + 1
        if not end:
            return None
        text = self._received[:end]
        del self._received[:end]
        return _DECODER.decode(text.decode())

    def _read(self) -> None:
        data = self.line.recv(_READ_BYTES)
        if not data:
            raise EOFError
        self._received += data


# `dataclasses.astuple` copies every value, which takes longer than the rest of the message.
_scenario_values = attrgetter(*(field.name for field in fields(Scenario)))


def encode_question(question: Question) -> list[Any]:
    """A question as values that a channel takes."""
    scenario = _scenario_values(question.scenario)
    return [scenario, question.branch, question.initial_guess, question.repeat]


def decode_question(values: list[Any]) -> Question:
    """The question that was encoded."""
    scenario, *others = values
    return Question(Scenario(*scenario, _radians=True), *others)


def encode_reply(reply: Reply) -> list[Any]:
    """A reply as values that a channel takes.

    Texts are cut to the length that a row holds.
    """
    outcome, solution, times, *others = reply
    values = vars(solution).copy()
    for name, value in values.items():
        if isinstance(value, str):
            values[name] = value[:_MAX_TEXT_CHARS]
    return [outcome, values, vars(times), *others]


def decode_reply(encoded: list[Any]) -> Reply:
    """The reply that was encoded.

    Any exception may be raised if the values do not encode a reply.
    """
    outcome, values, times, *others = encoded
    return Reply(Outcome(outcome), Solution(**values), Times(**times), *others)
