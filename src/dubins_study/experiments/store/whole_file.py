"""Files that are written whole or not at all, and that outlive a power cut."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path as FilePath

# What a killed run may leave behind: hidden files that are named after those of a results folder.
_TEMPORARY = re.compile(r"\.(?:manifest\.json|.+\.parquet)\.\d+\.tmp")


def write_whole(final: FilePath, write: Callable[[FilePath], object]) -> None:
    """Write a file under a temporary name, sync it, and put it in its place in one step.

    `write` writes the content to the path that it is given; a file at `final` is replaced. After an
    error nothing of the new file is left.
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
    if os.name == "nt":  # Windows has no such call
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def is_temporary(name: str) -> bool:
    """Whether a file is one that `write_whole` had not finished."""
    return _TEMPORARY.fullmatch(name) is not None


def remove_temporaries(folder: FilePath) -> None:
    """Remove the unfinished files of a killed run; only the holder of the folder's lock may."""
    for file in folder.iterdir():
        if is_temporary(file.name) and not file.is_dir():
            file.unlink(missing_ok=True)
