"""A connection to a Dask scheduler, or one sentence that says why there is none."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any

from dubins_study.experiments.isolation.pool import RunError
from dubins_study.solvers.reply import exception_text

_ANSWER_WAIT_S = 10.0
# loggers that print what exceptions say as well
_LOGGERS = ("distributed", "tornado", "asyncio")


def installed_version() -> str:
    """The version of `distributed`.

    Raises:
        RunError: if it is not installed.
    """
    try:
        import distributed
    except ImportError as error:
        raise RunError(
            f"engine 'dask' needs Dask: pip install 'dubins-study[dask]' ({error})"
        ) from None
    return str(distributed.__version__)


@contextmanager
def quiet_loggers() -> Iterator[None]:
    """Dask's loggers are silent; they have their levels again at the end."""
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def connected(address: str) -> Iterator[Any]:
    """A client of a scheduler.

    Raises:
        RunError: if no scheduler answers, or one of other versions.
    """
    from distributed import Client

    try:
        # a Client without a scheduler tries for twenty seconds and prints; asked in a thread, since
        # an event loop may be running in the caller's
        with ThreadPoolExecutor(1) as thread:
            kind = thread.submit(asyncio.run, _kind(address)).result()
        if kind != "Scheduler":
            raise ValueError(f"it is a {kind}")
        client = Client(address, timeout=_ANSWER_WAIT_S, set_as_default=False)
    except Exception as error:  # of every layer below: names, sockets, certificates, protocols
        raise RunError(
            f"no Dask scheduler answers at {address!r} ({_cause(error)}); expected an address such "
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


def _cause(error: BaseException) -> str:
    """The message of the lowest layer, which names the problem; the layers above name the call."""
    if error.__cause__ is not None and str(error.__cause__):
        return _cause(error.__cause__)
    return exception_text(error) if str(error) else f"nothing came within {_ANSWER_WAIT_S:g} s"


async def _kind(address: str) -> str:
    """The type of Dask node at an address."""
    from distributed.core import rpc
    from distributed.security import Security

    certificates = Security().get_connection_args("client")
    node = rpc(address, timeout=_ANSWER_WAIT_S, connection_args=certificates)
    async with asyncio.timeout(_ANSWER_WAIT_S + 1), node:
        return str((await node.identity())["type"])


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
