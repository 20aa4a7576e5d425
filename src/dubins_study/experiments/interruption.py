"""Ctrl-C or SIGTERM in a run.

After the first the current solve ends; the second aborts it.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from types import FrameType
from typing import Any, Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Interruption:
    """Set `requested` at the first signal, then raise.

    In the `with` block the next signal raises KeyboardInterrupt.

    The signals are SIGINT (Ctrl-C) and SIGTERM, which a batch system sends before it kills.
    The first signal only sets a flag, because some libraries (casadi) turn a KeyboardInterrupt
    raised inside them into a warning and continue. If the flag is set, the end of the block raises
    KeyboardInterrupt. With `at_once` the first signal raises too. Nothing is handled outside the
    main thread, where Python handles no signals, nor for a signal that the process ignores.
    """

    def __init__(self, signals: Sequence[int] = _SIGNALS, *, at_once: bool = False) -> None:
        self._signals = signals
        self._at_once = at_once
        self.requested = False
        self._previous: dict[int, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is not threading.main_thread():
            return self
        for number in self._signals:
            previous = signal.getsignal(number)
            if previous not in (None, signal.SIG_IGN):
                self._previous[number] = previous
                signal.signal(number, self._handle)
                # In a nested block, a signal that the outer block has just received counts too.
                outer = getattr(previous, "__self__", None)
                if isinstance(outer, Interruption) and outer.requested:
                    self.requested = True
        return self

    def _handle(self, number: int, frame: FrameType | None) -> None:
        immediate = self.requested or self._at_once
        self.requested = True
        if immediate:
            raise KeyboardInterrupt

    def check(self) -> None:
        """Raise KeyboardInterrupt if an interruption was requested."""
        if self.requested:
            raise KeyboardInterrupt

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        for number, previous in self._previous.items():
            signal.signal(number, previous)
        if kind is None:
            self.check()
