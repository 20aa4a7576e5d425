"""The settings of one run: its id, its limits, and the executor that solves the cells."""

from __future__ import annotations

from typing import NamedTuple

BYTES_PER_GIB = 2**30
# The executors that can solve cells: worker processes of this machine, or a Dask cluster.
EXECUTOR_NAMES = ("local", "dask")


class RunSettings(NamedTuple):
    """The settings of one run, the same for all its cells and rows.

    Args:
        run_id: identifies the run in its rows, its parts and the manifest.
        time_limit_s: seconds that one solve may take.
        memory_limit_bytes: bytes that a worker process and its children may hold.
        jobs: how many cells are solved at the same time.
        executor: one of `EXECUTOR_NAMES`.
        seed: seed of the random order of the cells.
    """

    run_id: str
    time_limit_s: float
    memory_limit_bytes: int = 4 * BYTES_PER_GIB
    jobs: int = 1
    executor: str = "local"
    seed: int = 0

    @property
    def memory_limit_gib(self) -> float:
        """The memory limit in GiB."""
        return self.memory_limit_bytes / BYTES_PER_GIB
