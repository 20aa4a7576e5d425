"""Jobs and replies as they travel between a pool and its workers: plain values and nothing else.

What a plug-in returned may be of its own classes, which would run its code wherever they are
unpickled. Every message is JSON, with the arrays of paths as raw doubles behind it, and every
value of a reply is made anew as Python's own int, float or str.
"""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import fields
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.protocol import Outcome, Question, Solution
from dubins_study.solvers.reply import Reply, Times
from dubins_study.study.check.verdict import Claim
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario

# before each message: a mark that tells it from rubbish, bytes of JSON, bytes of arrays
_HEADER = struct.Struct("!4sIQ")
_MARK = b"DSM1"
_MAX_JSON_BYTES, _MAX_ARRAY_BYTES = 2**28, 2**32
_READ_BYTES = 2**20
_MAX_TEXT_CHARS = 2000


class MessageError(ValueError):
    """What came down a channel is no message."""


class Channel:
    """Messages over a socket, whether that blocks or not."""

    def __init__(self, line: socket.socket):
        self._line = line
        self._received = bytearray()
        self._unsent = bytearray()

    def fileno(self) -> int:
        return self._line.fileno()

    def close(self) -> None:
        self._line.close()

    def block(self) -> None:
        """Wait in `send` and `receive`, even if a solver has set the socket not to block."""
        self._line.setblocking(True)

    def put(self, value: Any, arrays: bytes = b"") -> None:
        """Add a message to those that `flush` sends."""
        text = json.dumps(value).encode()
        self._unsent += _HEADER.pack(_MARK, len(text), len(arrays)) + text + arrays

    def send(self, value: Any, arrays: bytes = b"") -> None:
        """Send a message; all of it, where the socket blocks."""
        self.put(value, arrays)
        self.flush()

    def flush(self) -> bool:
        """Send what has been put; whether all of it went, which it does where the socket blocks."""
        try:
            while self._unsent:
                del self._unsent[: self._line.send(self._unsent)]
        except BlockingIOError:
            return False
        return True

    def receive(self) -> tuple[Any, bytes]:
        """Wait for one message: its value, and its arrays one after another.

        Raises:
            EOFError: if the other end is closed.
        """
        while (message := self._next()) is None:
            self._read()
        return message

    def received(self) -> Iterator[tuple[Any, bytes]]:
        """The messages that have arrived, without waiting; the socket must not block.

        Raises:
            EOFError: if the other end is closed.
            MessageError: if what arrived is no message.
        """
        with suppress(BlockingIOError):
            self._read()
        while (message := self._next()) is not None:
            yield message

    def _read(self) -> None:
        data = self._line.recv(_READ_BYTES)
        if not data:
            raise EOFError
        self._received += data

    def _next(self) -> tuple[Any, bytes] | None:
        if len(self._received) < _HEADER.size:
            return None
        mark, text_size, array_size = _HEADER.unpack_from(self._received)
        if mark != _MARK or text_size > _MAX_JSON_BYTES or array_size > _MAX_ARRAY_BYTES:
            raise MessageError("rubbish came down the channel")
        middle = _HEADER.size + text_size
        end = middle + array_size
        if len(self._received) < end:
            return None
        text, arrays = self._received[_HEADER.size : middle], bytes(self._received[middle:end])
        del self._received[:end]
        try:
            return json.loads(text), arrays
        except (ValueError, RecursionError) as error:
            raise MessageError(f"a message that cannot be read: {error}") from None


class WorkerReply(NamedTuple):
    """A reply, the moment its question was put (UTC, ISO 8601), and what it rests on.

    Args:
        reply: what came back of the question.
        started: when the question was put; empty if it was not.
        versions: of the solver's libraries, as JSON.
        code_digest: of the code that replied (see `code_digest`), empty if it did not load.
    """

    reply: Reply
    started: str = ""
    versions: str = ""
    code_digest: str = ""


# `dataclasses.astuple` copies every value, which takes longer than all the rest of a message
_scenario_values = attrgetter(*(field.name for field in fields(Scenario)))


def encode_question(question: Question) -> tuple[list[Any], bytes]:
    """A question as plain values, and the arrays of its initial guess."""
    start, arrays = _encode_path(question.initial_guess)
    return [_scenario_values(question.scenario), question.branch, start], arrays


def decode_question(values: Sequence[Any], arrays: bytes) -> Question:
    """The question again."""
    scenario, branch, start = values
    return Question(Scenario(*scenario), branch, _decode_path(start, arrays))


def _encode_path(path: Path | None) -> tuple[list[float] | None, bytes]:
    """A path's start, and its two arrays one after the other."""
    if path is None:
        return None, b""
    path = Path(path.start, path.curvature, path.length)  # its arrays may be others by now
    controls = (np.asarray(values, np.float64) for values in (path.curvature, path.length))
    return [float(value) for value in path.start], b"".join(map(np.ndarray.tobytes, controls))


def _decode_path(start: Sequence[float] | None, arrays: bytes) -> Path | None:
    return None if start is None else Path(Pose(*start), *np.frombuffer(arrays).reshape(2, -1))


_NAMES = [field.name for field in fields(Solution)]


def encode_reply(sent: WorkerReply) -> tuple[list[Any], bytes]:
    """A reply as plain values, and the arrays of its path.

    Raises:
        Exception: whatever a plug-in's values do when they are read.
    """
    reply = sent.reply
    # checked once more: what a plug-in's class holds may have changed since it was made
    solution = Solution(*[getattr(reply.solution, name) for name in _NAMES])
    start, arrays = _encode_path(solution.path)
    dual = solution.multipliers
    values = [
        str(reply.outcome.value),
        [reply.times.build, reply.times.solve, reply.times.wall],
        str(Claim(solution.claim).value),
        start,
        _float(solution.claimed_length),
        _float(solution.lower_bound),
        None if dual is None else [float.__float__(dual[0]), float.__float__(dual[1])],
        _int(solution.iterations),
        _int(solution.evaluations),
        _text(solution.native_status),
        _text(solution.message),
        *sent[1:],
    ]
    return values, arrays


def decode_reply(values: Sequence[Any], arrays: bytes) -> WorkerReply:
    """The reply again.

    Raises:
        Exception: if the values are not those of a reply.
    """
    outcome, times, claim, start, claimed, bound, dual, *rest = values
    iterations, evaluations, status, message, started, versions, digest = rest
    path = _decode_path(start, arrays)
    answer = (Claim(claim), path, claimed, bound, dual, iterations, evaluations, status, message)
    reply = Reply(Outcome(outcome), Solution(*answer), Times(*times))
    return WorkerReply(reply, str(started), str(versions), str(digest))


def _float(value: float | None) -> float | None:
    return None if value is None else float.__float__(value)


def _int(value: int | None) -> int | None:
    return None if value is None else int.__index__(value)


def _text(value: str) -> str:
    # by way of bytes, since a subclass of str passes as one
    return str.encode(value[:_MAX_TEXT_CHARS], "utf-8", "replace").decode("utf-8")
