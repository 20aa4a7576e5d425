"""What a worker prints: read so that it never blocks, forgotten but for its last words."""

from __future__ import annotations

import os
import threading
from contextlib import suppress
from multiprocessing.connection import Connection, Pipe
from time import monotonic, sleep

_KEPT = 400  # bytes
_AT_ONCE = 2**16
_PATIENCE = 0.05  # s that the end of what was said is waited for


class LastWords:
    """A pipe for a worker's stdout and stderr; a thread reads it and keeps its end."""

    def __init__(self) -> None:
        self._reader, self.writer = Pipe(duplex=False)
        self._kept = b""
        threading.Thread(target=_read, args=(self, self._reader), daemon=True).start()

    def take(self) -> str:
        """What was said last, on one line; forgotten by this."""
        until = monotonic() + _PATIENCE
        with suppress(OSError):
            while self._reader.poll() and monotonic() < until:
                sleep(0.001)  # the thread has not got to the end yet
        sleep(0.001)
        kept, self._kept = self._kept, b""
        return " ".join(kept.decode("utf-8", "replace").split())[-_KEPT // 2 :]

    def close(self) -> None:
        """No worker will come any more: the thread ends with the last process that writes."""
        self.writer.close()


def _read(words: LastWords, reader: Connection) -> None:
    with reader, suppress(OSError):
        while said := os.read(reader.fileno(), _AT_ONCE):
            words._kept = (words._kept + said)[-_KEPT:]
