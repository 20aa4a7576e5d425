"""The memory that a process and its descendants hold."""

from __future__ import annotations

from contextlib import suppress

import psutil


def held_bytes(pid: int, limit: float, *, with_children: bool) -> int:
    """Bytes that a process holds, with its descendants if asked for; 0 if it is gone.

    What several share is counted once where the sum is above the limit (Linux), which is slower.
    """
    try:
        process = psutil.Process(pid)
        family = [process, *process.children(recursive=True)] if with_children else [process]
    except psutil.Error:
        return 0
    held = _sum_bytes(family, "memory_info", "rss")
    if with_children and held > limit:
        held = _sum_bytes(family, "memory_full_info", "pss")
    return held


def _sum_bytes(family: list[psutil.Process], reading: str, column: str) -> int:
    total = 0
    for process in family:
        with suppress(psutil.Error):
            memory = getattr(process, reading)()
            total += getattr(memory, column, memory.rss)
    return total
