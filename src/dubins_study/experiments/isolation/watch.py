"""The watch over workers: what takes too long, or holds too much, is killed at once."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from time import monotonic
from typing import NamedTuple

from dubins_study.experiments.isolation import processes
from dubins_study.experiments.isolation.clock import Phase, Reading
from dubins_study.experiments.isolation.slot import Doom, Slot
from dubins_study.solvers.attempt import Reply, Times, nothing
from dubins_study.solvers.protocol import Outcome

TICK = 0.02  # s between two looks
# A solver that keeps to its limit needs a moment to hand its answer over. With the looks and the
# kill itself, a solve ends within 0.3 s of its limit.
GRACE = 0.1
# s for a process to start, or a solver to be loaded
START_UP = 60.0
# s that a first solve may take beyond the limit: it loads what the others find loaded
FIRST = 10.0
# s in which an idle worker must take up its next order
_STALL = 10.0
# looks between two at a worker's children, which cost milliseconds where many processes run
_FAMILY_EVERY = 10
# s between two looks from which on nothing was looked at because everything slept
_ASLEEP = 1.0
# s that the end of a killed worker is waited for when the watch is over
_PARTING = 2.0
# s by which a look may be late on a busy machine
_LATE = 10.0
_GIB = 2**30


_DOING = {
    Phase.STARTING: "starting a worker",
    Phase.IDLE: "waiting for its answer to arrive",
    Phase.PREPARING: "loading the solver",
    Phase.WARMING_UP: "warming up",
}


class Bounds(NamedTuple):
    """Seconds that a solve may take and bytes that a worker and its children may hold."""

    limit: float
    memory: int


class Watch:
    """A thread that looks at every slot, while entered."""

    def __init__(self, slots: Iterable[Slot], bounds: Bounds):
        self.slots, self.bounds = list(slots), bounds
        self.failure: Exception | None = None
        self._away = 0.0  # s, in all, in which no look was taken: the machine or the run slept
        self._endings: list[threading.Thread] = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="watch", daemon=True)

    def __enter__(self) -> Watch:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        for ending in self._endings:
            ending.join(_PARTING)

    def _keep(self) -> None:
        try:
            self._keep_looking()
        except Exception as error:  # without it no limit holds: the supervisor ends the run
            self.failure = error

    def _keep_looking(self) -> None:
        before: dict[Slot, tuple[Reading, float, float]] = {}
        looks, last = 0, monotonic()
        while not self._over.wait(TICK):
            looks += 1
            last, pause = monotonic(), monotonic() - last
            # what is stopped as a whole (a suspended job, a laptop's lid) solves nothing meanwhile
            self._away += pause if pause > _ASLEEP else 0.0
            for slot in self.slots:
                reading = slot.clock.read()
                earlier, seen, away = before.get(slot, (None, 0.0, 0.0))
                # one that was being written while it was read is not the same again
                if reading == earlier:
                    since = _since(reading, seen) + self._away - away
                    self._look(slot, reading, since, whole=looks % _FAMILY_EVERY == 0)
                else:
                    before[slot] = reading, monotonic(), self._away

    def _look(self, slot: Slot, reading: Reading, since: float, whole: bool) -> None:
        pid, order = slot.pid, slot.running()
        if not pid or (slot.doom and slot.doom.pid == pid):
            return
        # a child that took its parent's place writes a process of its own
        phase = reading.phase if reading.pid in (0, pid) else Phase.LOST
        reply = self._too_long(slot, phase, since) or self._too_much(pid, since, whole)
        if reply is None:
            return
        processes.halt(pid)
        if slot.clock.read() != reading:  # it answered just now: the next order is not to blame
            processes.resume(pid)
            return
        slot.doom = Doom(pid, -1 if order is None else order.number, reply)
        # looking for its children takes milliseconds, which other workers' limits do not wait for
        ending = threading.Thread(target=processes.end, args=(pid,), daemon=True)
        ending.start()
        self._endings = [*filter(threading.Thread.is_alive, self._endings), ending]

    def _too_long(self, slot: Slot, phase: Phase, since: float) -> Reply | None:
        if phase is Phase.LOST:
            return nothing(Outcome.CRASHED, "stopped: it wrote over its supervisor's memory")
        seconds, limit = monotonic() - since, self.bounds.limit
        allowed = {
            Phase.STARTING: START_UP,
            Phase.IDLE: _STALL if slot.pending else float("inf"),
            Phase.PREPARING: START_UP,
            Phase.WARMING_UP: limit + FIRST,
            Phase.SOLVING: limit + GRACE,
        }[phase]
        if seconds <= allowed:
            return None
        message = f"stopped after {seconds:.2f} s; the limit is {limit:g} s"
        if phase is not Phase.SOLVING:
            message = f"stopped after {seconds:.0f} s of {_DOING[phase]}"
        return nothing(Outcome.TIMEOUT, message, Times(wall=seconds))

    def _too_much(self, pid: int, since: float, whole: bool) -> Reply | None:
        held = processes.resident(pid, whole)
        if held > self.bounds.memory and whole:
            held = processes.proportional(pid)  # slower: what they share counts once
        if held <= self.bounds.memory:
            return None
        message = (
            f"stopped holding {held / _GIB:.2f} GiB; the limit is {self.bounds.memory / _GIB:g} GiB"
        )
        times = Times(wall=monotonic() - since)
        return nothing(Outcome.OUT_OF_MEMORY, message, times)


def _since(reading: Reading, seen: float) -> float:
    """The moment that the clock tells, unless a solver has set it; else when it was first seen."""
    return reading.since if seen - _LATE <= reading.since <= seen else seen
