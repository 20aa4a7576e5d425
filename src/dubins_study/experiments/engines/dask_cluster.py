"""The process that a Dask cluster of this machine lives in; see `experiments.engines.dask_host`."""

from __future__ import annotations

import json
import sys

LOOPBACK = "127.0.0.1"


def main() -> None:
    """Be the cluster until standard input ends."""
    import dask
    from distributed import LocalCluster

    workers, scratch = json.loads(sys.stdin.readline())
    # a worker's solvers are processes of its own, and get the environment that they always get
    settings = {"distributed.worker.daemon": False, "distributed.nanny.pre-spawn-environ": {}}
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host=LOOPBACK,
            dashboard_address=f"{LOOPBACK}:0",
            memory_limit=0,  # a solver's memory is bounded by its supervisor
            local_directory=scratch,
        ) as cluster,
    ):
        print(json.dumps([cluster.scheduler_address, cluster.dashboard_link]), flush=True)
        sys.stdin.read()
