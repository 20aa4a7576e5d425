"""Dask's LocalCluster for one run, in a process of its own.

In the caller's process it would import the caller's main module again in every worker, change the
environment, and end its workers at Ctrl-C. Here it leads a session, and ends with its caller, whose
end closes the pipe to its standard input.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import NamedTuple

from dubins_study.experiments.isolation.pool import RunError

_START_WAIT_S, _EXIT_WAIT_S = 120.0, 5.0
_MAX_MESSAGE_CHARS = 500
# with the caller's search path; -P: no other folder is searched
_PROGRAM = (
    "import sys, json; sys.path[:] = json.loads(sys.stdin.readline()); "
    "from dubins_study.experiments.engines.dask_cluster import main; main()"
)
_LOOPBACK = "127.0.0.1"


class Cluster(NamedTuple):
    """The address of a cluster's scheduler, and of the page that shows its work."""

    address: str
    dashboard: str


@contextmanager
def local_cluster(workers: int) -> Iterator[Cluster]:
    """A scheduler and worker processes of one thread each, which listen on the loopback only.

    Raises:
        RunError: if they do not start.
    """
    with (
        tempfile.TemporaryDirectory(prefix="dubins-study-", ignore_cleanup_errors=True) as scratch,
        tempfile.TemporaryFile("w+", errors="replace") as output,
        subprocess.Popen(
            [sys.executable, "-P", "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=output,
            text=True,
            start_new_session=True,
        ) as process,
    ):
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            with suppress(BrokenPipeError):  # its output says why it has ended
                print(json.dumps(sys.path), file=process.stdin)
                print(json.dumps([workers, scratch]), file=process.stdin, flush=True)
            patience = threading.Timer(_START_WAIT_S, process.kill)
            patience.start()
            line = process.stdout.readline()
            patience.cancel()
            if not line:
                output.seek(0)
                problem = output.read()[-_MAX_MESSAGE_CHARS:].strip()
                raise RunError(f"Dask's cluster on this machine did not start: {problem}")
            yield Cluster(*json.loads(line))
        finally:
            with suppress(OSError):
                process.stdin.close()
            with suppress(subprocess.TimeoutExpired):
                process.wait(_EXIT_WAIT_S)
            with suppress(ProcessLookupError):  # whatever is left of its session
                os.killpg(process.pid, signal.SIGKILL)


def main() -> None:
    """Be the cluster until standard input ends."""
    import dask
    from distributed import LocalCluster

    workers, scratch = json.loads(sys.stdin.readline())
    # solvers get the environment that they always get
    settings = {"distributed.worker.daemon": False, "distributed.nanny.pre-spawn-environ": {}}
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host=_LOOPBACK,
            dashboard_address=f"{_LOOPBACK}:0",
            memory_limit=0,  # the pool bounds a solver's memory
            local_directory=scratch,
        ) as cluster,
    ):
        print(json.dumps([cluster.scheduler_address, cluster.dashboard_link]), flush=True)
        sys.stdin.read()
