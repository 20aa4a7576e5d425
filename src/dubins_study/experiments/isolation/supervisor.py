"""Cells solved in worker processes that are watched, killed and replaced, judged here."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any

from pebble import ProcessExpired

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.engines.judging import row_of
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation import processes
from dubins_study.experiments.isolation.clock import Phase
from dubins_study.experiments.isolation.endings import crashed, ending
from dubins_study.experiments.isolation.loading import Loading
from dubins_study.experiments.isolation.messages import Packed, unpacked
from dubins_study.experiments.isolation.slot import PROBE, Batch, Slot
from dubins_study.experiments.isolation.tasks import Task, Tasks
from dubins_study.experiments.isolation.watch import Bounds, Watch
from dubins_study.experiments.isolation.worker import Order
from dubins_study.experiments.plan.cells import Cell, Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.solvers.attempt import Reply, nothing, told
from dubins_study.solvers.protocol import Outcome
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row
from dubins_study.study.rows.schema import Key

# Orders put to a worker in advance, so that it never waits, and how many of them travel in one
# message, each of which costs as much as judging a cell. One where solves are long, so that none
# waits behind them for a worker while another one is idle.
_AHEAD, _TOGETHER, _QUICK = 128, 32, 0.005
# s without news after which whoever writes the rows is given a turn
_TURN = 0.2
# s between two looks at how fast the machine is
_PROBE_EVERY = 2.0
# workers that may end in a row before they have taken up any order
_FALSE_STARTS = 3


# how pebble tells that a worker has ended
_ENDED = (ProcessExpired, BrokenProcessPool)


class RunError(DubinsStudyError, RuntimeError):
    """A run that could not go on; what was done is kept."""


class Supervisor:
    """Workers for as long as it is entered.

    Args:
        run: what the rows share.
        bounds: of every solve.
        jobs: workers side by side.
        probed: called now and then with the seconds that a fixed piece of work took in a worker.
        made: what a reply becomes, and the path that a sweep goes on from: a row.
        warm_up: whether solvers are asked an easy question before the first of their own.
    """

    def __init__(
        self,
        run: RunSettings,
        bounds: Bounds,
        jobs: int,
        probed: Callable[[float], None] | None = None,
        made: Callable[..., tuple[Any, Path | None]] = row_of,
        warm_up: bool = True,
    ):
        self.run, self.bounds, self._probed, self._made = run, bounds, probed, made
        self._next_probe = monotonic()
        self._ended: SimpleQueue[tuple[Slot, Batch, Future[Any]]] = SimpleQueue()
        self._slots = [Slot(bounds.memory, self._told) for _ in range(jobs)]
        self._watch = Watch(self._slots, bounds)
        self._tasks, self._loading = Tasks(), Loading(warm_up)
        self._ahead = dict.fromkeys(self._slots, 1)
        self._false_starts = 0
        # orders in one message; a single one once there was one that did not come back
        self._together = _TOGETHER

    def __enter__(self) -> Supervisor:
        self._watch.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._watch.__exit__()
        for slot in self._slots:
            slot.close()

    def end_solves(self) -> None:
        """Whatever is being solved ends here and now; may be called from any thread."""
        for slot in self._slots:
            pid = slot.pid
            if pid:
                processes.end(pid)

    def _told(self, slot: Slot, batch: Batch, future: Future[Any]) -> None:
        self._ended.put((slot, batch, future))

    def solve(
        self, chains: list[Chain], before: Mapping[Key, Path], stop: Interruption
    ) -> Iterator[list[Row]]:
        """The rows of all cells as they come; an empty list now and then where none do.

        Once the run is interrupted, only what is being solved is finished.

        Args:
            chains: single cells, and sweeps whose warm cells each start from the path before.
            before: the path before the first cell of a chain whose beginning was solved earlier.
            stop: asked after every row.

        Raises:
            RunError: if worker processes end before they have done anything.
        """
        self._tasks = Tasks(chains, before)
        while True:
            if stop.asked:
                self._finish_up()
            if not self._tasks:
                return
            more = yield from self._feed(stop)
            yield self._news(0.0 if more else _TURN)

    def _finish_up(self) -> None:
        """Forget every order that no worker is at, those of a batch that it is at excepted."""
        self._tasks.waiting.clear()
        for slot in self._slots:
            running, first = slot.running(), (*slot.batches, PROBE)[0]
            # between two orders of a batch a worker is at none
            begun = len(first) > 1 or (running is not None and running.number in first)
            for number in slot.pending.keys() - (first if begun else PROBE):
                del slot.pending[number]
                self._tasks.take(number)

    def _feed(self, stop: Interruption) -> Generator[list[Row], None, bool]:
        """Put orders to workers; whether there are more rows that need none."""
        waiting, more = self._tasks.waiting, False
        for slot in self._slots:
            orders: list[Order] = []
            spared = 0
            share = min(self._ahead[slot], -(-len(waiting) // len(self._slots)))
            while waiting and len(slot.pending) + len(orders) < share:
                if not _fits(slot, waiting[0].kind, taken=bool(orders)):
                    break
                task = waiting.popleft()
                reply = self._loading.reply(task.cell)
                if reply is not None:
                    yield self._rows(task, reply)
                    spared += 1
                    if stop.asked or spared >= _AHEAD:
                        more = True
                        break  # others may have news
                    continue
                warm_up = self._loading.warms_up(task.cell)
                orders.append(self._tasks.give(task, self.bounds.limit, warm_up))
            together = self._together  # which may change on the way
            for first in range(0, len(orders), together):
                try:
                    slot.put(orders[first : first + together])
                except RuntimeError:  # what came from the worker made no sense to pebble
                    yield self._fallen(slot)
        if self._probed is not None and monotonic() > self._next_probe:
            self._next_probe = monotonic() + _PROBE_EVERY
            try:
                self._slots[0].measure()
            except RuntimeError:  # as above
                yield self._fallen(self._slots[0])
        return more

    def _news(self, wait: float) -> list[Row]:
        if self._watch.failure is not None:
            raise RunError(
                f"the watch over the workers has ended ({told(self._watch.failure)}), and no limit "
                "would hold; the rows written so far are kept"
            )
        try:
            slot, batch, future = self._ended.get(timeout=wait)
        except Empty:
            # pebble has no word of a worker that ends itself with code 0
            ended = [slot for slot in self._slots if slot.exit_code() is not None]
            return [row for slot in ended for row in self._fallen(slot)]
        if batch == PROBE:
            if self._probed is not None and future.exception() is None:
                self._probed(future.result())
            return []
        if batch not in slot.batches:
            return []  # of a worker thrown away meanwhile
        error = future.exception() if not future.cancelled() else None
        if error is None and not future.cancelled():
            return self._arrived(slot, batch, future.result())
        if slot.pid and slot.exit_code() is None and not isinstance(error, _ENDED):
            # the worker lives, and what it sent did not arrive
            orders = slot.take(batch)
            if len(orders) == 1:
                task = self._tasks.take(orders[0].number)
                return self._rows(task, nothing(Outcome.RAISED, told(error or OSError())))
            self._together = 1  # which of them it was, is seen when they are asked alone
            self._tasks.take_back(order.number for order in orders)
            return []
        return self._fallen(slot)

    def _arrived(self, slot: Slot, batch: Batch, replies: list[Packed]) -> list[Row]:
        left = {order.number for order in slot.take(batch)}
        self._false_starts = 0
        quick = all((sent.times[2] or 0) < _QUICK for sent in replies)
        self._ahead[slot] = _AHEAD if quick else 1
        rows = []
        for number, sent in zip(batch, replies, strict=False):
            if number in left:
                left.remove(number)
                task = self._tasks.take(number)
                self._check_code(task.cell, sent)
                self._loading.answered(task.cell)
                rows += self._rows(task, _read(sent), sent.started, sent.versions)
        # a worker that is worn, or slow, leaves the rest of its batch
        self._tasks.take_back(sorted(left))
        if replies[-1].worn:
            self._empty(slot)
        return rows

    def _check_code(self, cell: Cell, sent: Packed) -> None:
        """No row under a digest that is not that of the code which replied."""
        # one that does not load here, where it does on the machine that asks, is other code too
        told = sent.code_digest or self.run.engine != "local"
        if sent.code_digest == cell.code_digest or not (cell.code_digest and told):
            return
        found = (
            f"is {sent.code_digest} now" if sent.code_digest else f"does not load: {sent.texts[1]}"
        )
        raise RunError(
            f"the code of {cell.solver} is not what was asked: its digest was {cell.code_digest} and "
            f"{found}; its files, its settings or its libraries' versions differ"
        )

    def _fallen(self, slot: Slot) -> list[Row]:
        """A worker has ended: the row of the order that it was at; the others wait again."""
        order = slot.running()
        loading = slot.clock.read().phase in (Phase.PREPARING, Phase.WARMING_UP)
        code, words, doom = slot.exit_code(), slot.words.take(), slot.doom
        if order is not None and slot.answered_among_others(order):
            self._together = 1  # as above
            self._empty(slot)
            return []
        astray = order is not None and doom is not None and doom.order != order.number
        self._empty(slot, None if astray else order)
        if order is None:
            self._strike(code, words)
        if order is None or astray:
            return []  # killed for what another order did: this one is asked again
        self._false_starts = 0
        task = self._tasks.take(order.number)
        reply = crashed(code, words) if doom is None else doom.reply
        if not loading:
            return self._rows(task, reply)
        failed = self._loading.failed(task.cell, order.warm_up, reply)
        if failed is None:
            self._tasks.waiting.appendleft(task)
            return []
        return self._rows(task, failed)

    def _empty(self, slot: Slot, order: Order | None = None) -> None:
        """Throw a worker away; all its orders but one wait again."""
        left = slot.clear()
        self._ahead[slot] = 1
        self._tasks.take_back(one.number for one in left if one != order)

    def _strike(self, code: int | None, words: str) -> None:
        self._false_starts += 1
        if self._false_starts >= _FALSE_STARTS:
            raise RunError(
                f"worker processes end before they solve anything ({ending(code)[1]}"
                f"{': ' + words if words else ''}); the rows written so far are kept"
            )

    def _rows(self, task: Task, reply: Reply, started: str = "", versions: str = "") -> list[Row]:
        """The judged row of a task's cell; its chain goes on."""
        row, path = self._made(task.cell, task.initial_guess(), self.run, reply, started, versions)
        self._tasks.go_on(task, path)
        return [row]


def _fits(slot: Slot, kind: str, taken: bool) -> bool:
    """Whether a slot's worker may be asked cells of a kind; an idle one of another is replaced."""
    if slot.kind != kind and not (slot.pending or taken):
        slot.clear()
        slot.kind = kind
    return slot.kind == kind


def _read(sent: Packed) -> Reply:
    try:
        return unpacked(sent)
    except Exception as error:  # a worker sends what it is made to send
        return nothing(Outcome.RAISED, told(error))
