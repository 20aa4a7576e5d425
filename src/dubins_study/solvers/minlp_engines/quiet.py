"""Silence for libraries that write to the descriptors 1 and 2 themselves."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from threading import Lock

_descriptors = Lock()  # of two threads, each would save what the other has set


@contextmanager
def silent(*descriptors: int) -> Iterator[None]:
    """Send these descriptors (1 for output, 2 for errors) to nowhere inside the `with` block.

    What other threads write there in the meantime is lost as well.
    """
    with _descriptors, ExitStack() as restored:
        for descriptor in descriptors:
            with suppress(OSError):  # it may be closed
                saved = os.dup(descriptor)
                restored.callback(os.close, saved)
                restored.callback(os.dup2, saved, descriptor)
                with Path(os.devnull).open("wb") as nowhere:
                    os.dup2(nowhere.fileno(), descriptor)
        yield
