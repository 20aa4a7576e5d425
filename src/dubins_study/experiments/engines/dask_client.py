"""A connection to a Dask scheduler, or one sentence that says why there is none."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any

from dubins_study.experiments.isolation.pool import RunError
from dubins_study.solvers.attempt import told

_ANSWER = 10.0  # s for a scheduler to answer


def installed() -> str:
    try:
        import distributed
    except ImportError as error:
        raise RunError(
            f"engine 'dask' needs Dask: pip install 'dubins-study[dask]' ({error})"
        ) from None
    return str(distributed.__version__)


# who tells on stderr what is told by exceptions as well
_LOUD = ("distributed", "tornado", "asyncio")


@contextmanager
def quiet() -> Iterator[None]:
    loggers = [logging.getLogger(name) for name in _LOUD]
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
        RunError: if it does not answer, or is of another version.
    """
    from distributed import Client

    try:
        # a Client that cannot begin complains for twenty seconds and on stderr; a thread, since the
        # caller's may have an event loop that runs
        with ThreadPoolExecutor(1) as aside:
            kind = aside.submit(asyncio.run, _kind(address)).result()
        if kind != "Scheduler":
            raise ValueError(f"it is a {kind}")
        client = Client(address, timeout=_ANSWER, set_as_default=False)
    except Exception as error:  # of every layer below: names, sockets, certificates, protocols
        raise RunError(
            f"no Dask scheduler answers at {address!r} ({_said(error)}); expected an address such "
            "as tcp://127.0.0.1:8786, or tls://... and certificates (see docs/scaling.md)"
        ) from None
    try:
        problem = mismatch(client.get_versions())
        if problem:
            raise RunError(problem)
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=_ANSWER)


def _said(error: BaseException) -> str:
    if error.__cause__ is not None and str(error.__cause__):
        return _said(error.__cause__)  # the lower layer names what is wrong, the upper the call
    return told(error) if str(error) else f"nothing came within {_ANSWER:g} s"


async def _kind(address: str) -> str:
    """What answers at an address."""
    from distributed.core import rpc
    from distributed.security import Security

    known = Security().get_connection_args("client")
    patient = rpc(address, timeout=_ANSWER, connection_args=known)
    async with asyncio.timeout(_ANSWER + 1), patient as there:
        return str((await there.identity())["type"])


def mismatch(versions: Mapping[str, Any]) -> str | None:
    """Why the machines of a cluster cannot work with this one: Python's or Dask's versions.

    Args:
        versions: as `distributed.Client.get_versions` returns them.
    """
    own = _release(versions["client"])
    others = {"the Dask scheduler": versions["scheduler"]}
    others |= {f"the Dask worker {name}": found for name, found in versions["workers"].items()}
    for who, found in others.items():
        for what, version in _release(found).items() if found else ():
            if version != own[what]:
                return f"{who} has {what} {version}; expected {own[what]}, as here"
    return None


def _release(found: Mapping[str, Any]) -> dict[str, str]:
    packages = found["packages"]
    python = ".".join(str(packages["python"]).split(".")[:2])
    return {"Python": python, "distributed": str(packages["distributed"])}
