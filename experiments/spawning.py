"""How worker processes are started: forked from a small server, and told apart."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.context import ForkServerContext, ForkServerProcess
from multiprocessing.popen_forkserver import Popen
from types import ModuleType
from typing import Any

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

    def poll(self, flag: int = os.WNOHANG) -> int | None:
        with self._asking:
            return super().poll(flag)


class _Process(ForkServerProcess):
    @staticmethod
    def _Popen(process_obj: Any) -> Popen:  # noqa: N802
        return _Popen(process_obj)


class Context(ForkServerContext):
    """Workers fork from a server that has our modules loaded, and no solver and no thread.

    A plain fork would carry over the parent's threads; a spawn takes a second every time.
    `started` are the processes of this context, the oldest first.
    """

    def __init__(self) -> None:
        super().__init__()
        _start_tracker()
        self.set_forkserver_preload(["experiments.worker"])
        self.started: list[ForkServerProcess] = []

    def Process(self, *args: Any, **options: Any) -> ForkServerProcess:  # type: ignore[override]  # noqa: N802
        process = _Process(*args, **options)
        self.started.append(process)
        return process
