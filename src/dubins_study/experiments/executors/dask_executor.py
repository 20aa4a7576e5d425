"""Solve a run's cells on a Dask cluster.

Work units are sent; judged rows come back.
"""

from __future__ import annotations

import logging
import pickle
from collections import deque
from collections.abc import Generator, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from time import sleep
from typing import Any

from dubins_study.asking.reply import exception_text
from dubins_study.experiments.executors.dask_worker import UnitReply, in_worker
from dubins_study.experiments.executors.executor import Executor, Probed, WorkUnit
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.plan.cells import Chain
from dubins_study.study.rows.parts import Row, row_key

_LOG = logging.getLogger(__name__)
# Dask's loggers. They are silenced, because they repeat what the exceptions say.
_LOGGERS = ("distributed", "tornado", "asyncio")

# Cells per unit: quick ones fill the second after which a worker returns a unit, slow ones do not
# travel back and forth in vain.
_MAX_CELLS = 256
# Near the end of a run, the cells that are left for a thread are sent in four parts, so that all
# threads finish at about the same time.
_PARTS_PER_THREAD = 4
# Units sent per thread: the one that is being solved, and the next.
_UNITS_PER_THREAD = 2
# Retries of a unit that raised an exception. Dask itself counts workers that die
# (`allowed-failures`).
_RETRIES = 1
# Seconds between two looks for replies; each yields, so that the caller can write rows.
_POLL_INTERVAL_S = 0.1
# Seconds to wait for a result.
_FETCH_WAIT_S = 30.0
# Seconds to wait for an answer of the scheduler or of every worker.
_ANSWER_WAIT_S = 10.0
_LOST = "the connection to the Dask scheduler is lost"


@contextmanager
def dask_executor(scheduler: str) -> Iterator[Executor]:
    """Yield an executor with a Dask scheduler's workers."""
    try:
        import distributed
    except ImportError as error:
        raise RunError(
            f"executor 'dask' needs Dask: pip install 'dubins-study[dask]' ({error})"
        ) from None
    with ExitStack() as stack:
        for name in _LOGGERS:  # the stack restores their levels at the end
            logger = logging.getLogger(name)
            stack.callback(logger.setLevel, logger.level)
            logger.setLevel(logging.CRITICAL + 1)
        try:  # Dask warns where versions of Python or of its packages differ
            client = distributed.Client(scheduler, timeout=_ANSWER_WAIT_S, set_as_default=False)
        except Exception as error:  # any lower layer: names, sockets, certificates, protocols
            raise RunError(
                f"no Dask scheduler answers at {scheduler!r} ({exception_text(error)}); expected "
                "an address such as tcp://127.0.0.1:8786, or tls://... and certificates (see "
                "docs/scaling.md)"
            ) from None
        stack.callback(_close, client)
        threads = client.nthreads()

        def solve(
            unit: WorkUnit, stop: Interruption, probed: Probed
        ) -> Generator[list[Row], None, None]:
            with closing(_Submission(client, unit, probed)) as submission:
                yield from submission.solve(stop)

        run_entry = {"workers": len(threads), "distributed": str(distributed.__version__)}
        yield Executor(max(1, sum(threads.values())), run_entry, solve)


def _close(client: Any) -> None:
    with suppress(Exception):
        client.close(timeout=_ANSWER_WAIT_S)


