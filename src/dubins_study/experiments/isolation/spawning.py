"""How worker processes are started: forked from a small server, and told apart."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import active_children, forkserver, resource_tracker
from multiprocessing.context import ForkServerContext, ForkServerProcess
from multiprocessing.popen_forkserver import Popen
from types import ModuleType
from typing import Any

import psutil

from dubins_study.experiments.isolation import processes

_main = threading.Lock()
# every process that was ever started here
_born: set[int] = set()


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


def _start_tracker() -> None:
    """Start multiprocessing's keeper of semaphores, and have it tidy up in silence.

    It warns of whatever a process that was killed has left, and workers are killed on purpose.
    """
    kept = os.environ.get("PYTHONWARNINGS")
    ours = "ignore::UserWarning:multiprocessing.resource_tracker"
    os.environ["PYTHONWARNINGS"] = f"{kept},{ours}" if kept else ours
    try:
        resource_tracker.ensure_running()
    finally:
        if kept is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = kept


class _Popen(Popen):
    """An exit code comes down a pipe once: two threads that ask at the same time would lose it."""

    def __init__(self, process: Any):
        self._asking = threading.Lock()
        with _main_hidden():
            super().__init__(process)
            _born.add(self.pid)

    def poll(self, flag: int = os.WNOHANG) -> int | None:
        with self._asking:
            return super().poll(flag)


class _Process(ForkServerProcess):
    @staticmethod
    def _Popen(process_obj: Any) -> Popen:  # noqa: N802
        return _Popen(process_obj)


class _Nobody:
    """Stands where pebble wants a new worker in a pool whose worker has ended: none is started.

    Such a pool is thrown away, and what the clock says of its worker is still to be read.
    """

    pid = exitcode = None
    daemon = False

    def __init__(self) -> None:
        self._wanted = True

    def start(self) -> None:
        """There is nothing to start."""

    def is_alive(self) -> bool:
        return self._wanted

    def terminate(self) -> None:
        self._wanted = False

    def join(self, timeout: float | None = None) -> None:
        """There is nothing to wait for."""


class Context(ForkServerContext):
    """Workers fork from a server that has our modules loaded, and no solver and no thread.

    A plain fork would carry over the parent's threads; a spawn takes a second every time.
    A context is for one worker, `worker` once it is there.
    """

    def __init__(self) -> None:
        super().__init__()
        _start_tracker()
        self.set_forkserver_preload(
            [
                "dubins_study.experiments.isolation.worker",
                "dubins_study.experiments.isolation.nursery",
            ]
        )
        self.worker: ForkServerProcess | None = None

    def Process(self, *args: Any, **options: Any) -> Any:  # type: ignore[override]  # noqa: N802
        if self.worker is not None:
            return _Nobody()
        self.worker = _Process(*args, **options)
        return self.worker


def end_orphans() -> None:
    """End what workers that are gone have left behind: the server has taken it in (`nursery`)."""
    server = getattr(forkserver._forkserver, "_forkserver_pid", None)
    if server is None:
        return
    with _main, suppress(psutil.Error, OSError):
        ours = _born | {child.pid for child in active_children()}
        # a process of somebody else's that is just being started is in the server's session still
        session = os.getsid(server)
        orphans = [
            child.pid
            for child in psutil.Process(server).children()
            if child.pid not in ours and os.getsid(child.pid) != session
        ]
        for orphan in orphans:
            processes.end(orphan)
