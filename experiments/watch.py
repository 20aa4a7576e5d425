"""The watch over workers: what takes too long, or holds too much, is killed at once."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from time import monotonic
from typing import NamedTuple

from experiments import processes
from experiments.clock import Phase, Reading
from experiments.slot import Slot
from solvers.answer import Reply, Times, nothing
from solvers.protocol import Outcome

TICK = 0.02  # s between two looks
# A solver that keeps to its limit needs a moment to hand its answer over. With the looks and the
# kill itself, a solve ends within 0.3 s of its limit.
GRACE = 0.1
# s for a process to start, or a solver to be loaded
START_UP = 60.0
# s that a warm-up solve may take beyond its limit: what is imported late comes here
_WARM_UP = 10.0
# s in which an idle worker must take up its next order
_STALL = 10.0
# looks between two at a worker's children, which cost milliseconds where many processes run
_FAMILY_EVERY = 10
_GIB = 2**30


class Bounds(NamedTuple):
    """Seconds that a solve may take and bytes that a worker and its children may hold."""

    limit: float
    memory: int


class Watch:
    """A thread that looks at every slot, while entered."""

    def __init__(self, slots: Iterable[Slot], bounds: Bounds):
        self.slots, self.bounds = list(slots), bounds
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="watch", daemon=True)

    def __enter__(self) -> Watch:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _keep(self) -> None:
        before: dict[Slot, Reading] = {}
        looks = 0
        while not self._over.wait(TICK):
            looks += 1
            for slot in self.slots:
                reading = slot.clock.read()
                # one that was being written while it was read is not the same again
                if reading == before.get(slot):
                    self._look(slot, reading, whole=looks % _FAMILY_EVERY == 0)
                before[slot] = reading

    def _look(self, slot: Slot, reading: Reading, whole: bool) -> None:
        pid = slot.pid
        if slot.doom is not None or not pid or reading.pid not in (0, pid):
            return
        doom = self._too_long(slot, reading) or self._too_much(pid, reading, whole)
        if doom is not None:
            slot.doom = (reading.order, doom)
            processes.end(pid)

    def _too_long(self, slot: Slot, reading: Reading) -> Reply | None:
        seconds, limit = monotonic() - reading.since, self.bounds.limit
        allowed = {
            Phase.STARTING: START_UP,
            Phase.IDLE: _STALL if slot.pending else float("inf"),
            Phase.LOADING: START_UP,
            Phase.WARMING: limit + _WARM_UP,
            Phase.SOLVING: limit + GRACE,
        }[reading.phase]
        if seconds <= allowed:
            return None
        message = f"stopped after {seconds:.2f} s; the limit is {limit:g} s"
        if reading.phase is not Phase.SOLVING:
            message = f"stopped after {seconds:.0f} s"
        return nothing(Outcome.TIMEOUT, message, Times(wall=seconds))

    def _too_much(self, pid: int, reading: Reading, whole: bool) -> Reply | None:
        held = processes.resident(pid, whole)
        if held <= self.bounds.memory:
            return None
        message = (
            f"stopped holding {held / _GIB:.2f} GiB; the limit is {self.bounds.memory / _GIB:g} GiB"
        )
        times = Times(wall=monotonic() - reading.since)
        return nothing(Outcome.OUT_OF_MEMORY, message, times)