class _Submission:
    """The cells of one run on a cluster.

    Cells wait here until they are sent to the cluster, in units.
    """

    def __init__(self, client: Any, unit: WorkUnit, probed: Probed):
        self._client = client
        self._settings = unit.settings
        self._probed = probed
        self._waiting: deque[Chain] = deque(unit.chains)
        self._units: dict[Any, WorkUnit] = {}  # by Dask's future
        self._threads = 0
        self._warned = False
        # A machine's name -> its number, in the order of first probes; names are not recorded.
        self._machines: dict[str, int] = {}

    def solve(self, stop: Interruption) -> Iterator[list[Row]]:
        """Yield the rows of all cells as they come.

        A list has the rows of one unit; it is empty if no unit has ended for a moment.
        """
        stopping = False
        while self._waiting or self._units:
            if stop.requested and not stopping:  # workers finish the cells that they are solving
                stopping = True
                self._waiting.clear()
                self._call_workers("stop_run")
            self._count_threads()
            if stopping and not self._threads:
                return
            self._submit()
            ended = [future for future in self._units if future.done()]
            if not ended:
                sleep(_POLL_INTERVAL_S)
                yield []
            for future in ended:
                reply = self._reply(future)
                if reply is None:
                    # not fetched in time: asked for again, as the unit stays in `_units`
                    continue
                unit = self._units.pop(future)
                number = self._machines.setdefault(reply.machine, len(self._machines) + 1)
                for seconds in reply.probes_s:
                    self._probed(seconds, number)
                rows: list[Row] = reply.rows.to_pylist()
                yield rows
                if reply.refusal:
                    raise RunError(reply.refusal)
                if not (stopping or stop.requested):
                    # the cells that the worker has not solved come first again
                    unsolved = unit.remaining({row_key(row) for row in rows})
                    self._waiting.extendleft(reversed(unsolved.chains))

    def _count_threads(self) -> None:
        """Update the number of worker threads.

        A lost connection raises RunError. If there are no threads, a warning is logged once.
        """
        if self._client.status not in ("running", "connecting"):
            raise RunError(_LOST)
        with suppress(OSError, TimeoutError):  # perhaps lost for a moment: count again later
            self._threads = sum(self._client.nthreads().values())
        if self._threads == 0 and not self._warned:
            self._warned = True
            _LOG.warning("dubins-study: the Dask scheduler has no workers; waiting for the first")

    def _submit(self) -> None:
        """Send units until there are `_UNITS_PER_THREAD` for every thread."""
        function = in_worker("solve_unit")
        threads = max(1, self._threads)
        while self._waiting and len(self._units) < _UNITS_PER_THREAD * threads:
            share = sum(map(len, self._waiting)) // (_PARTS_PER_THREAD * threads)
            cells = max(1, min(_MAX_CELLS, share))
            chains: list[Chain] = []
            while self._waiting and cells > 0:
                chains.append(self._waiting.popleft())
                cells -= len(chains[-1])
            unit = WorkUnit(self._settings, chains)
            future = self._client.submit(function, pickle.dumps(unit), pure=False, retries=_RETRIES)
            self._units[future] = unit

    def _reply(self, future: Any) -> UnitReply | None:
        """A worker's reply, or None if the fetch timed out.

        A fetch times out if the worker has died with the reply, among other things. Dask then has
        another worker solve the unit. All other errors raise RunError.
        """
        if future.status == "cancelled":
            raise RunError(_LOST)
        try:
            reply: UnitReply = future.result(timeout=_FETCH_WAIT_S)
        except TimeoutError:
            return None
        except Exception as error:  # any error of Dask, in this process or in a worker
            raise RunError(_explanation(error)) from None
        return reply

    def _call_workers(self, name: str) -> None:
        """Call a function in every worker that answers.

        The function is of `dask_worker` and takes the run's id.
        """
        with suppress(Exception):  # workers that are ending, or that lack this package
            self._client.run(
                in_worker(name),
                self._settings.run_id,
                on_error="ignore",
                callback_timeout=_ANSWER_WAIT_S,
            )

    def close(self) -> None:
        """Stop all solves of this run on the cluster."""
        if self._units:
            with suppress(Exception):
                self._client.cancel([*self._units])
            self._units.clear()
        self._call_workers("end_run")


def _explanation(error: Exception) -> str:
    """A message about an error that Dask has raised."""
    cause = error.__cause__
    if not isinstance(cause, Exception):
        cause = error
    message = exception_text(cause)
    if isinstance(error, ImportError | AttributeError) or "deserializ" in str(error):
        return (
            f"dubins-study is not on a Dask worker, or of another version ({message}); expected "
            "the same versions of it, of Python and of Dask there as here"
        )
    return f"a Dask worker failed: {message}"
