"""The lock of a results folder: one run at a time."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath

from filelock import FileLock, Timeout

from dubins_study.experiments.provenance import now
from dubins_study.study.rows.parts import ResultsError, reason

LOCK = ".lock"
# Seconds to wait for the lock, since a call of `is_locked` in another process also holds it for
# microseconds. If the lock is still held after that, a run holds it.
_WAIT_S, _POLL_INTERVAL_S = 0.3, 0.02


@contextmanager
def locked(folder: FilePath) -> Iterator[None]:
    """Lock a folder for this process inside the `with` block.

    The operating system releases the lock when the process ends, also after a crash. Child
    processes do not hold the lock. If another process holds it, `ResultsError` names it.
    """
    file = folder / LOCK
    lock = FileLock(file, timeout=_WAIT_S, poll_interval=_POLL_INTERVAL_S, fallback_to_soft=False)
    try:
        lock.acquire()
    except Timeout:
        holder = lock_holder(folder)
        pid, since = (str(holder.get(key, "unknown")) for key in ("pid", "started"))
        raise ResultsError(
            f"{folder} is in use: process {pid:.20} has been at work there since {since:.40}; wait "
            "for it or end it, or choose another --out"
        ) from None
    except OSError as error:
        raise ResultsError(f"cannot lock {file}: {reason(error)}") from None
    try:
        with suppress(OSError):  # on a full disk, messages name the process "unknown"
            file.write_text(json.dumps({"pid": os.getpid(), "started": now()}), encoding="utf-8")
        yield
    finally:
        lock.release()


def lock_holder(folder: FilePath) -> dict[str, object]:
    """`pid` and `started` of the last process that locked a folder; empty if not recorded."""
    try:
        content = json.loads((folder / LOCK).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def is_locked(folder: FilePath) -> bool:
    """Whether a run holds the lock of a folder; the check writes nothing."""
    try:
        handle = os.open(folder / LOCK, os.O_RDONLY)
    except OSError:
        return False
    try:
        # a shared lock: two concurrent calls must not report each other
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(handle)
    return False
