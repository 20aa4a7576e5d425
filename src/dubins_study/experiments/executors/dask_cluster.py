"""A client of a Dask scheduler: at a given address, or in a cluster on this machine.

The cluster on this machine is Dask's LocalCluster in a separate process. In the caller's process
it would import the caller's main module again in every worker, change the environment, and end its
workers at Ctrl-C. The separate process leads its own session and ends when the caller ends, because
its standard input closes then.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.isolation.process_state import ONE_THREAD
from dubins_study.solvers.reply import exception_text

# Seconds to wait for the scheduler's answer, and for the end of the local cluster.
_ANSWER_WAIT_S, _EXIT_WAIT_S = 10.0, 5.0
_MAX_MESSAGE_CHARS = 500
_LOOPBACK = "127.0.0.1"
# The program of the cluster's process. It gets the caller's search path; -P adds no other folder.
_PROGRAM = (
    "import sys, json; sys.path[:] = json.loads(sys.stdin.readline()); "
    "from dubins_study.experiments.executors.dask_cluster import main; main()"
)
_SETTINGS = {
    "distributed.worker.daemon": False,
    # Dask must not change the environment of the solvers.
    "distributed.nanny.pre-spawn-environ": {},
    # Dask must not give up a worker that dies again while it restarts.
    "distributed.deploy.lost-worker-timeout": "1 day",
}


class Cluster(NamedTuple):
    """The address of a cluster's scheduler, and of the page that shows its work."""

    address: str
    dashboard: str


@contextmanager
def local_cluster(workers: int) -> Iterator[Cluster]:
    """A scheduler and worker processes of one thread each, which listen on the loopback only."""
    with (
        tempfile.TemporaryDirectory(prefix="dubins-study-", ignore_cleanup_errors=True) as scratch,
        tempfile.TemporaryFile("w+", errors="replace") as output,
        subprocess.Popen(
            [sys.executable, "-P", "-c", _PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=output,
            text=True,
            env=os.environ | ONE_THREAD,
            start_new_session=True,
        ) as process,
    ):
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            with suppress(BrokenPipeError):  # the process has ended; its output says why
                print(json.dumps(sys.path), file=process.stdin)
                print(json.dumps([workers, scratch]), file=process.stdin, flush=True)
            line = process.stdout.readline()
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
            with suppress(ProcessLookupError):  # the session has no process left
                os.killpg(process.pid, signal.SIGKILL)


def main() -> None:
    """Be the cluster until standard input ends."""
    import dask
    from distributed import LocalCluster

    workers, scratch = json.loads(sys.stdin.readline())
    with (
        dask.config.set(_SETTINGS),
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


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """A client of a scheduler; Dask warns where versions of Python or of its packages differ."""
    from distributed import Client

    try:
        client = Client(address, timeout=_ANSWER_WAIT_S, set_as_default=False)
    except Exception as error:  # any lower layer: names, sockets, certificates, protocols
        raise RunError(
            f"no Dask scheduler answers at {address!r} ({exception_text(error)}); expected an "
            "address such as tcp://127.0.0.1:8786, or tls://... and certificates (see "
            "docs/scaling.md)"
        ) from None
    try:
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=_ANSWER_WAIT_S)
