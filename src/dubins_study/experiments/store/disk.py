"""Files that appear whole or not at all, and folders that lead nowhere else."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path as FilePath

from dubins_study.errors import DubinsStudyError

# what a killed run may leave behind: hidden, and named after a file of ours
_TEMPORARY = re.compile(r"\.(?:manifest\.json|.+\.parquet)\.\d+\.tmp")


class StoreError(DubinsStudyError, ValueError):
    """A results folder that cannot be read or written; the message says which and why."""


def reason(error: OSError) -> str:
    """What went wrong, in the system's words or in those of the library that hid them."""
    if error.errno is not None:
        return os.strerror(error.errno)
    return error.strerror or str(error).partition("\n")[0] or type(error).__name__


def put(final: FilePath, write: Callable[[FilePath], None]) -> None:
    """Put a file in its place in one step, once it is safe on the disk.

    Args:
        final: its place; what is there is replaced.
        write: writes the content to the path that it is given.

    Raises:
        OSError: if it cannot be written; nothing is left of it then.
    """
    temporary = final.with_name(f".{final.name}.{os.getpid()}.tmp")
    try:
        write(temporary)
        with temporary.open("rb") as stream:
            os.fsync(stream.fileno())
        temporary.replace(final)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    sync_folder(final.parent)


def sync_folder(folder: FilePath) -> None:
    """Make sure that the names in a folder outlive a power cut."""
    if os.name == "nt":  # which has no such call
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def is_temporary(name: str) -> bool:
    """Whether a file is one that `put` was writing."""
    return _TEMPORARY.fullmatch(name) is not None


def tidy(folder: FilePath) -> None:
    """Remove what a killed run left half-written; only the holder of the folder's lock may."""
    for file in folder.iterdir():
        if is_temporary(file.name) and not file.is_dir():
            file.unlink(missing_ok=True)


def refuse_link(place: FilePath) -> None:
    """Refuse a place of a results folder that leads somewhere else.

    Raises:
        StoreError: if it is a link: what strangers' folders name is not read, let alone written.
    """
    try:
        link = place.is_symlink()
    except OSError as error:  # a name that is too long
        raise StoreError(f"{place} cannot be read: {reason(error)}") from None
    if link:
        raise StoreError(
            f"{place} is a link; expected a file or folder of its own, since nothing outside a "
            "results folder is read or written: put a copy in its place"
        )
