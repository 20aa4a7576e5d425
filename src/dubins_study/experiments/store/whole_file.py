"""Write files completely or not at all, and so that they survive a power failure."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path as FilePath

# Names of the temporary files that a killed run may leave.
_TEMPORARY = re.compile(r"\.(?:manifest\.json|.+\.parquet)\.\d+\.tmp")


def write_whole(final: FilePath, write: Callable[[FilePath], object]) -> None:
    """Write a file under a temporary name, sync it, and rename it to `final` in one step.

    `write` is called with a path and writes the content there. An existing file at `final` is
    replaced. After an error the temporary file is removed.
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
    """Make sure that the names in a folder survive a power failure."""
    if os.name == "nt":  # Windows cannot sync a folder
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def is_temporary(name: str) -> bool:
    """Whether a name is that of a temporary file of `write_whole`."""
    return _TEMPORARY.fullmatch(name) is not None


def remove_temporaries(folder: FilePath) -> None:
    """Remove the temporary files of a killed run. The caller must hold the folder's lock."""
    for file in folder.iterdir():
        if is_temporary(file.name) and not file.is_dir():
            file.unlink(missing_ok=True)
