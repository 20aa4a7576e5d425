"""The settings of one run: its id, its limits, and the executor that solves the cells."""

from __future__ import annotations

from typing import NamedTuple

BYTES_PER_GIB = 2**30
# The executors that can solve cells: worker processes of this machine, or a Dask cluster.
EXECUTOR_NAMES = ("local", "dask")


class RunSettings(NamedTuple):
    """The settings of one run, the same for all its cells and rows."""

    run_id: str
    time_limit_s: float  # of one solve
    memory_limit_bytes: int = 4 * BYTES_PER_GIB  # of a worker process and its children
    jobs: int = 1  # cells that are solved at the same time
    executor: str = "local"  # one of `EXECUTOR_NAMES`
    seed: int = 0  # of the random order of the cells

    @property
    def memory_limit_gib(self) -> float:
        """The memory limit in GiB."""
        return self.memory_limit_bytes / BYTES_PER_GIB
