"""Ctrl-C during a run: what is being solved is finished and kept; a second one stops at once."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Self


class Interruption:
    """While it is entered, a first SIGINT only sets `asked`; the next raises KeyboardInterrupt.

    A flag, since some libraries (casadi) turn a KeyboardInterrupt raised inside them into a
    warning and go on. Leaving raises KeyboardInterrupt if it was asked for meanwhile. Outside the
    main thread, where Python handles no signals, and where SIGINT is ignored, it does nothing.
    """

    def __init__(self) -> None:
        self.asked = False
        # a library may have swallowed the second one too: what it returned then is no answer
        self.at_once = False
        self._previous: Any = None

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            previous = signal.getsignal(signal.SIGINT)
            if previous not in (None, signal.SIG_IGN):
                self._previous = previous
                signal.signal(signal.SIGINT, self._handle)
                # within another, one that came just before counts as well
                outer = getattr(previous, "__self__", None)
                self.asked = self.asked or (isinstance(outer, Interruption) and outer.asked)
        return self

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.at_once = self.asked
        self.asked = True
        if self.at_once:
            raise KeyboardInterrupt

    def check(self) -> None:
        """Raise KeyboardInterrupt if it was asked for."""
        if self.asked:
            raise KeyboardInterrupt

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._previous is not None:
            signal.signal(signal.SIGINT, self._previous)
        if kind is None:
            self.check()
