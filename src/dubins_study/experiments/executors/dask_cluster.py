"""A client of a Dask scheduler: at a given address, or in a cluster on this machine.

The cluster on this machine is Dask's LocalCluster in a separate process. In the caller's process
it would import the caller's main module again in every worker, change the environment, and end its
workers at Ctrl-C. The separate process leads its own session and ends when the caller ends, because
its standard input closes then.
"""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.pool import RunError
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
    """A client of a scheduler whose versions of Python and Dask, and its workers', are ours."""
    from distributed import Client

    try:
        # Check the address first: a Client without a scheduler tries for twenty seconds and prints.
        # The check runs in its own thread, since the caller's may already run an event loop.
        with ThreadPoolExecutor(1) as thread:
            kind = thread.submit(asyncio.run, _kind(address)).result()
        if kind != "Scheduler":
            raise ValueError(f"it is a {kind}")
        client = Client(address, timeout=_ANSWER_WAIT_S, set_as_default=False)
    except Exception as error:  # any lower layer: names, sockets, certificates, protocols
        cause: BaseException = error
        while cause.__cause__ is not None and str(cause.__cause__):
            cause = cause.__cause__  # only the lowest layer names the problem
        text = exception_text(cause) if str(cause) else f"nothing came within {_ANSWER_WAIT_S:g} s"
        raise RunError(
            f"no Dask scheduler answers at {address!r} ({text}); expected an address such "
            "as tcp://127.0.0.1:8786, or tls://... and certificates (see docs/scaling.md)"
        ) from None
    try:
        problem = mismatch(client.get_versions())
        if problem:
            raise RunError(problem)
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=_ANSWER_WAIT_S)


async def _kind(address: str) -> str:
    """The type of Dask node at an address."""
    from distributed.core import rpc
    from distributed.security import Security

    certificates = Security().get_connection_args("client")
    node = rpc(address, timeout=_ANSWER_WAIT_S, connection_args=certificates)
    async with asyncio.timeout(_ANSWER_WAIT_S + 1), node:
        return str((await node.identity())["type"])


def mismatch(versions: Mapping[str, Any]) -> str | None:
    """The difference in Python's or Dask's version between a cluster and this machine, or None.

    The last digit of Python's version does not matter, which it does to Dask's own comparison.
    """
    expected = _release(versions["client"])
    nodes = {"the Dask scheduler": versions["scheduler"]}
    nodes |= {f"the Dask worker {name}": node for name, node in versions["workers"].items()}
    for name, node in nodes.items():
        for what, version in _release(node).items() if node else ():
            if version != expected[what]:
                return f"{name} has {what} {version}; expected {expected[what]}, as here"
    return None


def _release(node: Mapping[str, Any]) -> dict[str, str]:
    packages = node["packages"]
    python = ".".join(str(packages["python"]).split(".")[:2])
    return {"Python": python, "distributed": str(packages["distributed"])}
