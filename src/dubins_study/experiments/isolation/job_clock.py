"""What a worker is doing, and since when: a few numbers in memory that it shares with its pool."""

from __future__ import annotations

import mmap
import os
import sys
from enum import IntEnum
from tempfile import TemporaryFile
from time import monotonic
from typing import NamedTuple


class Phase(IntEnum):
    """What a worker is doing. It starts until its first job; `LOST`: it wrote over its clock."""

    STARTING = 0
    IDLE = 1
    LOADING = 2
    WARMING_UP = 3
    SOLVING = 4
    LOST = 5


class Reading(NamedTuple):
    """The job's number (0: none yet), the phase, and since when (s, `time.monotonic`)."""

    job: int
    phase: Phase
    since_s: float


# in the memory, apart from what the worker writes
_WITHDRAWN_PLACE = 8


class JobClock:
    """Written by a worker, read by its pool; survives the worker.

    Args:
        descriptor: of the memory that both share, see `shared_memory`. It is closed here, so that
            nobody can make the memory shorter.
    """

    def __init__(self, descriptor: int):
        self._numbers = memoryview(mmap.mmap(descriptor, mmap.PAGESIZE)).cast("d")
        os.close(descriptor)

    def write(self, job: int, phase: Phase) -> None:
        self._numbers[0], self._numbers[1], self._numbers[2] = job, phase, monotonic()

    def read(self) -> Reading:
        job, phase, since_s = self._numbers[:3]
        try:
            return Reading(int(job), Phase(int(phase)), since_s)
        except (ValueError, OverflowError):
            return Reading(0, Phase.LOST, 0.0)

    @property
    def withdrawn(self) -> float:
        """The worker passes over every job with a lower number that it has not begun."""
        return self._numbers[_WITHDRAWN_PLACE]

    @withdrawn.setter
    def withdrawn(self, number: float) -> None:
        self._numbers[_WITHDRAWN_PLACE] = number


def shared_memory() -> int:
    """The descriptor of new memory that another process can share."""
    if sys.platform == "linux":
        descriptor = os.memfd_create("job-clock")
    else:
        with TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, mmap.PAGESIZE)
    return descriptor
