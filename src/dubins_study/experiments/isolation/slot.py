"""One worker process under supervision: a pebble pool of one, thrown away when the worker ends."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from multiprocessing.context import ForkServerProcess
from typing import Any, NamedTuple

from pebble import CONSTS, ProcessPool

from dubins_study.experiments.engines.calibration import probe
from dubins_study.experiments.isolation import processes
from dubins_study.experiments.isolation.clock import Clock, Phase
from dubins_study.experiments.isolation.last_words import LastWords
from dubins_study.experiments.isolation.spawning import Context, end_orphans
from dubins_study.experiments.isolation.worker import Order, answers, begin
from dubins_study.solvers.attempt import Reply

# How often pebble looks after its workers, and how long it asks them politely to go. A worker that
# is stopped is killed before, so the second only bounds what waits for the kernel.
CONSTS.sleep_unit = 0.02
CONSTS.term_timeout = 0.2

# s that a pool thrown away is given to take its threads and semaphores back
_PARTING = 2.0

# numbers of orders that travel in one message; a look at the machine's speed is of none
Batch = tuple[int, ...]
PROBE: Batch = ()

# called when a batch's future is done: with its replies, packed, or with a probe's seconds
Told = Callable[["Slot", Batch, Future[Any]], None]


class Doom(NamedTuple):
    """A process that is killed for what it does with an order, and the reply to that."""

    pid: int
    order: int
    reply: Reply


class Slot:
    """A place for one worker at a time. `pending` are the orders put and not yet answered."""

    def __init__(self, memory: int, told: Told):
        self.memory, self._told = memory, told
        self.words = LastWords()
        self.kind = ""  # of the cells that its worker is asked
        self.pending: dict[int, Order] = {}
        self.batches: list[Batch] = []  # those that no future has told of yet, the first one first
        # set by the watch just before it kills
        self.doom: Doom | None = None
        self._pool: ProcessPool | None = None
        self._leaving: list[threading.Thread] = []
        self._context = Context()
        self.clock = Clock(self._context)

    def put(self, orders: list[Order]) -> None:
        """Give the worker more orders in one message; the first ones start the worker."""
        self.pending |= {order.number: order for order in orders}
        batch = tuple(order.number for order in orders)
        self.batches.append(batch)
        if self._pool is None:
            self._context, self.doom = Context(), None
            self.clock = Clock(self._context)
            begun = (self.clock, self.words.writer, self.memory)
            self._pool = ProcessPool(1, initializer=begin, initargs=begun, context=self._context)
        self._tell_of(self._pool, batch, self._pool.schedule(answers, args=(orders,)))

    def measure(self) -> None:
        """Have the worker do the calibration's piece of work when it has none of its own."""
        if self._pool is not None and self.pid:
            self._tell_of(self._pool, PROBE, self._pool.schedule(probe))

    def take(self, batch: Batch) -> list[Order]:
        """The orders of a batch that has been told of, those that are still waited for."""
        self.batches.remove(batch)
        return [self.pending.pop(number) for number in batch if number in self.pending]

    def _tell_of(self, pool: ProcessPool, batch: Batch, future: Future[Any]) -> None:
        def tell(done: Future[Any]) -> None:
            if pool is self._pool:
                self._told(self, batch, done)

        future.add_done_callback(tell)

    @property
    def _process(self) -> ForkServerProcess | None:
        return self._context.worker

    @property
    def pid(self) -> int:
        """The worker's process, 0 if there is none."""
        worker = self._process  # once: another thread may throw it away meanwhile
        return 0 if worker is None else worker.pid or 0

    def exit_code(self) -> int | None:
        """How the worker ended: a negative number is a signal's. None if it lives."""
        worker = self._process
        return None if worker is None else worker.exitcode

    def running(self) -> Order | None:
        """The order that the worker is at, or was when it ended."""
        reading = self.clock.read()
        if reading.phase is Phase.LOST:  # it takes them up in turn
            return next(iter(self.pending.values()), None)
        # one that is idle may not have handed over its last answer yet
        return self.pending.get(reading.order)

    def answered_among_others(self, order: Order) -> bool:
        """Whether the worker is through with an order of several whose replies travel together."""
        together = any(order.number in batch for batch in self.batches if len(batch) > 1)
        return together and self.clock.read().phase is Phase.IDLE

    def clear(self) -> list[Order]:
        """End the worker and all that it started; the orders that were still pending."""
        pool, pid, left = self._pool, self.pid, list(self.pending.values())
        self._pool, self._context = None, Context()
        self.pending, self.batches = {}, []
        if pid:
            processes.end(pid)
            end_orphans()
        if pool is not None:
            pool.stop()
            # its threads need a moment to notice; the next worker does not wait for them
            self._leaving = [thread for thread in self._leaving if thread.is_alive()]
            self._leaving.append(threading.Thread(target=_joined, args=(pool,), daemon=True))
            self._leaving[-1].start()
        return left

    def close(self) -> None:
        self.clear()
        for thread in self._leaving:
            thread.join(_PARTING)
        self.words.close()


def _joined(pool: ProcessPool) -> None:
    with suppress(Exception):  # it was thrown away; how it takes that is its own affair
        pool.join()
