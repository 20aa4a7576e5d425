"""Replies as they travel from a worker process to its supervisor: plain values and nothing else.

What a plug-in returned may be of its own classes, which would run its code wherever they are
unpickled. Here every value is made anew as Python's own int, float, str or bytes.
"""

from __future__ import annotations

from dataclasses import fields
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.attempt import Reply, Times
from dubins_study.solvers.protocol import Outcome, Solution
from dubins_study.study.check.verdict import Claim
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose


class Packed(NamedTuple):
    """A reply, the moment its question was put (UTC, ISO 8601), and what it rests on.

    `code` is the digest of what replied (see `experiments.plan.code_digest`), empty if it did not load.
    """

    outcome: str
    times: tuple[float | None, ...]
    claim: str
    path: tuple[tuple[float, ...], bytes, bytes] | None
    numbers: tuple[float | None, ...]
    multipliers: tuple[float, float] | None
    counts: tuple[int | None, ...]
    texts: tuple[str, str]
    started: str
    versions: str
    code_digest: str
    worn: bool = False  # whether the worker is to be replaced


_NUMBERS = ("claimed_length", "lower_bound")
_COUNTS = ("iterations", "evaluations")
_TEXTS = ("native_status", "message")
_LONGEST = 2000  # characters of a text


def packed(reply: Reply, started: str, versions: str, code: str) -> Packed:
    """A reply as plain values.

    Raises:
        Exception: whatever a plug-in's values do when they are read.
    """
    # checked once more: what a plug-in's class holds may have changed since it was made
    given = (getattr(reply.solution, field.name) for field in fields(Solution))
    solution = Solution(*given)
    path, dual = solution.path, solution.multipliers
    return Packed(
        str(reply.outcome.value),
        (reply.times.build, reply.times.solve, reply.times.wall),
        str(Claim(solution.claim).value),
        None if path is None else _controls(path),
        tuple(_float(getattr(solution, name)) for name in _NUMBERS),
        None if dual is None else (float.__float__(dual[0]), float.__float__(dual[1])),
        tuple(_int(getattr(solution, name)) for name in _COUNTS),
        (_text(solution.native_status), _text(solution.message)),
        started,
        versions,
        code,
    )


def _controls(path: Path) -> tuple[tuple[float, ...], bytes, bytes]:
    path = Path(path.start, path.curvature, path.length)  # its arrays may be others by now
    held = (np.asarray(values, np.float64).tobytes() for values in (path.curvature, path.length))
    start: tuple[float, ...] = tuple(float(value) for value in path.start)
    curvature, length = held
    return start, curvature, length


def _float(value: float | None) -> float | None:
    return None if value is None else float.__float__(value)


def _int(value: int | None) -> int | None:
    return None if value is None else int.__index__(value)


def _text(value: str) -> str:
    # by way of bytes, since a subclass of str passes as one
    return str.encode(value[:_LONGEST], "utf-8", "replace").decode("utf-8")


def unpacked(sent: Packed) -> Reply:
    """The reply again."""
    path = None
    if sent.path is not None:
        start, curvature, length = sent.path
        path = Path(Pose(*start), np.frombuffer(curvature), np.frombuffer(length))
    claimed, bound = sent.numbers
    iterations, evaluations = sent.counts
    status, message = sent.texts
    claim, dual = Claim(sent.claim), sent.multipliers
    solution = Solution(claim, path, claimed, bound, dual, iterations, evaluations, status, message)
    return Reply(Outcome(sent.outcome), solution, Times(*sent.times))
