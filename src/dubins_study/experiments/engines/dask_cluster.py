"""A connection to a Dask scheduler: that of an address, or of a cluster on this machine.

The cluster on this machine is Dask's LocalCluster in a process of its own. In the caller's process
it would import the caller's main module again in every worker, change the environment, and end its
workers at Ctrl-C. Here it leads a session, and ends when its standard input does: with its caller.
"""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from dubins_study.experiments.isolation.pool import RunError
from dubins_study.solvers.reply import exception_text

_ANSWER_WAIT_S, _EXIT_WAIT_S = 10.0, 5.0
_MAX_MESSAGE_CHARS = 500
_LOOPBACK = "127.0.0.1"
# with the caller's search path; -P: no other folder is searched
_PROGRAM = (
    "import sys, json; sys.path[:] = json.loads(sys.stdin.readline()); "
    "from dubins_study.experiments.engines.dask_cluster import main; main()"
)


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
            with suppress(ProcessLookupError):  # whatever is left of its session
                os.killpg(process.pid, signal.SIGKILL)


def main() -> None:
    """Be the cluster until standard input ends."""
    import dask
    from distributed import LocalCluster

    workers, scratch = json.loads(sys.stdin.readline())
    settings = {
        "distributed.worker.daemon": False,
        # solvers get the environment that they always get
        "distributed.nanny.pre-spawn-environ": {},
        # a worker that dies again while it is started anew must not be given up
        "distributed.deploy.lost-worker-timeout": "1 day",
    }
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


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """A client of a scheduler.

    Raises:
        RunError: if no scheduler answers, or one of other versions.
    """
    from distributed import Client

    try:
        # A Client without a scheduler tries for twenty seconds and prints. The check has a thread
        # of its own, since an event loop may be running in the caller's.
        with ThreadPoolExecutor(1) as thread:
            kind = thread.submit(asyncio.run, _kind(address)).result()
        if kind != "Scheduler":
            raise ValueError(f"it is a {kind}")
        client = Client(address, timeout=_ANSWER_WAIT_S, set_as_default=False)
    except Exception as error:  # of every layer below: names, sockets, certificates, protocols
        cause: BaseException = error
        while cause.__cause__ is not None and str(cause.__cause__):
            cause = cause.__cause__  # the lowest layer names the problem, the others the call
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


def in_worker(name: str) -> Callable[[Any], Any]:
    """A function of `dask_worker`, as a worker without this package can receive it.

    Dask sends a module's function by its name, and a worker that cannot import the module ends the
    connection: the run would wait for ever. A nested function is sent as code, and raises an
    ImportError there.
    """

    def call(argument: Any) -> Any:
        from importlib import import_module

        module = import_module("dubins_study.experiments.engines.dask_worker")
        return getattr(module, name)(argument)

    return call


def mismatch(versions: Mapping[str, Any]) -> str | None:
    """Why the machines of a cluster cannot work with this one: Python's or Dask's versions.

    Args:
        versions: as `distributed.Client.get_versions` returns them.
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
