"""The status of a worker: a few numbers in memory that the worker shares with its pool."""

from __future__ import annotations

import mmap
import os
import sys
from enum import IntEnum
from tempfile import TemporaryFile
from time import monotonic
from typing import NamedTuple


class Phase(IntEnum):
    """What a worker is doing.

    STARTING lasts until the worker is ready for its first job. LOST: the worker has overwritten the
    shared memory, so its values are invalid.
    """

    STARTING = 0
    IDLE = 1
    LOADING = 2
    WARMING_UP = 3
    SOLVING = 4
    LOST = 5


class Reading(NamedTuple):
    """The number of the job (0: no job yet), the phase, and its start (s, `time.monotonic`)."""

    job: int
    phase: Phase
    since_s: float


# Index of the only double that the pool writes; it is apart from those that the worker writes.
_WITHDRAWN_INDEX = 8


class WorkerStatus:
    """A worker's current job and phase: the worker writes, the pool reads, also after its end.

    Args:
        descriptor: the file descriptor of the shared memory, see `shared_memory`. It is closed
            here: the memory stays mapped, and no process can shrink it now.
    """

    def __init__(self, descriptor: int):
        self._doubles = memoryview(mmap.mmap(descriptor, mmap.PAGESIZE)).cast("d")
        os.close(descriptor)

    def write(self, job: int, phase: Phase) -> None:
        self._doubles[0], self._doubles[1], self._doubles[2] = job, phase, monotonic()

    def read(self) -> Reading:
        job, phase, since_s = self._doubles[:3]
        try:
            return Reading(int(job), Phase(int(phase)), since_s)
        except (ValueError, OverflowError):
            return Reading(0, Phase.LOST, 0.0)

    @property
    def withdrawn(self) -> float:
        """Job number; the worker skips every job with a lower number that it has not begun."""
        return self._doubles[_WITHDRAWN_INDEX]

    @withdrawn.setter
    def withdrawn(self, number: float) -> None:
        self._doubles[_WITHDRAWN_INDEX] = number


def shared_memory() -> int:
    """The file descriptor of new memory that another process can share."""
    if sys.platform == "linux":
        descriptor = os.memfd_create("worker-status")
    else:
        with TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, mmap.PAGESIZE)
    return descriptor
