"""Functions called in Dask's workers, and what comes back or went wrong on the way."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from dubins_study.experiments.engines.work_unit import Chunk, Returned
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.solvers.attempt import told

# s for rows to arrive from where they were solved
_FETCH = 30.0

LOST = "the connection to the Dask scheduler is lost; the rows written so far are kept"


def there(name: str) -> Callable[[Any], Any]:
    """A function of `experiments.engines.dask_worker`, as a worker without our packages can receive it.

    One that is sent by its module's name ends the connection of such a worker, and the run would
    wait for ever. A function within a function is sent as it is, and raises an ImportError there.
    """

    def ask(sent: Any) -> Any:
        from importlib import import_module

        return getattr(import_module("dubins_study.experiments.engines.dask_worker"), name)(sent)

    return ask


def everywhere(client: Any, name: str, argument: str) -> None:
    """Call such a function in every worker of a client's cluster."""
    with suppress(Exception):  # workers that are going, or without our packages
        client.run(there(name), argument, on_error="ignore")


def returned(future: Any, chunk: Chunk) -> Returned:
    """What a worker returned for a chunk.

    Raises:
        RunError: if there is nothing and will be nothing.
        TimeoutError: if it does not arrive in time.
    """
    from distributed import KilledWorker

    if future.status == "cancelled":
        raise RunError(LOST)
    try:
        # made anew: a worker of another version may return something else
        return Returned(*future.result(timeout=_FETCH))
    except TimeoutError:
        raise
    except KilledWorker as error:
        raise RunError(
            f"{error.allowed_failures + 1} Dask workers ended while they solved the same chunk of "
            f"{chunk.cells} cells, the last one at {error.last_worker.address}; the rows written "
            "so far are kept"
        ) from None
    except Exception as error:  # whatever Dask raises, here or there
        raise RunError(_explained(error)) from None


def _explained(error: Exception) -> str:
    said = told(error.__cause__ if isinstance(error.__cause__, Exception) else error)
    if isinstance(error, ImportError | AttributeError) or "deserializ" in str(error):
        return (
            f"dubins-study is not on a Dask worker, or of another version ({said}); expected the "
            "same versions of it, of Python and of Dask there as here"
        )
    return f"a Dask worker failed: {said}; the rows written so far are kept"
