"""One run at a time in a results folder."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath

from filelock import FileLock, Timeout

from dubins_study.experiments.provenance import now
from dubins_study.experiments.store.disk import StoreError, reason

LOCK = ".lock"
# a link leads elsewhere, and a pipe would be waited for
_LOOKING = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
# another's look at whether it is held lasts microseconds; a run holds it much longer
_PATIENCE, _POLL = 0.3, 0.02


@contextmanager
def locked(folder: FilePath) -> Iterator[None]:
    """Hold a folder for this process alone; the system lets go of it whatever ends the process.

    Processes that this one starts do not hold it.

    Raises:
        StoreError: if another process holds it, naming that and since when, or if the folder
            cannot be written.
    """
    file = folder / LOCK
    if file.exists() and not file.is_file():
        raise StoreError(f"cannot lock {file}: it is no file")
    lock = FileLock(file, timeout=_PATIENCE, poll_interval=_POLL, fallback_to_soft=False)
    try:
        lock.acquire()
    except Timeout:
        raise StoreError(_refusal(folder)) from None
    except OSError as error:
        raise StoreError(f"cannot lock {file}: {reason(error)}") from None
    try:
        with suppress(OSError):  # a full disk: others are told less
            file.write_text(json.dumps({"pid": os.getpid(), "started": now()}), encoding="utf-8")
        yield
    finally:
        lock.release()


def _refusal(folder: FilePath) -> str:
    who = holder(folder)
    pid, since = (str(who.get(key, "unknown")) for key in ("pid", "started"))
    return (
        f"{folder} is in use: process {pid:.20} has been at work there since {since:.40}; wait for "
        "it or end it, or choose another --out"
    )


def holder(folder: FilePath) -> dict[str, object]:
    """What the process that holds a folder, or held it last, says of itself."""
    try:
        found = json.loads((folder / LOCK).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def held(folder: FilePath) -> bool:
    """Whether a process is at work in a folder; nothing is written to find out."""
    try:
        handle = os.open(folder / LOCK, _LOOKING)
    except OSError:
        return False
    try:
        return _held(handle)
    finally:
        os.close(handle)


def _held(handle: int) -> bool:
    try:
        import fcntl
    except ImportError:  # Windows: reading a byte that another process has locked is refused
        try:
            os.read(handle, 1)
        except OSError:
            return True
        return False
    try:
        # shared, so that two who look do not see each other
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return True
    return False
