"""Cells solved in worker processes that are watched, killed and replaced, judged here."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from functools import cache
from itertools import count
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any, NamedTuple

from pebble import ProcessExpired

from experiments import processes
from experiments.clock import Phase
from experiments.endings import again, crashed, ending
from experiments.grid import Cell, Chain, given_start
from experiments.interruption import Interruption
from experiments.judging import Run, row_of
from experiments.rows import Row
from experiments.slot import PROBE, Batch, Slot
from experiments.watch import Bounds, Watch
from experiments.wire import Packed, unpacked
from experiments.worker import Order
from solvers.answer import Reply, nothing, told
from solvers.protocol import Outcome
from solvers.registry import ours
from study.path import Path
from study.schema import Key

# Orders put to a worker in advance, so that it never waits, and how many of them travel in one
# message, each of which costs as much as judging a cell. One where solves are long, so that none
# waits behind them for a worker while another one is idle.
_AHEAD, _TOGETHER, _QUICK = 32, 16, 0.005
# s without news after which whoever writes the rows is given a turn
_TURN = 0.2
# s between two looks at how fast the machine is
_PROBE_EVERY = 2.0
# workers that may end in a row before they have taken up any order
_FALSE_STARTS = 3


# how pebble tells that a worker has ended
_ENDED = (ProcessExpired, BrokenProcessPool)


class RunError(RuntimeError):
    """A run that could not go on; what was done is kept."""


class _Task(NamedTuple):
    """Where a chain of cells has got to, and the last path found on the way."""

    chain: Chain
    place: int
    path: Path | None

    @property
    def cell(self) -> Cell:
        return self.chain[self.place]

    def start(self) -> Path | None:
        return self.path if self.cell.start == "warm" else given_start(self.cell)


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
        run: Run,
        bounds: Bounds,
        jobs: int,
        probed: Callable[[float], None] | None = None,
        made: Callable[..., tuple[Any, Path | None]] = row_of,
        warm_up: bool = True,
    ):
        self.run, self.bounds, self._probed, self._made = run, bounds, probed, made
        self._warm_up = warm_up
        self._next_probe = monotonic()
        self._ended: SimpleQueue[tuple[Slot, Batch, Future[Any]]] = SimpleQueue()
        self._slots = [Slot(bounds.memory, self._told) for _ in range(jobs)]
        self._watch = Watch(self._slots, bounds)
        self._numbers = count()
        self._tasks: dict[int, _Task] = {}
        self._waiting: deque[_Task] = deque()
        # solvers whose warm-up ended a worker: loaded without it from then on; and those that end
        # every worker while they are loaded, with the reply that stands for all their cells
        self._cold: set[tuple[str, str]] = set()
        self._hopeless: dict[tuple[str, str], Reply] = {}
        self._answered: set[tuple[str, str]] = set()
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
        # ours first, then each plug-in by itself: workers are not shared between these
        apart = sorted(chains, key=lambda chain: _kind(chain[0]))
        self._waiting = deque(_Task(chain, 0, before.get(chain[0].key)) for chain in apart)
        while True:
            if stop.asked:
                self._finish_up()
            if not (self._waiting or self._tasks):
                return
            yield from self._feed()
            yield self._news()

    def _finish_up(self) -> None:
        """Forget every order that no worker is at, those of a batch that it is at excepted."""
        self._waiting.clear()
        for slot in self._slots:
            running, first = slot.running(), (*slot.batches, PROBE)[0]
            # between two orders of a batch a worker is at none
            begun = len(first) > 1 or (running is not None and running.number in first)
            for number in slot.pending.keys() - (first if begun else PROBE):
                del slot.pending[number], self._tasks[number]

    def _feed(self) -> Iterator[list[Row]]:
        for slot in self._slots:
            orders: list[Order] = []
            share = min(self._ahead[slot], -(-len(self._waiting) // len(self._slots)))
            while self._waiting and len(slot.pending) + len(orders) < share:
                if not self._fits(slot, self._waiting[0].cell, bool(orders)):
                    break
                task = self._waiting.popleft()
                solver = task.cell.solver, task.cell.profile
                if solver in self._hopeless:
                    yield self._rows(task, again(self._hopeless[solver]))
                    continue
                number = next(self._numbers)
                self._tasks[number] = task
                orders.append(self._order(number, task, warm_up=solver not in self._cold))
            together = self._together  # which may change on the way
            for first in range(0, len(orders), together):
                try:
                    slot.put(orders[first : first + together])
                except RuntimeError:  # what came from the worker made no sense to pebble
                    yield self._fallen(slot)
        if self._probed is not None and monotonic() > self._next_probe:
            self._next_probe = monotonic() + _PROBE_EVERY
            self._slots[0].measure()

    def _fits(self, slot: Slot, cell: Cell, taken: bool) -> bool:
        """Whether a slot's worker may be asked a cell; an idle one of another kind is replaced.

        A plug-in may have changed any module of its process, which nothing puts back.
        """
        kind = _kind(cell)
        if slot.kind != kind and not (slot.pending or taken):
            slot.clear()
            slot.kind = kind
        return slot.kind == kind

    def _order(self, number: int, task: _Task, warm_up: bool) -> Order:
        cell = task.cell
        return Order(
            number,
            cell.solver,
            cell.profile,
            cell.scenario,
            cell.branch,
            task.start(),
            self.bounds.limit,
            warm_up and self._warm_up,
        )

    def _news(self) -> list[Row]:
        if self._watch.failure is not None:
            raise RunError(
                f"the watch over the workers has ended ({told(self._watch.failure)}), and no limit "
                "would hold; the rows written so far are kept"
            )
        try:
            slot, batch, future = self._ended.get(timeout=_TURN)
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
            tasks = [self._tasks.pop(order.number) for order in slot.take(batch)]
            if len(tasks) == 1:
                return self._rows(tasks[0], nothing(Outcome.RAISED, told(error or OSError())))
            self._together = 1  # which of them it was, is seen when they are asked alone
            self._waiting.extendleft(reversed(tasks))
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
                task = self._tasks.pop(number)
                self._check_code(task.cell, sent)
                self._answered.add((task.cell.solver, task.cell.profile))
                rows += self._rows(task, _read(sent), sent.started, sent.versions)
        # a worker that is worn, or slow, leaves the rest of its batch
        self._waiting.extendleft(self._tasks.pop(number) for number in sorted(left, reverse=True))
        if replies[-1].worn:
            self._empty(slot)
        return rows

    def _check_code(self, cell: Cell, sent: Packed) -> None:
        """No row under a digest that is not that of the code which replied."""
        # one that does not load here, where it does on the machine that asks, is other code too
        told = sent.code or self.run.engine != "local"
        if sent.code == cell.code or not (cell.code and told):
            return
        found = f"is {sent.code} now" if sent.code else f"does not load: {sent.texts[1]}"
        raise RunError(
            f"the code of {cell.solver} is not what was asked: its digest was {cell.code} and "
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
        task = self._tasks.pop(order.number)
        reply = crashed(code, words) if doom is None else doom.reply
        if loading and order.warm_up:
            self._cold.add((order.solver, order.profile))
            self._waiting.appendleft(task)
            return []
        if loading:
            message, status = reply.solution.message, reply.solution.native_status
            reply = nothing(reply.outcome, f"{message}, while it was loaded", status=status)
            if (order.solver, order.profile) not in self._answered:
                self._hopeless[order.solver, order.profile] = reply
        return self._rows(task, reply)

    def _empty(self, slot: Slot, order: Order | None = None) -> None:
        """Throw a worker away; all its orders but one wait again."""
        left = slot.clear()
        self._ahead[slot] = 1
        others = [self._tasks.pop(one.number) for one in left if one != order]
        self._waiting.extendleft(reversed(others))

    def _strike(self, code: int | None, words: str) -> None:
        self._false_starts += 1
        if self._false_starts >= _FALSE_STARTS:
            raise RunError(
                f"worker processes end before they solve anything ({ending(code)[1]}"
                f"{': ' + words if words else ''}); the rows written so far are kept"
            )

    def _rows(self, task: _Task, reply: Reply, started: str = "", versions: str = "") -> list[Row]:
        """The judged row of a task's cell; its chain goes on."""
        row, path = self._made(task.cell, task.start(), self.run, reply, started, versions)
        if task.place + 1 < len(task.chain):
            # after a failure the last path that was found serves on
            self._waiting.appendleft(_Task(task.chain, task.place + 1, path or task.path))
        return [row]


@cache
def _spec_kind(spec: str) -> str:
    return "" if ours(spec) else spec


def _kind(cell: Cell) -> str:
    """Cells of one kind share workers: all of our own solvers do, a plug-in's have their own."""
    return _spec_kind(cell.solver)


def _read(sent: Packed) -> Reply:
    try:
        return unpacked(sent)
    except Exception as error:  # a worker sends what it is made to send
        return nothing(Outcome.RAISED, told(error))
