"""One worker process under supervision: a pebble pool of one, thrown away when the worker ends."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from multiprocessing import active_children
from multiprocessing.context import ForkServerContext, ForkServerProcess
from types import ModuleType
from typing import Any

from pebble import CONSTS, ProcessPool

from experiments import processes
from experiments.clock import Clock, Phase
from experiments.last_words import LastWords
from experiments.wire import Packed
from experiments.worker import Order, answer, begin
from solvers.answer import Reply

# How often pebble looks after its workers, and how long it asks them politely to go. A worker that
# is stopped is killed before, so the second only bounds what waits for the kernel.
CONSTS.sleep_unit = 0.02
CONSTS.term_timeout = 0.2

# looks at a process that is gone before it is held to be: pebble has noticed by then
_LOOKS = 2

# s that a pool thrown away is given to take its threads and semaphores back
_PARTING = 2.0

_main = threading.Lock()


@contextmanager
def _main_hidden() -> Iterator[None]:
    """A worker needs nothing of the caller's script, and must not run it again.

    multiprocessing imports a parent's main module into its children, which a script that calls
    `run` without `if __name__ == "__main__"` does not survive.
    """
    with _main:
        kept = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = kept


class _Process(ForkServerProcess):
    @staticmethod
    def _Popen(process_obj: Any) -> Any:  # noqa: N802
        with _main_hidden():
            return ForkServerProcess._Popen(process_obj)


class _Context(ForkServerContext):
    """Workers fork from a small server that has our modules loaded, and no solver, and no thread.

    A plain fork would carry over the parent's threads; a spawn takes a second every time.
    """

    Process = _Process


CONTEXT = _Context()
CONTEXT.set_forkserver_preload(["experiments.worker"])

# called when an order's future is done
Told = Callable[["Slot", int, Future[Packed]], None]


class Slot:
    """A place for one worker at a time. `pending` are the orders put and not yet answered."""

    def __init__(self, memory: int, told: Told):
        self.memory, self._told = memory, told
        self.words = LastWords()
        self.pending: dict[int, Order] = {}
        # set by the watch just before it kills: the order, and what became of it
        self.doom: tuple[int, Reply] | None = None
        self._pool: ProcessPool | None = None
        self._process: Any = None
        self._missed = 0
        self._leaving: list[threading.Thread] = []
        self.clock = Clock(CONTEXT)

    def put(self, order: Order) -> None:
        """Give the worker one more order; the first one starts the worker."""
        self.pending[order.number] = order
        fresh = self._pool is None
        if self._pool is None:
            self.clock, self.doom, self._missed = Clock(CONTEXT), None, 0
            begun = (self.clock, self.words.writer, self.memory)
            self._pool = ProcessPool(1, initializer=begin, initargs=begun, context=CONTEXT)
        others = set(active_children()) if fresh else set()
        future = self._pool.schedule(answer, args=(order,))
        if fresh:
            self._process = next(iter(set(active_children()) - others), None)
        pool = self._pool

        def tell(done: Future[Packed]) -> None:
            if pool is self._pool:
                self._told(self, order.number, done)

        future.add_done_callback(tell)

    @property
    def pid(self) -> int:
        """The worker's process, 0 if there is none."""
        return (self._process and self._process.pid) or 0

    def gone(self) -> bool:
        """Whether there was a worker and it ended some looks ago.

        Asked of the system: two threads that ask the process object at once, ours and pebble's,
        can lose its exit code.
        """
        if not self.pid or processes.alive(self.pid):
            self._missed = 0
        else:
            self._missed += 1
        return self._missed > _LOOKS

    def running(self) -> Order | None:
        """The order that the worker is at, or was when it ended."""
        reading = self.clock.read()
        if reading.phase in (Phase.PREPARING, Phase.SOLVING):
            return self.pending.get(reading.order)
        return None

    def exit_code(self) -> int | None:
        """How the worker ended: a negative number is a signal's. None if it is not known."""
        code: int | None = self._process and self._process.exitcode
        return code

    def clear(self) -> list[Order]:
        """End the worker and all that it started; the orders that were still pending."""
        pool, pid, left = self._pool, self.pid, list(self.pending.values())
        self._pool = self._process = None
        self.pending = {}
        if pid:
            processes.end(pid)
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
