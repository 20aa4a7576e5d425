"""What a worker is doing, since when: a few numbers in memory that its supervisor reads."""

from __future__ import annotations

from enum import IntEnum
from multiprocessing.context import BaseContext
from time import monotonic
from typing import Any, NamedTuple


class Phase(IntEnum):
    """Starting lasts until the first order; preparing is loading a solver.

    The clock is lost if a solver writes rubbish over it.
    """

    STARTING = 0
    IDLE = 1
    PREPARING = 2
    WARMING_UP = 3
    SOLVING = 4
    LOST = 5


class Reading(NamedTuple):
    """Process, number of the order, phase, and since when (`time.monotonic`, one for all here)."""

    pid: int
    order: int
    phase: Phase
    since: float


class Clock:
    """Written by the worker, read by its supervisor; survives the worker."""

    def __init__(self, context: BaseContext):
        self._numbers: Any = context.RawArray("d", len(Reading._fields))
        self.reset()

    def reset(self) -> None:
        self._numbers[:] = (0, -1, Phase.STARTING, monotonic())

    def write(self, pid: int, order: int, phase: Phase) -> None:
        self._numbers[:] = (pid, order, phase, monotonic())

    def read(self) -> Reading:
        pid, order, phase, since = self._numbers[:]
        try:
            return Reading(int(pid), int(order), Phase(int(phase)), since)
        except (ValueError, OverflowError):
            return Reading(0, -1, Phase.LOST, 0.0)
